"""Bad messages are a suspicion: alarms of the belt wait for it, but not for ever."""


class Suspicion:
    """For how long so many messages have been bad, too few to call their sensor implausible.

    A sensor that fails is found out within a second or so, and until then its readings look like a
    belt that slips. One that has sent a bad message in three for longer does not speak against what
    the other messages say.
    """

    def __init__(self) -> None:
        self._suspected = 0.0  # [s]
        self._sound = 0.0  # [s] since anything was suspected

    def holds_back(self, dt: float, longest: float, sound_after: float, *, suspected: bool) -> bool:
        """Whether alarms of the belt have to wait.

        Parameters
        ----------
        dt : float
            Time since the last call [s], without gaps: what was not observed counts for nothing.
        longest : float
            Time [s] for which they wait at most.
        sound_after : float
            Time without suspicion [s] after which a new one is another one: shares of bad messages
            swing about any threshold.
        suspected : bool
            Whether there are so many bad messages now.
        """
        self._suspected += dt
        if not suspected:
            self._sound += dt
            if self._sound >= sound_after:
                self._suspected = 0.0
            return False
        self._sound = 0.0
        return self._suspected <= longest
