"""What is read off a sum of Gaussians: quantities, and probabilities that one number is not."""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.estimate import Quantity
from belt_ros.estimation.overload import Capacity
from belt_ros.estimation.state import Reading
from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]


@compiled
def _summed_up(weights: _Floats, means: _Floats, deviations: _Floats) -> tuple[_Floats, _Floats]:
    """Mean (n,) and standard deviation (n,) over all members, from those of each (k, n)."""
    members, n = means.shape
    mean, variance = np.zeros(n), np.zeros(n)
    for k in range(members):
        for i in range(n):
            mean[i] += weights[k] * means[k, i]
    for k in range(members):
        for i in range(n):
            away = means[k, i] - mean[i]
            variance[i] += weights[k] * (deviations[k, i] ** 2 + away**2)
    for i in range(n):
        variance[i] = math.sqrt(variance[i])
    return mean, variance


@compiled
def _share_below(
    weights: _Floats, means: _Floats, deviations: _Floats, place: int, limit: float
) -> float:
    """Share of the members that lies below `limit`, see `estimate.probability_below`."""
    below = 0.0
    for k in range(weights.size):
        above, deviation = means[k, place] - limit, deviations[k, place]
        if deviation > 0.0:
            below += weights[k] * 0.5 * math.erfc(above / (deviation * math.sqrt(2.0)))
        elif above < 0.0:
            below += weights[k]
    return below


class Readings:
    """What is read off the members, each with a row of means and deviations, and of them all."""

    def __init__(self, weights: _Floats, means: _Floats, deviations: _Floats) -> None:
        self._weights = weights
        self._means = means
        self._deviations = deviations
        mean, deviation = _summed_up(weights, means, deviations)
        self._quantities = [*map(Quantity, mean.tolist(), deviation.tolist())]

    def quantity(self, place: Reading) -> Quantity:
        """Mean and standard deviation of one reading over all members."""
        return self._quantities[place]

    def probability_below(self, place: Reading, limit: float) -> float:
        """Probability that one reading lies below `limit`, over all members."""
        each = self._weights, self._means, self._deviations
        return float(_share_below(*each, int(place), float(limit)))

    def capacity(self, place: Reading) -> Capacity:
        """Return the distribution of a reading that is a torque at gross slip."""
        # Copies have one layout, of one member as of many: numba compiles each anew.
        means, deviations = self._means[:, place], self._deviations[:, place]
        return Capacity(self._weights, means.copy(), deviations.copy())
