"""Jumps of the stamps: believed once several follow each other, forwards or backwards."""

import math

_JUMPS_TO_BELIEVE = 3
_LONGER, _SHORTER = 1.5, 0.5  # intervals, so that jitter decides nothing
_SECONDS = 1e-9


class TimeJumps:
    """Counts stamps that are far from the last one used, and near to each other.

    Where samples come more slowly than the greatest gap, each of them jumps ahead. Once some have
    been believed, the next at such an interval is believed at once, until they come fast again.
    """

    def __init__(self) -> None:
        self._pace = 0.0  # interval [s] of the stamps that were believed last
        self.forget()

    def forget(self, interval: float = math.inf) -> None:
        """Take the next jump for the first, after a step of `interval` [s] that was none."""
        self._stamp_ns: int | None = None
        self._count = 0
        if interval < _SHORTER * self._pace:
            self._pace = 0.0

    def believed(self, stamp_ns: int, greatest_gap: float, since_used: float) -> bool:
        """Whether this stamp [ns], far off as it is, is believed.

        Stamps that went back follow each other if they are not farther apart than `greatest_gap`
        [s]; those ahead need only rise.

        Parameters
        ----------
        stamp_ns : int
        greatest_gap : float
            Between measurements [s].
        since_used : float
            Time from the last stamp that was used to this one [s].
        """
        forward = since_used > 0.0
        if forward and since_used <= _LONGER * self._pace:
            return True
        since = None if self._stamp_ns is None else (stamp_ns - self._stamp_ns) * _SECONDS
        if since is not None and -greatest_gap <= since <= 0.0:  # the same again, or one too late
            return False
        if since is not None and since > 0.0 and (forward or since <= greatest_gap):
            self._count += 1
            self._pace = since
        else:
            self._count = 1
        self._stamp_ns = stamp_ns
        return self._count >= _JUMPS_TO_BELIEVE
