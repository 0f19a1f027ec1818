"""How many messages are missing, by the stamps of those that came.

What is lost on a network, or dropped from a full queue, leaves no trace in ROS but a longer
interval between two stamps. It shows where one sender is steady: of one that sends when something
changes, or of several on one topic, nothing can be told.
"""

import math
from statistics import median

_SECONDS = 1e-9
_FEWEST = 10  # intervals from which anything is told
_MOST = 10_000  # that are kept in a period
_SHORT = 0.1  # share of the intervals that are surely without a loss, where any are
_EVEN = 0.25  # of the sender's interval, by which one may differ from its multiples ...
_MOSTLY = 0.9  # ... and the share of all that must not differ by more
_LOSS = 1.5  # of the sender's interval, from which on one is missing
_PAUSE = 1.0  # [s] A longer interval is a pause, or another run.


class Missing:
    """Counts what is missing of one topic, period by period."""

    def __init__(self) -> None:
        self._last_ns: int | None = None
        self._begin()

    def _begin(self) -> None:
        self._intervals: list[float] = []
        self._late = 0

    def hear(self, stamp_ns: int) -> None:
        """Hear of a message as it comes."""
        last_ns, self._last_ns = self._last_ns, stamp_ns
        if last_ns is None:
            return
        interval = (stamp_ns - last_ns) * _SECONDS
        if -_PAUSE <= interval < 0.0:
            self._late += 1
            self._last_ns = last_ns
        elif 0.0 < interval <= _PAUSE and len(self._intervals) < _MOST:
            self._intervals.append(interval)

    def report(self) -> float:
        """Return how many are missing in the period that ends now; NaN: cannot be told."""
        intervals, late = sorted(self._intervals), self._late
        self._begin()
        if len(intervals) < _FEWEST:
            return math.nan
        shortest = intervals[int(_SHORT * len(intervals))]
        own = median(each for each in intervals if each < _LOSS * shortest)
        parts = [each / own for each in intervals]
        if sum(abs(part - round(part)) <= _EVEN for part in parts) < _MOSTLY * len(parts):
            return math.nan
        missing = sum(round(part) - 1 for part in parts if part >= _LOSS)
        return float(max(missing - late, 0))
