"""Whether the sensors fit what is believed of the drive, or have not done so for a while.

Neither a loss of traction nor a new load lasts as a surprise: the filter has a member for it, or
finds one within a few samples. Innovations that stay far above what was foretold speak of sensors.
"""

import math

_MEMORY = 0.3  # [s]
_STEP = 0.1  # [s] one surprise alone, after a gap, is not sustained
_CLIP = 10.0  # nor is a single one, such as a load step
_BEGINS = 4.0  # mean innovation squared per degree of freedom at which sensors do not fit ...
_ENDS = 2.0  # ... and below which they do again,
_QUIET = 0.3  # [s] for so long


class Misfit:
    """Follows the innovations.

    Attributes
    ----------
    lasts : bool
        Whether sensors do not fit.
    """

    def __init__(self) -> None:
        self.lasts = False
        self._mean = 1.0
        self._quiet = 0.0

    def update(self, innovation: float, dt: float) -> None:
        """Take in an innovation squared per degree of freedom, `dt` [s] after the one before."""
        surprise = min(innovation, _CLIP) - self._mean
        self._mean -= math.expm1(-min(dt, _STEP) / _MEMORY) * surprise
        self._quiet = self._quiet + min(dt, _STEP) if self._mean < _ENDS else 0.0
        self.lasts = self._quiet < _QUIET if self.lasts else self._mean > _BEGINS

    @property
    def recovers(self) -> bool:
        """Whether sensors seem to fit again, though not yet for long enough to be sure."""
        return self.lasts and self._quiet > 0.0

    def begin(self) -> None:
        """Note that sensors contradict all that is believed, beyond any mean."""
        self.lasts = True
        self._quiet = 0.0
