"""How probably a drive slips at a given load: the capacity's distribution, from the posterior.

The capacity of each member of a Gaussian sum is taken as log-normal: held tension and mu are, and
the capacity is nearly their product. Against samples of members with standard deviations of up to
0.13 in ln T and 0.05 in ln mu, where 1 % of them lie it says 0.7 to 1.4 % (a normal distribution
1.3 to 3.8 %), where 0.1 % lie 0.04 to 0.2 % (0.2 to 1.6 %). With a held slack tension and a mu that
is not known to 30 % it fails as well: the capacity is then exponential in mu.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.estimate import Quantity
from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_SMALLEST = 1e-300
_WIDEST = 1e6
_SOLVE_STEPS = 200
_ENOUGH = 1e-12  # width of the bracket in ln load


@compiled
def _log_normal(mean: float, deviation: float) -> tuple[float, float]:
    """Mean and deviation of ln x for a log-normal x."""
    mean = max(mean, _SMALLEST)
    variance = math.log1p(min(max(deviation, 0.0) / mean, _WIDEST) ** 2)
    return math.log(mean) - 0.5 * variance, math.sqrt(variance)


@compiled
def _share_below(
    log_load: float, weights: _Floats, log_means: _Floats, log_deviations: _Floats
) -> float:
    """Probability that the capacity is at most the load."""
    below = 0.0
    for k in range(weights.shape[0]):
        off = log_load - log_means[k]
        if log_deviations[k] > 0.0:
            below += weights[k] * 0.5 * math.erfc(-off / (log_deviations[k] * math.sqrt(2.0)))
        elif off >= 0.0:
            below += weights[k]
    return min(below, 1.0)


@compiled
def _logarithms(means: _Floats, deviations: _Floats) -> tuple[_Floats, _Floats]:
    log_means, log_deviations = np.empty_like(means), np.empty_like(means)
    for k in range(means.shape[0]):
        log_means[k], log_deviations[k] = _log_normal(means[k], deviations[k])
    return log_means, log_deviations


@compiled
def _probability_at(load: float, weights: _Floats, means: _Floats, deviations: _Floats) -> float:
    log_means, log_deviations = _logarithms(means, deviations)
    return _share_below(math.log(max(load, _SMALLEST)), weights, log_means, log_deviations)


@compiled
def _quantile(
    probability: float, weights: _Floats, means: _Floats, deviations: _Floats, reach: float
) -> float:
    """Load at a probability; no member's own quantile lies farther out than `reach` deviations."""
    log_means, log_deviations = _logarithms(means, deviations)
    low, high = math.inf, -math.inf
    for k in range(weights.size):
        low = min(low, log_means[k] - reach * log_deviations[k])
        high = max(high, log_means[k] + reach * log_deviations[k])
    for _ in range(_SOLVE_STEPS):
        if high - low <= _ENOUGH:
            break
        middle = 0.5 * (low + high)
        if _share_below(middle, weights, log_means, log_deviations) < probability:
            low = middle
        else:
            high = middle
    return math.exp(high)


class Capacity(NamedTuple):
    """Torque on the driven pulley at gross slip, as a sum of log-normal distributions.

    Parameters
    ----------
    weights : ndarray
        Of the members (k,), summing to one.
    means, deviations : ndarray
        Mean and standard deviation of each member's capacity (k,) [N m], not negative.
    """

    weights: _Floats
    means: _Floats
    deviations: _Floats

    @property
    def torque(self) -> Quantity:
        """Mean and standard deviation [N m]."""
        mean = float(self.weights @ self.means)
        variance = float(self.weights @ (self.deviations**2 + (self.means - mean) ** 2))
        return Quantity(mean, math.sqrt(variance))

    def gross_slip_probability_at(self, torque: float) -> float:
        """Probability [-] that the drive slips at a torque [N m] of either sign.

        0 at no torque, unless the belt does not press on the pulleys at all.
        """
        return float(_probability_at(abs(torque), self.weights, self.means, self.deviations))

    def load_at_probability(self, probability: float) -> float:
        """Torque [N m] at which the drive slips with a probability, the inverse of the former.

        Raises
        ------
        ValueError
            Unless 0 < `probability` < 1.
        """
        if not 0.0 < probability < 1.0:
            raise ValueError(f"the probability is {probability:g}; it must lie between 0 and 1")
        # Chernoff's bound on a normal distribution's quantile
        reach = math.sqrt(-2.0 * math.log(min(probability, 1.0 - probability)))
        return float(_quantile(probability, *self, reach))
