"""What goes wrong with readings and stamps."""

import math
import sys
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation import SensorLimits
from benchmarks.hostile.motion import Motion, Row

_Floats = NDArray[np.float64]
_SECOND_NS = 1_000_000_000
_LATEST = 2**31 - 1  # second that a stamp can carry
_RATES = (0.0, 1e-3, 1e-2, 0.05, 0.3)
_LARGEST = sys.float_info.max
SPECIAL = (
    *(math.nan, math.inf, -math.inf, 0.0, -0.0),
    *(5e-324, -5e-324, 1e-310, 1e-300, 1e308, -1e308, _LARGEST, -_LARGEST),
    *(1e9, -1e9, 1e12, -1e12, 1e15, 1e18, 1e30, 1e100, -1e100, 1e154, -1e155),
)
_BEYOND = (1.0 - 1e-15, 1.0, 1.0 + 1e-15, 0.5, -1.0, -1.0 + 1e-9, 0.1)  # of a limit
_SCALES = (-1.0, 0.0, 1e-6, 0.5, 2.0, 10.0, -10.0, 1e3, 1e6, 1e12)
_LASTING = 60  # messages, mean


class Spoiler:
    """Spoils some of the rows of a stream, each in its own way, at rates of its own.

    Parameters
    ----------
    limits : SensorLimits
    random : Generator
    """

    def __init__(self, limits: SensorLimits, random: np.random.Generator) -> None:
        self._random = random
        speed, torque, load = limits.greatest_speed, limits.greatest_torque, limits.greatest_load
        self._limits = np.array([speed, speed, torque, torque, 1e6, 1e6, load, load, load])
        self._of_values, self._of_stamps, self._of_clocks, self._of_sensors = (
            float(random.choice(_RATES)) for _ in range(4)
        )
        self._fault: Callable[[_Floats], None] | None = None
        self._left = 0

    def spoil(self, row: Row, motion: Motion) -> Row:
        """Return a row with what has gone wrong with it; the clock may jump for good."""
        random = self._random
        values = row.values
        self._last_faults(values)
        if random.random() < self._of_values:
            self._spoil_values(values)
        stamp_ns = row.stamp_ns
        if random.random() < self._of_stamps:
            stamp_ns = self._moved(stamp_ns)
        if random.random() < 0.05 * self._of_clocks:
            motion.stamp_ns = min(max(self._moved(motion.stamp_ns), 1), _LATEST * _SECOND_NS)
        return Row(stamp_ns, values)

    def _spoil_values(self, values: _Floats) -> None:
        random = self._random
        for at in random.choice(9, size=int(random.choice([1, 1, 2, 9])), replace=False):
            way = random.random()
            if way < 0.5:
                values[at] = random.choice(SPECIAL)
            elif way < 0.75:
                values[at] = random.choice(_BEYOND) * self._limits[at]
            else:
                with np.errstate(over="ignore", invalid="ignore"):
                    values[at] *= random.choice(_SCALES)

    def _last_faults(self, values: _Floats) -> None:
        """Let a sensor be stuck, missing, or of a wrong scale, for a while."""
        random = self._random
        self._left -= 1
        if self._left <= 0:
            self._fault = None
        if self._fault is None and random.random() < 0.1 * self._of_sensors:
            self._left = int(random.geometric(1.0 / _LASTING))
            self._fault = self._sensor_fault(values)
        if self._fault is not None:
            self._fault(values)

    def _sensor_fault(self, values: _Floats) -> Callable[[_Floats], None]:
        random = self._random
        at = np.flatnonzero(random.random(9) < 0.3)
        way = random.random()
        if way < 0.3:
            return _held(at, values[at].copy())
        if way < 0.5:
            return _held(at, np.full(len(at), math.nan))
        if way < 0.6:
            return _held(at, np.full(len(at), float(random.choice(SPECIAL))))
        return _scaled(at, float(random.choice(_SCALES)))

    def _moved(self, stamp_ns: int) -> int:
        """Return another stamp: the same, off by nanoseconds to years, or anywhere."""
        random = self._random
        way = random.random()
        if way < 0.1:
            return int(random.integers(-_LATEST - 1, _LATEST, endpoint=True)) * _SECOND_NS
        off = round(float(10.0 ** random.uniform(0.0, 17.5)))
        return stamp_ns + int(random.choice([-1, 1])) * off


def _held(at: NDArray[np.int64], held: _Floats) -> Callable[[_Floats], None]:
    def fault(values: _Floats) -> None:
        values[at] = held

    return fault


def _scaled(at: NDArray[np.int64], scale: float) -> Callable[[_Floats], None]:
    def fault(values: _Floats) -> None:
        with np.errstate(over="ignore", invalid="ignore"):
            values[at] *= scale

    return fault
