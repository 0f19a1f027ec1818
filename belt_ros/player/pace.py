"""When a message of a bag is due: bag time against a steady clock, at a rate, with pauses."""

_SECONDS = 1e-9


class Pace:
    """Bag time as it passes while playing. Knows no clock: `now` [s] is told.

    Parameters
    ----------
    rate : float
        Bag time per time [-], > 0.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._paused_at: float | None = None
        self.start(0, 0.0)

    def start(self, bag_ns: int, now: float) -> None:
        """Let the bag be at `bag_ns` [ns] at `now` [s]; it stays paused if it is."""
        self._bag_ns = bag_ns
        self._now = now
        if self._paused_at is not None:
            self._paused_at = now

    @property
    def paused(self) -> bool:
        """Whether bag time stands."""
        return self._paused_at is not None

    def toggle(self, now: float) -> None:
        """Pause, or go on."""
        if self._paused_at is None:
            self._paused_at = now
        else:
            self._now += now - self._paused_at
            self._paused_at = None

    def at(self, now: float) -> int:
        """Return the bag time [ns] at `now` [s]."""
        if self._paused_at is not None:
            now = self._paused_at
        return self._bag_ns + round((now - self._now) * self._rate / _SECONDS)

    def wait(self, bag_ns: int, now: float) -> float:
        """Return how long [s] after `now` the bag reaches `bag_ns`; infinite while paused."""
        if self._paused_at is not None:
            return float("inf")
        return (bag_ns - self._bag_ns) * _SECONDS / self._rate - (now - self._now)
