"""Which share of the measurements is turned away, lately."""

import math

_MEMORY = 0.5  # [s] ...
_FEWEST = 5.0  # ... and samples at the least: no single one makes a verdict
_SECONDS = 1e-9


class Refusals:
    """Counts measurements that were used and that were not; both are forgotten alike.

    Numbers are counted rather than times: where measurements are pooled, one that is refused is
    later than the mean of those around it that are used.

    Attributes
    ----------
    newest_ns : int or None
        Latest stamp that was counted.
    """

    def __init__(self) -> None:
        self._used = 0.0
        self._refused = 0.0
        self.newest_ns: int | None = None

    @property
    def share(self) -> float:
        """Share of those that were refused, of five at the least."""
        return self._refused / max(self._used + self._refused, _FEWEST)

    def count(self, stamp_ns: int, number: int = 1, *, refused: bool) -> None:
        """Take in that `number` measurements were used, or refused, stamped `stamp_ns`."""
        if self.newest_ns is not None and stamp_ns > self.newest_ns:
            aged = math.exp((self.newest_ns - stamp_ns) * _SECONDS / _MEMORY)
            kept = max(aged, (1.0 - 1.0 / _FEWEST) ** number)
            self._used *= kept
            self._refused *= kept
        self.newest_ns = max(stamp_ns, self.newest_ns or stamp_ns)
        if refused:
            self._refused += number
        else:
            self._used += number
