"""Whether slip is what the filter foretells, of a load that is as the torques have it.

One reading says little beside its noise. What is summed over a fifth of a second says whether slip
moves beyond what any of the filter's members, as far as it is believed, can explain.
"""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.state import Index
from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_MEMORY = 0.2  # [s] in which a reading's weight falls to 1/e
_UNFORESEEN = 2.0  # deviations of the sum
_MOST = 4.0  # deviations that one reading counts for: one alone proves nothing
# Compiled code wants plain integers.
_DRIVER_SPEED, _DRIVEN_SPEED = int(Index.DRIVER_SPEED), int(Index.DRIVEN_SPEED)


@compiled
def lead_innovation(
    radii: tuple[float, float],
    weights: _Floats,
    means: _Floats,
    covariances: _Floats,
    z: _Floats,
    variance: _Floats,
    places: NDArray[np.int64],
) -> float:
    """Innovation of what the driver's rim is ahead, over its deviation in a Gaussian sum.

    Parameters
    ----------
    radii : tuple of float
        Of the driver and the driven pulley [m].
    weights, means, covariances : ndarray
        Of the members: (k,), (k, 12) and (k, 12, 12).
    z, variance, places : ndarray
        Readings, their variances and the states that they read (m,).

    Returns
    -------
    float
        By both speeds, or the one that has been read; NaN without any.
    """
    across = np.zeros(means.shape[1])
    read, noise = 0.0, 0.0
    for i in range(places.size):
        at = places[i]
        if at in (_DRIVER_SPEED, _DRIVEN_SPEED):
            across[at] = radii[0] if at == _DRIVER_SPEED else -radii[1]
            read += across[at] * z[i]
            noise += across[at] ** 2 * variance[i]
    if noise == 0.0:
        return math.nan
    mean, square, spread = 0.0, 0.0, noise
    one, other = across[_DRIVER_SPEED], across[_DRIVEN_SPEED]
    for k in range(weights.size):
        p = covariances[k]
        ahead = read - one * means[k, _DRIVER_SPEED] - other * means[k, _DRIVEN_SPEED]
        own = one**2 * p[_DRIVER_SPEED, _DRIVER_SPEED]
        own += other**2 * p[_DRIVEN_SPEED, _DRIVEN_SPEED]
        own += 2.0 * one * other * p[_DRIVER_SPEED, _DRIVEN_SPEED]
        mean += weights[k] * ahead
        square += weights[k] * ahead**2
        spread += weights[k] * own
    return mean / math.sqrt(spread + max(square - mean**2, 0.0))


class ForetoldSlip:
    """Sum up how far slip has been from what was foretold, over the last moments."""

    def __init__(self) -> None:
        self.start()

    def start(self) -> None:
        """Forget all that was, as before the first reading."""
        self._sum = 0.0
        self._variance = 0.0  # of the sum, if slip is what is foretold

    @property
    def failed(self) -> bool:
        """Whether slip is other than was foretold, by more than chance."""
        return self._sum**2 > _UNFORESEEN**2 * self._variance

    def compare(self, innovation: float, dt: float) -> None:
        """Take in a `lead_innovation`, `dt` [s] after the step before; NaN where there is none."""
        kept = math.exp(-dt / _MEMORY)
        self._sum *= kept
        self._variance *= kept * kept
        if math.isfinite(innovation):
            self._sum += min(max(innovation, -_MOST), _MOST)
            self._variance += 1.0
