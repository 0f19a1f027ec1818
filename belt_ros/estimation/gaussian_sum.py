"""A weighted sum of Gaussian filters: one belief where a single Gaussian cannot carry it.

Where the belt is near its capacity, the data bound tension from below and say nothing above; where
kf does not show, it stays uncertain by decades. A single Gaussian turns such half-open knowledge
into a narrow and wrong one. Split along the coordinates in which the model bends, it keeps it open:
each member is nearly linear within its own width, and the members' likelihoods weigh them against
each other. Members that the data rule out are dropped, and those that can be told apart no longer
are merged (`reduction.py`), so a drive that has settled costs few.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_REACH, _SPACING = 2.4, 0.75  # of the parts of a split: how far out, and how near, in deviations
_WORTH_SPLITTING = 1.1  # how much wider a member must be
_FINEST = 0.15  # width of a part to that of the whole
_SPLIT_ABOVE = 1e-3  # weight of the heaviest
_MOST_MEMBERS = 96


@dataclass
class Component:
    """One Gaussian: ln of its weight, mean (n,) and covariance (n, n), and the mode it moves in."""

    log_weight: float
    mean: _Floats
    covariance: _Floats
    changing: bool = False


def split(component: Component, axis: int, ratio: float) -> list[Component]:
    """Replace a member by narrower ones in a row.

    Parameters
    ----------
    component : Component
    axis : int
        The coordinate along which to split, with all that goes with it.
    ratio : float
        Standard deviation of the parts along `axis` to that of the whole, less than one; they
        become up to 8 % wider, because the row ends.

    Returns
    -------
    list of Component
        Their sum has the mean and covariance of the whole. They stand 4/3 of their deviation apart,
        with weights of a normal density.
    """
    reach = max(round(_REACH * math.sqrt(1.0 - ratio * ratio) * _SPACING / ratio), 1)
    places = np.arange(-reach, reach + 1) * (ratio / _SPACING)
    weights = np.exp(-0.5 * places**2 / (1.0 - ratio * ratio))
    weights /= np.sum(weights)
    column = component.covariance[:, axis] / math.sqrt(component.covariance[axis, axis])
    taken = float(weights @ places**2)  # of the variance, by the places of the parts
    covariance = component.covariance - taken * np.outer(column, column)
    return [
        Component(
            component.log_weight + math.log(weight),
            component.mean + place * column,
            covariance,
            component.changing,
        )
        for place, weight in zip(places.tolist(), weights.tolist(), strict=True)
    ]


def narrowed(
    components: list[Component],
    axes: Sequence[int],
    widths: Sequence[float],
    most: int = _MOST_MEMBERS,
    changing: float = 1.0,
) -> list[Component]:
    """Split members along `axes` until none that matters is wider than `widths`.

    So that a model that bends is nearly straight within each. No member is split once there are
    more than `most` of these, or as many as the filter may have in all. Members in which
    traction is changing may be wider by the factor `changing`.
    """
    for axis, width in zip(axes, widths, strict=True):
        best = max(component.log_weight for component in components)
        parts: list[Component] = []
        left = len(components)
        for component in sorted(components, key=lambda c: -c.log_weight):
            full = len(parts) > most or len(parts) + left > _MOST_MEMBERS
            left -= 1
            widest = width * changing if component.changing else width
            ratio = max(widest / math.sqrt(component.covariance[axis, axis]), _FINEST)
            light = component.log_weight < best + math.log(_SPLIT_ABOVE)
            if light or ratio * _WORTH_SPLITTING > 1.0 or full:
                parts.append(component)
            else:
                parts += split(component, axis, ratio)
        components = parts
    return components


@compiled
def normalised(log_weights: _Floats) -> _Floats:
    """Weights that sum to one, from their logarithms."""
    count, best, total = log_weights.size, -math.inf, 0.0
    for k in range(count):
        best = max(best, log_weights[k])
    weights = np.empty(count)
    for k in range(count):
        weights[k] = math.exp(log_weights[k] - best)
        total += weights[k]
    for k in range(count):
        weights[k] /= total
    return weights


@compiled
def mixture_moments(
    weights: _Floats, means: _Floats, covariances: _Floats
) -> tuple[_Floats, _Floats]:
    """Mean (n,) and covariance (n, n) of a sum of `weights` (k,), `means` (k, n), `covariances`."""
    count, n = means.shape
    mean = np.zeros(n)
    for k in range(count):
        for i in range(n):
            mean[i] += weights[k] * means[k, i]
    covariance = np.zeros((n, n))
    for k in range(count):
        for i in range(n):
            away = means[k, i] - mean[i]
            for j in range(i + 1):
                spread = covariances[k, i, j] + away * (means[k, j] - mean[j])
                covariance[i, j] += weights[k] * spread
    for i in range(n):
        for j in range(i):
            covariance[j, i] = covariance[i, j]
    return mean, covariance
