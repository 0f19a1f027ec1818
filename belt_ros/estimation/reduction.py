"""A Gaussian sum made smaller: members are merged where that loses least of what the sum says.

Merging two members keeps the mean and covariance of the sum; what is lost is its shape. How much,
as Kullback-Leibler divergence of the new sum from the old, is bounded by A. R. Runnalls, "Kullback-
Leibler approach to Gaussian mixture reduction" (2007), doi:10.1109/TAES.2007.4383588:

    B = ((v + w) ln |P_vw| - v ln |P_v| - w ln |P_w|) / 2

for two members of weights v and w, P_vw being the covariance of both together. So members that say
the same are merged, and those that matter little into any that are near; heavy ones stay apart.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.gaussian_sum import Component
from belt_ros.estimation.written import write, write_matrix
from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]
_Flags = NDArray[np.bool_]
NEGLIGIBLE = -18.0  # ln of the relative weight at which a member is dropped
AFFORDABLE = 0.005  # nats of a mode's sum that may be lost with a merge
_LEAST = 1e-300  # of a pivot, whose logarithm is taken


@compiled
def _half_log_volume(matrix: _Floats) -> float:
    """Half the ln of the determinant of a covariance, of which the Cholesky factor remains."""
    half = 0.0
    for i in range(matrix.shape[0]):
        for j in range(i + 1):
            rest = matrix[i, j]
            for k in range(j):
                rest -= matrix[i, k] * matrix[j, k]
            if i == j:
                matrix[i, i] = math.sqrt(max(rest, _LEAST))
                half += math.log(matrix[i, i])
            else:
                matrix[i, j] = rest / matrix[j, j]
    return half


@compiled
def _between(share: float, mean: _Floats, other: _Floats) -> _Floats:
    """Mean of two members, of which the first has a `share` of both."""
    out = np.empty(mean.size)
    for i in range(mean.size):
        out[i] = share * mean[i] + (1.0 - share) * other[i]
    return out


@compiled
def _together(
    share: float, mean: _Floats, covariance: _Floats, other: _Floats, beside: _Floats, out: _Floats
) -> None:
    """Write the covariance of two members, of which the first has a `share` of both, to `out`."""
    rest = 1.0 - share
    for i in range(mean.size):
        away = share * rest * (mean[i] - other[i])
        for j in range(i + 1):
            spread = share * covariance[i, j] + rest * beside[i, j]
            out[i, j] = out[j, i] = spread + away * (mean[j] - other[j])


@compiled
def _loss(
    a: int,
    b: int,
    weights: _Floats,
    means: _Floats,
    covariances: _Floats,
    halves: _Floats,
    scratch: _Floats,
) -> float:
    """Bound [nats] of what merging members `a` and `b` loses; `halves` are of their volumes."""
    v, w = weights[a], weights[b]
    if v + w <= 0.0:
        return 0.0
    share = v / (v + w)
    _together(share, means[a], covariances[a], means[b], covariances[b], scratch)
    loss: float = (v + w) * _half_log_volume(scratch) - v * halves[a] - w * halves[b]
    return loss


@compiled
def _cheapest(losses: _Floats, alive: _Flags) -> tuple[float, int, int]:
    least, at, into = math.inf, -1, -1
    for a in range(alive.size):
        if alive[a]:
            for b in range(a):
                if losses[a, b] < least:
                    least, at, into = losses[a, b], a, b
    return least, at, into


@compiled
def _merge_cheapest(
    weights: _Floats, means: _Floats, covariances: _Floats, modes: _Flags, most: int, enough: float
) -> _Places:
    """Merge pairs of one mode, the cheapest first; return into which member each has gone.

    `weights` sum to one in each mode; means (k, n) and covariances (k, n, n) are those along the
    axes that tell members apart, and are merged in place. Ends when the cheapest loses `enough` and
    there are no more than `most`.
    """
    count, n = means.shape
    into = np.arange(count)
    alive = np.ones(count, np.bool_)
    halves, losses = np.empty(count), np.full((count, count), math.inf)
    scratch = np.empty((n, n))
    for a in range(count):
        write_matrix(scratch, covariances[a])
        halves[a] = _half_log_volume(scratch)
        for b in range(a):
            if modes[a] == modes[b]:
                losses[a, b] = _loss(a, b, weights, means, covariances, halves, scratch)
    left = count
    while True:
        least, gone, kept = _cheapest(losses, alive)
        if gone < 0 or (least >= enough and left <= most):
            return into
        alive[gone] = False
        left -= 1
        losses[gone, :] = losses[:, gone] = math.inf
        for k in range(count):
            if into[k] == gone:
                into[k] = kept
        total = weights[kept] + weights[gone]
        share = weights[kept] / total if total > 0.0 else 0.5
        _together(share, means[kept], covariances[kept], means[gone], covariances[gone], scratch)
        write_matrix(covariances[kept], scratch)
        write(means[kept], _between(share, means[kept], means[gone]))
        weights[kept] = total
        halves[kept] = _half_log_volume(scratch)
        for k in range(count):
            if alive[k] and k != kept and modes[k] == modes[kept]:
                loss = _loss(kept, k, weights, means, covariances, halves, scratch)
                losses[max(k, kept), min(k, kept)] = loss


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
    spread = np.empty_like(covariance)
    _together(share, mean, covariance, other, beside, spread)
    return total, _between(share, mean, other), spread


def merge(a: Component, b: Component) -> Component:
    """Return one member of the same weight, mean and covariance as both, in the mode of `a`."""
    log_weight, mean, covariance = _both(
        a.log_weight, a.mean, a.covariance, b.log_weight, b.mean, b.covariance
    )
    return Component(log_weight, mean, covariance, a.changing)


def reduced(
    components: Sequence[Component], axes: Sequence[int], most: int | None = None
) -> list[Component]:
    """Drop members of negligible weight, and merge those of one mode that say nearly the same.

    Parameters
    ----------
    components : sequence of Component
    axes : sequence of int
        Coordinates along which members are told apart.
    most : int, optional
        Merge on, the cheapest first, until there are no more than these, two at least.

    Returns
    -------
    list of Component
        Of the same mean and covariance but for what was dropped, the likeliest first.
    """
    best = max(component.log_weight for component in components)
    kept = [c for c in components if c.log_weight - best > NEGLIGIBLE]
    kept.sort(key=lambda component: -component.log_weight)
    modes = np.array([component.changing for component in kept])
    weights = np.exp([component.log_weight - best for component in kept])
    for mode in (modes, ~modes):
        weights[mode] /= max(float(np.sum(weights[mode])), _LEAST)
    places = np.array(axes)
    means = np.array([component.mean for component in kept])
    covariances = np.array([component.covariance for component in kept])
    # In one layout, for one member as for many: numba compiles each anew.
    into = _merge_cheapest(
        weights,
        np.ascontiguousarray(means[:, places]),
        np.ascontiguousarray(covariances[:, places[:, None], places]),
        modes,
        len(kept) if most is None else most,
        AFFORDABLE,
    )
    found: dict[int, Component] = {}
    for component, place in zip(kept, into.tolist(), strict=True):
        found[place] = merge(found[place], component) if place in found else component
    return sorted(found.values(), key=lambda component: -component.log_weight)
