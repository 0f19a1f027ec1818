"""As of when the belt is known: a belt ages while nobody measures it."""

from collections.abc import Callable


class BeliefAge:
    """Time since what is known of the belt was of the present.

    Parameters
    ----------
    steady : callable
        A steady clock [s].
    """

    def __init__(self, steady: Callable[[], float]) -> None:
        self._steady = steady
        self.renew()

    def renew(self) -> None:
        """Take note that what is known is known of now."""
        self._as_of = self._steady()

    @property
    def seconds(self) -> float:
        """The age [s]."""
        return self._steady() - self._as_of
