"""ROS time that goes back, and what was on its way then."""

from collections.abc import Callable

_SECONDS = 1e-9


class ClockJump:
    """Tells measurements of before a jump from those after it.

    Parameters
    ----------
    steady : callable
        A steady clock [s].
    """

    def __init__(self, steady: Callable[[], float]) -> None:
        self._steady = steady
        self._until: float | None = None  # on the steady clock, while late ones may come

    def happen(self, gap: float) -> None:
        """Take note that ROS time has gone back; what is late comes within `gap` [s]."""
        self._until = self._steady() + gap

    def is_late(self, stamp_ns: int, now_ns: int, gap: float) -> bool:
        """Whether a stamp is of before the jump, ahead of ROS time by more than `gap` [s].

        Nothing is, once a stamp fits; nor for ever, for the sender's clock may be another one.
        """
        if self._until is None:
            return False
        late = ahead(stamp_ns, now_ns, gap) and self._steady() <= self._until
        if not late:
            self._until = None
        return late


def ahead(stamp_ns: int, now_ns: int, gap: float) -> bool:
    """Whether a stamp is ahead of ROS time, `now_ns` [ns], by more than `gap` [s]."""
    return (stamp_ns - now_ns) * _SECONDS > gap
