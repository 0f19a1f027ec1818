"""What some measurements that follow each other come to: their mean.

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
_FORGOTTEN = 3  # periods between two spans after which the one tells nothing of the other
# Angles, each with the pulley that it is of, which is also the place of its speed.
_ANGLES = {Sensor.DRIVER_POSITION: 0, Sensor.DRIVEN_POSITION: 1}
_TURN = 2.0 * math.pi
_ONE = (1.0,) * len(Sensor)
_NONE = (0.0,) * len(Sensor)
_values = attrgetter(*(sensor.name.lower() for sensor in Sensor))


class _Mean(NamedTuple):
    """What a span came to."""

    stamp_ns: int
    values: list[float]


class Span:
    """Measurements of one span of time after another, each turned into one; they may be means.

    Parameters
    ----------
    period : float
        Length of a span [s].
    turns : tuple of float
        One turn of either joint, seen at its pulley [rad]; angles wrap by it.

    Attributes
    ----------
    count : int
        How many have been added to the present span.
    pooled : int
        Of how many measurements these are the means.
    first_ns : int
        Stamp of the first of them [ns].
    """

    def __init__(self, period: float, turns: tuple[float, float] = (_TURN, _TURN)) -> None:
        self.period = period
        self.first_ns = 0
        self._turns = turns
        self._means: list[_Mean] = []  # of the last spans
        self._speeds = [0.0, 0.0]  # of either pulley, last read
        self.clear()

    def clear(self) -> None:
        """Forget what has been added."""
        self.count = 0
        self.pooled = 0
        self._sum_after_first = 0  # of all stamps, from the first [ns] ...
        self._sums_after_first = [0.0] * len(Sensor)  # ... and of those that have the value
        self._sum = [0.0] * len(Sensor)
        self._samples = [0.0] * len(Sensor)
        self._bent = [0.0] * len(Sensor)  # what the bending of means adds up to
        self._angles: dict[int, tuple[int, float]] = {}  # stamp and angle last read, unwrapped

    def add(self, measurement: Measurement) -> None:
        """Add a measurement, later than those before."""
        if self.count == 0:
            self.first_ns = measurement.stamp_ns
        self.count += 1
        self.pooled += measurement.pooled
        after_first = measurement.stamp_ns - self.first_ns
        self._sum_after_first += measurement.pooled * after_first
        samples = measurement.samples or _ONE
        for pulley, speed in enumerate(measurement.speeds):
            if not math.isnan(speed):
                self._speeds[pulley] = speed
        for place, value in enumerate(_values(measurement)):
            if not math.isnan(value):
                number = samples[place]
                self._sum[place] += number * self._continued(place, value, measurement)
                self._samples[place] += number
                self._sums_after_first[place] += number * after_first
                if measurement.bending:
                    self._bent[place] += number * measurement.bending[place]

    def _continued(self, place: int, value: float, measurement: Measurement) -> float:
        """Return a value; if it is an angle, with the whole turns since the one before."""
        if place not in _ANGLES:
            return value
        pulley = _ANGLES[Sensor(place)]
        if place in self._angles:
            stamp_ns, angle = self._angles[place]
            turned = self._speeds[pulley] * (measurement.stamp_ns - stamp_ns) * _SECONDS
            value = unwrapped(angle, value, turned, self._turns[pulley])
        self._angles[place] = measurement.stamp_ns, value
        return value

    def mean(self) -> Measurement:
        """Return what the span comes to, and begin the next one.

        The mean of angles is taken to be no better than one of them, for encoders step.
        """
        values = [
            total / count if count else math.nan
            for total, count in zip(self._sum, self._samples, strict=True)
        ]
        samples = [max(count, 1.0) for count in self._samples]
        lags = self._lags()
        for place, speed in _ANGLES.items():
            samples[place] = 1.0
            if lags[place] != 0.0 and not math.isnan(values[speed]):
                values[place] += values[speed] * lags[place]
        stamp_ns = self.first_ns + round(self._sum_after_first / self.pooled)
        bending = self._bending(_Mean(stamp_ns, values), lags)
        pooled = self.pooled
        self.clear()
        return Measurement(
            stamp_ns, *values, samples=tuple(samples), bending=bending, pooled=pooled
        )

    def _lags(self) -> list[float]:
        """How much later than each value's own the mean of all stamps is [s]."""
        middle = self._sum_after_first / self.pooled
        return [
            (middle - total / count) * _SECONDS if count else 0.0
            for total, count in zip(self._sums_after_first, self._samples, strict=True)
        ]

    def _bending(self, mean: _Mean, lags: list[float]) -> tuple[float, ...]:
        """Return the variance of what each value is off by, as far as two spans before tell."""
        last = self._means[-1].stamp_ns if self._means else mean.stamp_ns
        if not 0 <= mean.stamp_ns - last <= _FORGOTTEN * self.period * _SECOND:
            self._means = []
        self._means = [*self._means[-2:], mean]
        if len(self._means) < 3:
            return self._bent_before()
        oldest, older, _ = self._means
        early = (older.stamp_ns - oldest.stamp_ns) * _SECONDS
        late = (mean.stamp_ns - older.stamp_ns) * _SECONDS
        if not (early > 0.0 and late > 0.0):
            return self._bent_before()
        bent = _BENT * self.period**2
        off = []
        for a, b, c, lag in zip(oldest.values, older.values, mean.values, lags, strict=True):
            slope = (c - b) / late
            off.append(
                bent * 2.0 * abs(slope - (b - a) / early) / (late + early) + abs(slope * lag)
            )
        for place, speed in _ANGLES.items():  # which may have wrapped in between
            off[place] = bent * (mean.values[speed] - older.values[speed]) / late
        return tuple(
            before if math.isnan(each) else before + each * each
            for each, before in zip(off, self._bent_before() or _NONE, strict=True)
        )

    def _bent_before(self) -> tuple[float, ...]:
        """Return the variance of that kind which means had when they were added."""
        if not any(self._bent):
            return ()
        return tuple(
            bent / count if count else 0.0
            for bent, count in zip(self._bent, self._samples, strict=True)
        )
