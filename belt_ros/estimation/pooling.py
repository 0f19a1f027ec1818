"""Fast input, pooled: what comes within some milliseconds is taken in as one, its mean.

A belt is far slower than the cycle of a servo drive. All that some milliseconds of white noise say
is in their mean, whose variance is that of one sample over their number; the filter's work then
grows with time, not with the number of messages.

The mean is what was measured at the mean of the stamps; at the last of them, a speed that changes
would be wrong by half a span of its change, which is far more than its noise. Only what bends
within the span is off there, by f'' span^2 / 24 where it bends evenly. How much it bends, the means
of this span and of the two before it tell; twice that is allowed for, since a bend that sets in
within the span shows in full only later.
"""

import math
from operator import attrgetter

from belt_ros.estimation.measurement import Measurement, Sensor, unwrapped

_SECOND = 1e9
_AHEAD = 1.5  # intervals, so that jitter decides nothing
_SECONDS = 1e-9
_BENT = 1.0 / 12.0  # of f'' span^2
# Angles, each with the pulley that it is of, which is also the place of its speed.
_ANGLES = {Sensor.DRIVER_POSITION: 0, Sensor.DRIVEN_POSITION: 1}
_TURN = 2.0 * math.pi
_values = attrgetter(*(sensor.name.lower() for sensor in Sensor))


class Pool:
    """Means of consecutive measurements, in spans of `period` [s]; 0 hands on every one.

    A span ends with the last measurement to be expected in it, by the interval before, so that none
    waits for a message of the next. What comes at longer intervals passes untouched.

    Parameters
    ----------
    period : float
        Length of a span [s].
    turns : tuple of float
        One turn of either joint, seen at its pulley [rad]; angles wrap by it.
    """

    def __init__(self, period: float, turns: tuple[float, float] = (_TURN, _TURN)) -> None:
        self._turns = turns
        self.retune(period)
        self._last_ns: int | None = None
        self._first_ns = 0
        self._means: list[tuple[float, list[float]]] = []  # of the last spans: time [s], values
        self._clear()

    def _clear(self) -> None:
        self._pooled = 0
        self._after_first = 0  # sum of stamps, from the first [ns]
        self._sum = [0.0] * len(Sensor)
        self._samples = [0] * len(Sensor)
        self._angles: dict[int, tuple[int, float]] = {}  # stamp and angle last read, unwrapped

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
            left = (self._mean(),) if self._pooled else ()
            self._means = []
            return (*left, measurement)
        self._add(measurement)
        if measurement.stamp_ns + _AHEAD * interval <= self._first_ns + self._period_ns:
            return ()
        if self._pooled == 1:
            self._means = []
            self._clear()
            return (measurement,)
        return (self._mean(),)

    def _add(self, measurement: Measurement) -> None:
        if self._pooled == 0:
            self._first_ns = measurement.stamp_ns
        self._pooled += 1
        self._after_first += measurement.stamp_ns - self._first_ns
        for place, value in enumerate(_values(measurement)):
            if not math.isnan(value):
                self._sum[place] += self._continued(place, value, measurement)
                self._samples[place] += 1

    def _continued(self, place: int, value: float, measurement: Measurement) -> float:
        """Return a value; if it is an angle, with the whole turns since the one before."""
        if place not in _ANGLES:
            return value
        pulley = _ANGLES[Sensor(place)]
        if place in self._angles:
            stamp_ns, angle = self._angles[place]
            speed = measurement.speeds[pulley]
            turned = speed * (measurement.stamp_ns - stamp_ns) * _SECONDS
            turned = 0.0 if math.isnan(turned) else turned
            value = unwrapped(angle, value, turned, self._turns[pulley])
        self._angles[place] = measurement.stamp_ns, value
        return value

    def _mean(self) -> Measurement:
        """Return what has been pooled; that of angles is no better than one, for encoders step."""
        values = [
            total / count if count else math.nan
            for total, count in zip(self._sum, self._samples, strict=True)
        ]
        samples = [float(max(count, 1)) for count in self._samples]
        for place in _ANGLES:
            samples[place] = 1.0
        stamp_ns = self._first_ns + round(self._after_first / self._pooled)
        bending = self._bending(stamp_ns, values)
        pooled = self._pooled
        self._clear()
        return Measurement(
            stamp_ns, *values, samples=tuple(samples), bending=bending, pooled=pooled
        )

    def _bending(self, stamp_ns: int, values: list[float]) -> tuple[float, ...]:
        """Return the variance of what each mean is off by, as far as two spans before tell."""
        now = stamp_ns * _SECONDS
        self._means = [*self._means[-2:], (now, values)]
        if len(self._means) < 3:
            return ()
        (first, oldest), (second, older), _ = self._means
        late, early = now - second, second - first
        off = [
            2.0 * _BENT * late**2 * ((c - b) / late - (b - a) / early) / (late + early)
            for a, b, c in zip(oldest, older, values, strict=True)
        ]
        for place, speed in _ANGLES.items():  # which may have wrapped in between
            off[place] = _BENT * late * (values[speed] - older[speed])
        return tuple(0.0 if math.isnan(each) else each * each for each in off)
