"""Fast input, pooled: what comes within some milliseconds is taken in as one, its mean.

A belt is far slower than the cycle of a servo drive. All that some milliseconds of white noise say
is in their mean, whose variance is that of one sample over their number; the filter's work then
grows with time, not with the number of messages.
"""

import math
from operator import attrgetter

from belt_ros.estimation.measurement import Measurement, Sensor

_SECOND = 1e9
_AHEAD = 1.5  # intervals, so that jitter decides nothing
_POSITIONS = (Sensor.DRIVER_POSITION, Sensor.DRIVEN_POSITION)
_values = attrgetter(*(sensor.name.lower() for sensor in Sensor))


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
        self._sum = [0.0] * len(Sensor)
        self._samples = [0] * len(Sensor)
        self._last = [math.nan] * len(Sensor)

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
        if self._pooled == 0:
            self._first_ns = measurement.stamp_ns
            self._sum = [0.0] * len(Sensor)
            self._samples = [0] * len(Sensor)
            self._last = [math.nan] * len(Sensor)
        self._pooled += 1
        for place, value in enumerate(_values(measurement)):
            if not math.isnan(value):
                self._sum[place] += value
                self._samples[place] += 1
                self._last[place] = value

    def _mean(self, stamp_ns: int) -> Measurement:
        """Return what has been pooled; of angles, which wrap, the last."""
        values = [
            total / count if count else math.nan
            for total, count in zip(self._sum, self._samples, strict=True)
        ]
        samples = [float(max(count, 1)) for count in self._samples]
        for place in _POSITIONS:
            values[place], samples[place] = self._last[place], 1.0
        pooled, self._pooled = self._pooled, 0
        return Measurement(stamp_ns, *values, samples=tuple(samples), pooled=pooled)
