"""What is read off a sum of Gaussians: quantities, and probabilities that one number is not."""

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.estimate import Quantity, probability_below
from belt_ros.estimation.overload import Capacity
from belt_ros.estimation.state import Reading

_Floats = NDArray[np.float64]


class Readings:
    """What is read off the members, each with a row of means and deviations, and of them all."""

    def __init__(self, weights: _Floats, means: _Floats, deviations: _Floats) -> None:
        self._weights = weights
        self._means = means
        self._deviations = deviations
        self._mean = weights @ means
        self._deviation = np.sqrt(weights @ (deviations**2 + (means - self._mean) ** 2))

    def quantity(self, place: Reading) -> Quantity:
        """Mean and standard deviation of one reading over all members."""
        return Quantity(float(self._mean[place]), float(self._deviation[place]))

    def probability_below(self, place: Reading, limit: float) -> float:
        """Probability that one reading lies below `limit`, over all members."""
        pairs = zip(
            self._means[:, place].tolist(), self._deviations[:, place].tolist(), strict=True
        )
        each = [probability_below(Quantity(*pair), limit) for pair in pairs]
        return float(self._weights @ np.array(each))

    def capacity(self, place: Reading) -> Capacity:
        """Return the distribution of a reading that is a torque at gross slip."""
        return Capacity(self._weights, self._means[:, place], self._deviations[:, place])
