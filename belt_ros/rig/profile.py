"""A quantity scripted over time: straight lines between points, held before and after them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

_Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Profile:
    """Points (time [s], value) in the order of time; two at the same time make a step."""

    times: tuple[float, ...]
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        assert self.times
        assert len(self.times) == len(self.values)

    @classmethod
    def constant(cls, value: float) -> "Profile":
        """Return a profile that never changes."""
        return cls((0.0,), (value,))

    def at(self, times: _Floats) -> _Floats:
        """Values at `times` (n,); at a step, those after it."""
        values: _Floats = np.interp(times, *self._points)
        return values

    @cached_property
    def _points(self) -> tuple[_Floats, _Floats]:
        return np.array(self.times, dtype=float), np.array(self.values, dtype=float)

    def with_ramp(self, start: float, target: float, duration: float) -> "Profile":
        """Return this profile with a ramp to `target` from `start` [s] on, lasting `duration` [s].

        What the profile said from `start` on gives way to the ramp, whose end is held.
        """
        begin = float(self.at(np.array([start]))[0])
        kept = sum(time <= start for time in self.times)
        return Profile(
            (*self.times[:kept], start, start + duration),
            (*self.values[:kept], begin, target),
        )
