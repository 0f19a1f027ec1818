"""Jumps of the stamps: believed once several follow each other, forwards or backwards."""

_JUMPS_TO_BELIEVE = 3
_SECONDS = 1e-9


class TimeJumps:
    """Counts stamps that are far from the last one used, and near to each other."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Take the next jump for the first."""
        self._stamp_ns: int | None = None
        self._count = 0

    def believed(self, stamp_ns: int, greatest_gap: float, *, forward: bool) -> bool:
        """Whether this stamp [ns], far off as it is, is believed.

        Stamps that went back follow each other if they are not farther apart than `greatest_gap`
        [s]; those ahead need only rise, since samples may come slower than that.
        """
        since = None if self._stamp_ns is None else (stamp_ns - self._stamp_ns) * _SECONDS
        follows = since is not None and since > 0.0 and (forward or since <= greatest_gap)
        self._count = self._count + 1 if follows else 1
        self._stamp_ns = stamp_ns
        return self._count >= _JUMPS_TO_BELIEVE
