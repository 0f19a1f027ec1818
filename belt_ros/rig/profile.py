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
        known_times, known_values = self._points
        if known_times.size == 1:
            return np.full_like(times, known_values[0])
        after = np.searchsorted(known_times, times, side="right")
        left = np.maximum(after - 1, 0)
        right = np.minimum(after, known_times.size - 1)
        width = known_times[right] - known_times[left]
        share = np.divide(
            times - known_times[left], width, out=np.zeros_like(times), where=width > 0.0
        )
        values: _Floats = known_values[left] + share * (known_values[right] - known_values[left])
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
