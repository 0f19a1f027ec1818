"""While nothing happens, measurements wait for each other, and are taken in as one.

A drive that runs steadily says the same again and again. All that a tenth of a second of it says is
in the mean, and the filter, with all its members, moves ten times a second instead of a hundred.
Nothing is given away by that: each measurement is held against what the filter's last step lets
expect as soon as it comes, and so is the mean of all that wait. What is off by more than noise ends
the lull, and all that waits is taken in at once. Loads do not; they are taken in but once a second.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.measurement import Measurement, unwrapped
from belt_ros.estimation.span import Span

_Floats = NDArray[np.float64]
_LONGEST = 0.1  # [s] that a measurement waits ...
_HOLE = 0.15  # ... but for one that none follows in time; they are not averaged across the hole
_MOST = 100  # measurements that wait
_AHEAD = 1.5  # intervals, so that jitter decides nothing
_CALM_BEFORE = 2.0  # [s] of calm before a lull ...
_CALM_AGAIN = 0.5  # ... and before it goes on after a single reading that was off
# Squared deviation, normalised, that is no noise: of one reading, and of the mean of all that wait.
_OFF, _MEAN_OFF = 16.0, 9.0
# [s] Traction that changes while nothing seems to happen does so slowly. Taken to change as fast as
# it may, members in which it does would be too wide by the end of a lull to hear what it says.
_UNNOTICED = 0.01
_READ = 4  # speeds and torques: the first sensors ...
_POSITIONS = 4  # ... then the positions of the pulleys, whose speeds are 0 and 1
_SECOND, _SECONDS = 1e9, 1e-9


class Expected(NamedTuple):
    """Both speeds and both torques, as the filter expects them to stay: means and variances."""

    means: tuple[float, ...]  # (4,) in the order of `Sensor`
    variances: tuple[float, ...]  # (4,)


class Lull:
    """Measurements that wait while nothing happens.

    Parameters
    ----------
    turns : tuple of float
        One turn of either joint, seen at its pulley [rad]; angles wrap by it.
    noise : ndarray
        (2, 9) from `SensorNoise.noise_rows`.
    """

    def __init__(self, turns: tuple[float, float], noise: _Floats) -> None:
        self._span = Span(_LONGEST, turns)
        self._turns = turns
        self._last_ns: int | None = None
        self._angles: list[tuple[int, float] | None] = [None, None]  # last read, and when [ns]
        self._waiting: list[Measurement] = []
        self._expected: Expected | None = None
        self._calm = 0.0  # [s]
        self._since_off = 0.0  # [s] since a reading was off
        self._off = [0.0] * _READ  # of those that wait, from what is expected, added up ...
        self._samples = [0.0] * _READ  # ... and how many that were
        self.retune(noise)

    def retune(self, noise: _Floats) -> None:
        """Go on with other noise."""
        self._noise = tuple(zip(*noise.tolist(), strict=True))

    @property
    def waits(self) -> bool:
        """Whether measurements wait."""
        return bool(self._waiting)

    def expect(self, expected: Expected | None, dt: float) -> None:
        """Hear what the filter expects after a step of `dt` [s]; None while it is not calm."""
        self._since_off += dt
        self._calm = 0.0 if expected is None else self._calm + dt
        self._expected = expected if self._calm >= _CALM_BEFORE else None
        if self._expected is not None:
            self._off = [0.0] * _READ
            self._samples = [0.0] * _READ

    def take(self, measurement: Measurement) -> tuple[Measurement, ...]:
        """Take in a measurement, later than those before; return what the filter is to take in.

        Nothing if it waits; the mean of all that wait; or all of them, one by one, if something
        may have happened.
        """
        last_ns, self._last_ns = self._last_ns, measurement.stamp_ns
        expected = self._expected
        leaps = self._leaps(measurement, expected)
        if expected is None:
            return (measurement,)
        if self._waiting and measurement.stamp_ns - self._waiting[0].stamp_ns > _HOLE * _SECOND:
            return *self._all(), measurement
        self._waiting.append(measurement)
        if leaps or self._is_off(measurement, expected):
            return self._suspicious()
        if not self._is_full(measurement.stamp_ns, last_ns):
            return ()
        return self._suspicious() if self._are_off(expected) else (self._mean(),)

    def end(self) -> tuple[Measurement, ...]:
        """End the lull; return all that has waited."""
        self._calm = 0.0
        return self._all()

    def _suspicious(self) -> tuple[Measurement, ...]:
        again = self._since_off < _CALM_BEFORE
        self._calm = 0.0 if again else _CALM_BEFORE - _CALM_AGAIN
        self._since_off = 0.0
        return self._all()

    def _is_full(self, stamp_ns: int, last_ns: int | None) -> bool:
        """Whether the next measurement would wait for too long."""
        if last_ns is None:
            return True
        interval = stamp_ns - last_ns
        longest = self._waiting[0].stamp_ns + _LONGEST * _SECOND
        return stamp_ns + _AHEAD * interval > longest or len(self._waiting) >= _MOST

    def _all(self) -> tuple[Measurement, ...]:
        waiting, self._waiting = self._waiting, []
        self._expected = None
        return tuple(waiting)

    def _mean(self) -> Measurement:
        waiting, self._waiting = self._waiting, []
        if len(waiting) == 1:
            return waiting[0]
        for measurement in waiting:
            self._span.add(measurement)
        return replace(self._span.mean(), change=_UNNOTICED)

    def _is_off(self, measurement: Measurement, expected: Expected) -> bool:
        """Whether a reading is not what is expected."""
        readings = (*measurement.speeds, *measurement.torques)
        for place, reading in enumerate(readings):
            if math.isnan(reading):
                continue
            samples = measurement.samples[place] if measurement.samples else 1.0
            off = reading - expected.means[place]
            self._off[place] += samples * off
            self._samples[place] += samples
            if off * off > _OFF * self._variance(place, samples, expected):
                return True
        return False

    def _are_off(self, expected: Expected) -> bool:
        """Whether the mean of all readings that wait is not what is expected."""
        for place, (total, samples) in enumerate(zip(self._off, self._samples, strict=True)):
            if samples > 0.0:
                off = total / samples
                if off * off > _MEAN_OFF * self._variance(place, samples, expected):
                    return True
        return False

    def _variance(self, place: int, samples: float, expected: Expected) -> float:
        """Variance of the mean of some readings about what is expected."""
        proportional, constant = self._noise[place]
        noise: float = proportional * expected.means[place] ** 2 + constant
        return expected.variances[place] + noise / samples

    def _leaps(self, measurement: Measurement, expected: Expected | None) -> bool:
        """Whether a position is not where the speed has led since that pulley's last."""
        leaps = False
        for pulley, now in enumerate(measurement.positions):
            if math.isnan(now):
                continue
            last, self._angles[pulley] = self._angles[pulley], (measurement.stamp_ns, now)
            if expected is None or last is None:
                continue
            dt = (measurement.stamp_ns - last[0]) * _SECONDS
            way = expected.means[pulley] * dt
            noise = self._noise[_POSITIONS + pulley][1]
            variance = 2.0 * noise + expected.variances[pulley] * dt * dt
            off = unwrapped(last[1], now, way, self._turns[pulley]) - last[1] - way
            leaps = leaps or off * off > _OFF * variance
        return leaps
