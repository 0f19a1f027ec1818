"""Whether data have told a quantity of the belt, or what is believed of it is its prior yet.

A belief may become narrow without that: a tension that must be *at least* what carried the load is
the upper end of its prior, and the prior alone says how far up it goes. So data must not only have
narrowed a belief, but also speak against what lies beyond it, on both sides.
"""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.estimate import Knowledge, Quantity
from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_LEARNED = 0.5  # of the prior's standard deviation
_STILL_OPEN = 0.05  # likelihood of what is a prior deviation off to that of what is believed


@compiled
def _density(weights: _Floats, means: _Floats, covariances: _Floats, place: int, x: float) -> float:
    """Density of a Gaussian sum along one state, but for the factor 1/sqrt(2 pi)."""
    density = 0.0
    for k in range(weights.size):
        variance = covariances[k, place, place]
        square = (x - means[k, place]) ** 2 / variance
        density += weights[k] * math.exp(-0.5 * square) / math.sqrt(variance)
    return density


@compiled
def greatest_likelihood_beside(
    weights: _Floats,
    means: _Floats,
    covariances: _Floats,
    place: int,
    believed: float,
    prior: tuple[float, float],
) -> float:
    """Likelihood of what lies one prior deviation beside the belief, relative to the belief's own.

    Parameters
    ----------
    weights, means, covariances : ndarray
        Of a Gaussian sum over the state: (k,), summing to one, (k, n) and (k, n, n).
    place : int
        The state that is asked for.
    believed : float
        Its mean in the sum.
    prior : tuple of float
        Its mean and standard deviation before any data.

    Returns
    -------
    float
        Of both sides, the greater. What the data say is the density over that of the prior.
    """
    mean, deviation = prior
    at = (believed - mean) / deviation
    own = _density(weights, means, covariances, place, believed)
    greatest = 0.0
    for side in (-1.0, 1.0):
        beside = _density(weights, means, covariances, place, believed + side * deviation)
        expected = own * math.exp(-0.5 * ((at + side) ** 2 - at**2))
        if not expected > 0.0:
            return math.inf
        greatest = max(greatest, beside / expected)
    return greatest


def knowledge_of(
    believed: Quantity,
    prior: Quantity,
    place: int,
    weights: _Floats,
    means: _Floats,
    covariances: _Floats,
) -> Knowledge:
    """Return whether data have told one state of a Gaussian sum, of which `believed` are moments.

    Sums as in `greatest_likelihood_beside`.
    """
    if not believed.stddev < _LEARNED * prior.stddev:
        return Knowledge.AT_PRIOR
    beside = greatest_likelihood_beside(
        weights, means, covariances, place, believed.value, (prior.value, prior.stddev)
    )
    return Knowledge.LEARNED if beside < _STILL_OPEN else Knowledge.AT_PRIOR
