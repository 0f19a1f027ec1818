"""Fast input, pooled: what comes within some milliseconds is taken in as one, its mean.

A belt is far slower than the cycle of a servo drive. All that some milliseconds of white noise say
is in their mean, whose variance is that of one sample over their number; the filter's work then
grows with time, not with the number of messages.
"""

import numpy as np

from belt_ros.estimation.measurement import Measurement, Sensor

_SECOND = 1e9
_AHEAD = 1.5  # intervals, so that jitter decides nothing
_POSITIONS = [Sensor.DRIVER_POSITION, Sensor.DRIVEN_POSITION]


class Pool:
    """Means of consecutive measurements, in spans of `period` [s]; 0 hands on every one.

    A span ends with the last measurement to be expected in it, by the interval before, so that none
    waits for a message of the next. What comes at longer intervals passes untouched.
    """

    def __init__(self, period: float) -> None:
        self.retune(period)
        self._last_ns: int | None = None
        self._first_ns = 0
        self._pooled = 0
        self._sum = np.zeros(len(Sensor))
        self._samples = np.zeros(len(Sensor))
        self._positions = np.zeros(len(_POSITIONS))

    def retune(self, period: float) -> None:
        """Pool in spans of another `period` [s]; what has been pooled leaves with what follows."""
        self._period_ns = round(period * _SECOND)

    def take(self, measurement: Measurement) -> tuple[Measurement, ...]:
        """Take in a measurement; return what is to be handed on: nothing, a mean, or it untouched.

        Where time goes back, stands still or makes a gap, what has been pooled goes before it.
        """
        before, self._last_ns = self._last_ns, measurement.stamp_ns
        if before is None:
            return (measurement,)
        interval = measurement.stamp_ns - before
        if not 0 < interval < self._period_ns:
            left = (self._mean(before),) if self._pooled else ()
            return (*left, measurement)
        self._add(measurement)
        if measurement.stamp_ns + _AHEAD * interval <= self._first_ns + self._period_ns:
            return ()
        if self._pooled == 1:
            self._pooled = 0
            return (measurement,)
        return (self._mean(measurement.stamp_ns),)

    def _add(self, measurement: Measurement) -> None:
        values = measurement.values()
        there = ~np.isnan(values)
        if self._pooled == 0:
            self._first_ns = measurement.stamp_ns
            self._sum[:] = self._samples[:] = 0.0
        self._sum[there] += values[there]
        self._samples += there
        self._pooled += 1
        positions = values[_POSITIONS]
        if self._pooled > 1:
            positions = np.where(np.isnan(positions), self._positions, positions)
        self._positions = positions

    def _mean(self, stamp_ns: int) -> Measurement:
        """Return what has been pooled; of angles, which wrap, the last."""
        with np.errstate(invalid="ignore"):
            values = self._sum / self._samples
        values[_POSITIONS] = self._positions
        samples = np.maximum(self._samples, 1.0)
        samples[_POSITIONS] = 1.0
        pooled, self._pooled = self._pooled, 0
        return Measurement(
            stamp_ns, *values.tolist(), samples=tuple(samples.tolist()), pooled=pooled
        )
