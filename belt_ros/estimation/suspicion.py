"""A mere suspicion of a sensor: alarms of the belt wait for it, but not for ever."""

_SECONDS = 1e-9


class Suspicion:
    """How long sensors have been suspected without being called implausible.

    A sensor that fails is found out within a second or so, and until then its readings look like a
    belt that slips. What is suspected for longer, such as one that sends a bad message in three,
    does not speak against what the other readings say.
    """

    def __init__(self) -> None:
        self._since_ns: int | None = None
        self._sound_ns: int | None = None  # from when on nothing has been suspected

    def holds_back(
        self, stamp_ns: int, longest: float, sound_after: float, *, suspected: bool
    ) -> bool:
        """Whether alarms of the belt have to wait, at `stamp_ns`.

        Parameters
        ----------
        stamp_ns : int
            Now [ns].
        longest : float
            Time [s] for which they wait at most.
        sound_after : float
            Time without suspicion [s] after which a new one is another one: shares of bad messages
            swing about any threshold.
        suspected : bool
            Whether a sensor is suspected now.
        """
        if not suspected:
            self._sound_ns = stamp_ns if self._sound_ns is None else self._sound_ns
            if (stamp_ns - self._sound_ns) * _SECONDS >= sound_after:
                self._since_ns = None
            return False
        self._sound_ns = None
        self._since_ns = stamp_ns if self._since_ns is None else self._since_ns
        return (stamp_ns - self._since_ns) * _SECONDS <= longest
