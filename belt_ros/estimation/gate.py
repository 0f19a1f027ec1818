"""What no load step explains is turned away, until it has come too often: then the filter is wrong.

Where sensors speak in turns, measurements between those that are turned away may say nothing of
what is wrong with them. So the count goes on until all that was read in one is believed again.
"""

import numpy as np
from numpy.typing import NDArray

_PASSES = 1000.0  # normalised innovation squared per degree of freedom
_AT_MOST = 3  # in a row
_FORGOTTEN = 3.0  # greatest gaps after which the last one counts no longer
_SECONDS = 1e-9

_Places = NDArray[np.int64]


class Gate:
    """Counts measurements that are turned away as impossible."""

    def __init__(self) -> None:
        self.open()

    def open(self) -> None:
        """Take the next impossible measurement for the first."""
        self._count = 0
        self._blamed: frozenset[int] = frozenset()  # states, not believed since
        self._stamp_ns = 0

    @property
    def blames(self) -> bool:
        """Whether anything was turned away and has not been believed since."""
        return bool(self._blamed)

    @staticmethod
    def passes(innovation: float) -> bool:
        """Whether a normalised innovation squared per degree of freedom is possible."""
        return innovation <= _PASSES

    def turn_away(self, seen: _Places, stamp_ns: int, longest: float) -> bool:
        """Take in that a measurement is impossible; return whether it is to be believed after all.

        Parameters
        ----------
        seen : ndarray of int
            States that it read (k,).
        stamp_ns : int
        longest : float
            Greatest gap between measurements [s].
        """
        if (stamp_ns - self._stamp_ns) * _SECONDS > _FORGOTTEN * longest:
            self._count = 0
        self._stamp_ns = stamp_ns
        self._blamed = frozenset(seen.tolist())
        self._count += 1
        return self._count > _AT_MOST

    def let_pass(self, seen: _Places) -> None:
        """Take in that a measurement that read these states is believed."""
        if self._blamed:
            self._blamed = self._blamed.difference(seen.tolist())
            if not self._blamed:
                self._count = 0
