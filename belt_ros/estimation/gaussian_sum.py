"""A weighted sum of Gaussian filters: one belief where a single Gaussian cannot carry it.

Where the belt is near its capacity, the data bound tension from below and say nothing above; where
kf does not show, it stays uncertain by decades. A single Gaussian turns such half-open knowledge
into a narrow and wrong one. Split along the coordinates in which the model bends, it keeps it open:
each member is nearly linear within its own width, and the members' likelihoods weigh them against
each other. Members that the data rule out are dropped, those that have come to say the same are
merged, so a drive that has settled costs few.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]
_NEGLIGIBLE = -18.0  # ln of the relative weight at which a member is dropped
_REACH, _SPACING = 2.4, 0.75  # of the parts of a split: how far out, and how near, in deviations
_WORTH_SPLITTING = 1.1  # how much wider a member must be
_FINEST = 0.15  # width of a part to that of the whole
_SPLIT_ABOVE = 1e-3  # weight of the heaviest
_MOST_MEMBERS = 96
_ALIKE = 0.1  # squared distance between members, per their own variance, at which they are merged


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
    weights: _Floats = np.exp(log_weights - np.max(log_weights))
    weights /= np.sum(weights)
    return weights


@compiled
def mixture_moments(
    weights: _Floats, means: _Floats, covariances: _Floats
) -> tuple[_Floats, _Floats]:
    """Mean (n,) and covariance (n, n) of a sum of `weights` (k,), `means` (k, n), `covariances`."""
    count, n = means.shape
    mean = np.zeros(n)
    for k in range(count):
        mean += weights[k] * means[k]
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


def reduced(components: list[Component], axes: Sequence[int]) -> list[Component]:
    """Drop members of negligible weight, and merge those that are alike along `axes`."""
    best = max(component.log_weight for component in components)
    kept = [c for c in components if c.log_weight - best > _NEGLIGIBLE]
    kept.sort(key=lambda component: -component.log_weight)
    log_weights = np.array([component.log_weight for component in kept])
    means = np.stack([component.mean for component in kept])
    covariances = np.stack([component.covariance for component in kept])
    modes = np.array([component.changing for component in kept])
    count = _merge_alike(log_weights, means, covariances, modes, np.array(axes))
    return [
        Component(float(log_weight), mean, covariance, bool(changing))
        for log_weight, mean, covariance, changing in zip(
            log_weights[:count], means[:count], covariances[:count], modes[:count], strict=True
        )
    ]


@compiled
def _merge_alike(
    log_weights: _Floats,
    means: _Floats,
    covariances: _Floats,
    modes: NDArray[np.bool_],
    axes: _Places,
) -> int:
    """Merge each member into the first that is like it; those left stand first, return how many."""
    count = 0
    for k in range(log_weights.size):
        at = 0
        while at < count and not (
            modes[at] == modes[k]
            and _alike(means[at], covariances[at], means[k], covariances[k], axes)
        ):
            at += 1
        if at < count:
            log_weights[at], means[at], covariances[at] = _both(
                log_weights[at],
                means[at],
                covariances[at],
                log_weights[k],
                means[k],
                covariances[k],
            )
            continue
        log_weights[at], modes[at] = log_weights[k], modes[k]
        means[at], covariances[at] = means[k], covariances[k]
        count += 1
    return count


@compiled
def _alike(
    mean: _Floats, covariance: _Floats, other: _Floats, beside: _Floats, axes: _Places
) -> bool:
    """Whether means and widths differ little along every axis, in units of variance."""
    for axis in axes:
        variance, variance_beside = covariance[axis, axis], beside[axis, axis]
        shift = (mean[axis] - other[axis]) ** 2
        if not shift < _ALIKE * min(variance, variance_beside):
            return False
        if not math.log(variance / variance_beside) ** 2 < _ALIKE:
            return False
    return True


@compiled
def _both(
    log_weight: float,
    mean: _Floats,
    covariance: _Floats,
    log_weight_other: float,
    other: _Floats,
    beside: _Floats,
) -> tuple[float, _Floats, _Floats]:
    """Weight, mean and covariance of two members together."""
    most = max(log_weight, log_weight_other)
    total = most + math.log(math.exp(log_weight - most) + math.exp(log_weight_other - most))
    share = math.exp(log_weight - total)
    rest = math.exp(log_weight_other - total)
    both = share * mean + rest * other
    n = mean.size
    spread = np.empty((n, n))
    for i in range(n):
        for j in range(i + 1):
            apart = share * (mean[i] - both[i]) * (mean[j] - both[j])
            apart += rest * (other[i] - both[i]) * (other[j] - both[j])
            spread[i, j] = share * covariance[i, j] + rest * beside[i, j] + apart
            spread[j, i] = spread[i, j]
    return total, both, spread


def merge(a: Component, b: Component) -> Component:
    """Return one member of the same weight, mean and covariance as both, in the mode of `a`."""
    log_weight, mean, covariance = _both(
        a.log_weight, a.mean, a.covariance, b.log_weight, b.mean, b.covariance
    )
    return Component(log_weight, mean, covariance, a.changing)
