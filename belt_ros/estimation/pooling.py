"""Fast input, pooled: what comes within some milliseconds is taken in as one, its mean.

A belt is far slower than the cycle of a servo drive. All that some milliseconds of white noise say
is in their mean, whose variance is that of one sample over their number; the filter's work then
grows with time, not with the number of messages.

The mean is what was measured at the mean of the stamps; at the last of them, a speed that changes
would be wrong by half a span of its change, which is far more than its noise. Only what bends
within the span is off there, by f'' span^2 / 24 where it bends evenly; and what is not in every
message, by what it changes from the mean of its own stamps. How much it bends and changes, the
means of this span and of the two before it tell. Twice the bend is allowed for, since one that sets
in within the span shows in full only later.
"""

import math
from operator import attrgetter
from typing import NamedTuple

from belt_ros.estimation.measurement import Measurement, Sensor, unwrapped

_SECOND = 1e9
_SECONDS = 1e-9
_BENT = 1.0 / 12.0  # of f'' span^2
_AHEAD = 1.5  # intervals, so that jitter decides nothing
_FORGOTTEN = 3  # periods between two spans after which the one tells nothing of the other
# Angles, each with the pulley that it is of, which is also the place of its speed.
_ANGLES = {Sensor.DRIVER_POSITION: 0, Sensor.DRIVEN_POSITION: 1}
_TURN = 2.0 * math.pi
_values = attrgetter(*(sensor.name.lower() for sensor in Sensor))


class _Mean(NamedTuple):
    """What a span came to."""

    stamp_ns: int
    values: list[float]


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
        self._newest_ns: int | None = None  # of those that were pooled
        self._first_ns = 0
        self._means: list[_Mean] = []  # of the last spans
        self._clear()

    def _clear(self) -> None:
        self._pooled = 0
        self._sum_after_first = 0  # of all stamps, from the first [ns] ...
        self._sums_after_first = [0] * len(Sensor)  # ... and of those that have the value
        self._sum = [0.0] * len(Sensor)
        self._samples = [0] * len(Sensor)
        self._angles: dict[int, tuple[int, float]] = {}  # stamp and angle last read, unwrapped

    def retune(self, period: float) -> None:
        """Pool in spans of another `period` [s]; what has been pooled leaves with what follows."""
        self._period_ns = round(period * _SECOND)

    def overtaken(self, stamp_ns: int) -> bool:
        """Whether a stamp is not later than the last one pooled, though perhaps than their mean."""
        newest_ns = self._newest_ns
        return newest_ns is not None and 0 <= newest_ns - stamp_ns < self._period_ns

    def take(self, measurement: Measurement) -> tuple[Measurement, ...]:
        """Take in a measurement; return what is to be handed on: nothing, a mean, or it untouched.

        Where time goes back, stands still or makes a gap, what has been pooled goes before it.
        """
        before, self._last_ns = self._last_ns, measurement.stamp_ns
        if before is None:
            return (measurement,)
        interval = measurement.stamp_ns - before
        if not 0 < interval < self._period_ns:
            return (*((self._mean(),) if self._pooled else ()), measurement)
        self._add(measurement)
        if measurement.stamp_ns + _AHEAD * interval <= self._first_ns + self._period_ns:
            return ()
        if self._pooled == 1:
            self._clear()
            return (measurement,)
        return (self._mean(),)

    def _add(self, measurement: Measurement) -> None:
        if self._pooled == 0:
            self._first_ns = measurement.stamp_ns
        self._newest_ns = measurement.stamp_ns
        self._pooled += 1
        after_first = measurement.stamp_ns - self._first_ns
        self._sum_after_first += after_first
        for place, value in enumerate(_values(measurement)):
            if not math.isnan(value):
                self._sum[place] += self._continued(place, value, measurement)
                self._samples[place] += 1
                self._sums_after_first[place] += after_first

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
        lags = self._lags()
        for place, speed in _ANGLES.items():
            samples[place] = 1.0
            if lags[place] != 0.0 and not math.isnan(values[speed]):
                values[place] += values[speed] * lags[place]
        stamp_ns = self._first_ns + round(self._sum_after_first / self._pooled)
        bending = self._bending(_Mean(stamp_ns, values), lags)
        pooled = self._pooled
        self._clear()
        return Measurement(
            stamp_ns, *values, samples=tuple(samples), bending=bending, pooled=pooled
        )

    def _lags(self) -> list[float]:
        """How much later than each value's own the mean of all stamps is [s]."""
        middle = self._sum_after_first / self._pooled
        return [
            (middle - total / count) * _SECONDS if count else 0.0
            for total, count in zip(self._sums_after_first, self._samples, strict=True)
        ]

    def _bending(self, mean: _Mean, lags: list[float]) -> tuple[float, ...]:
        """Return the variance of what each value is off by, as far as two spans before tell."""
        last = self._means[-1].stamp_ns if self._means else mean.stamp_ns
        if not 0 <= mean.stamp_ns - last <= _FORGOTTEN * self._period_ns:
            self._means = []
        self._means = [*self._means[-2:], mean]
        if len(self._means) < 3:
            return ()
        oldest, older, _ = self._means
        early = (older.stamp_ns - oldest.stamp_ns) * _SECONDS
        late = (mean.stamp_ns - older.stamp_ns) * _SECONDS
        if not (early > 0.0 and late > 0.0):
            return ()
        bent = _BENT * (self._period_ns * _SECONDS) ** 2
        off = []
        for a, b, c, lag in zip(oldest.values, older.values, mean.values, lags, strict=True):
            slope = (c - b) / late
            off.append(
                bent * 2.0 * abs(slope - (b - a) / early) / (late + early) + abs(slope * lag)
            )
        for place, speed in _ANGLES.items():  # which may have wrapped in between
            off[place] = bent * (mean.values[speed] - older.values[speed]) / late
        return tuple(0.0 if math.isnan(each) else each * each for each in off)
