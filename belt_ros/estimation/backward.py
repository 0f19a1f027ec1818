"""Backward kernels: what a state was, given what it became. Gaussian, compiled.

A filter's step from x to x' makes the two jointly Gaussian, so x given x' is Gaussian too, and the
measurements after the step say nothing more of x (Rauch, Tung and Striebel, doi:10.2514/3.3166;
with the cross covariance from sigma points: Sarkka, doi:10.1109/TAC.2008.919531). Such kernels of
consecutive steps compose into one, so a block of steps of any length needs the room of one.

Means are kept as deviations from the filter's own, and inverses are taken of correlations, since
the states' scales differ by ten decades.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.written import write
from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]
_REDUNDANT = 1e-12  # share of its variance that a state has of its own, below which it has none
_ROUNDING = 1e-14  # of a variance, left over from differences


class Kernel(NamedTuple):
    """x given x', normal of mean `centre + gain (x' - reference)` and covariance `spread`."""

    gain: _Floats  # (n, n)
    centre: _Floats  # (n,)
    reference: _Floats  # (n,)
    spread: _Floats  # (n, n)


class Moments(NamedTuple):
    """Means (n,) and covariances (n, n) of a state before and after, and between the two."""

    mean: _Floats
    covariance: _Floats
    later_mean: _Floats
    later_covariance: _Floats
    cross: _Floats  # row: before, column: after


def identity(n: int) -> Kernel:
    """Return the kernel of no step: x is x'."""
    return Kernel(np.eye(n), np.zeros(n), np.zeros(n), np.zeros((n, n)))


@compiled
def _scales(covariance: _Floats) -> tuple[_Floats, _Floats]:
    """Return standard deviations and their inverses, zero for what does not vary."""
    n = covariance.shape[0]
    scale, inverse = np.zeros(n), np.zeros(n)
    for i in range(n):
        if covariance[i, i] > 0.0:
            scale[i] = math.sqrt(covariance[i, i])
            inverse[i] = 1.0 / scale[i]
    return scale, inverse


@compiled
def _lower_root(matrix: _Floats, least: float) -> _Floats:
    """Cholesky factor; a row whose pivot is below `least` gets no column of its own."""
    n = matrix.shape[0]
    lower = np.zeros((n, n))
    for j in range(n):
        pivot = matrix[j, j]
        for k in range(j):
            pivot -= lower[j, k] * lower[j, k]
        if not pivot > least:
            continue
        lower[j, j] = math.sqrt(pivot)
        for i in range(j + 1, n):
            rest = matrix[i, j]
            for k in range(j):
                rest -= lower[i, k] * lower[j, k]
            lower[i, j] = rest / lower[j, j]
    return lower


@compiled
def _whitened(lower: _Floats, rows: _Floats) -> _Floats:
    """Rows times the inverse of the factor's transpose, nothing along redundant states."""
    out = np.zeros_like(rows)
    for r in range(rows.shape[0]):
        for j in range(lower.shape[0]):
            if lower[j, j] > 0.0:
                rest = rows[r, j]
                for k in range(j):
                    rest -= lower[j, k] * out[r, k]
                out[r, j] = rest / lower[j, j]
    return out


@compiled
def _unwhitened(lower: _Floats, rows: _Floats) -> _Floats:
    """Rows times the inverse of the factor, nothing along redundant states."""
    n = lower.shape[0]
    out = np.zeros_like(rows)
    for r in range(rows.shape[0]):
        for j in range(n - 1, -1, -1):
            if lower[j, j] > 0.0:
                rest = rows[r, j]
                for k in range(j + 1, n):
                    rest -= lower[k, j] * out[r, k]
                out[r, j] = rest / lower[j, j]
    return out


@compiled
def _times(one: _Floats, other: _Floats) -> _Floats:
    out = np.zeros((one.shape[0], other.shape[1]))
    for i in range(one.shape[0]):
        for k in range(other.shape[0]):
            for j in range(other.shape[1]):
                out[i, j] += one[i, k] * other[k, j]
    return out


@compiled
def _times_transposed(one: _Floats, other: _Floats) -> _Floats:
    out = np.zeros((one.shape[0], other.shape[0]))
    for i in range(one.shape[0]):
        for j in range(other.shape[0]):
            for k in range(other.shape[1]):
                out[i, j] += one[i, k] * other[j, k]
    return out


@compiled
def backward_kernel(joint: Moments) -> Kernel:
    """Condition the state before on the state after: gain C P'^-1, spread P - C P'^-1 C^T.

    A state after that the others determine, to rounding, takes no part; the spread is positive
    semidefinite for any input.
    """
    n = joint.mean.shape[0]
    scale, inverse = _scales(joint.covariance)
    _, later_inverse = _scales(joint.later_covariance)
    correlation, cross = np.empty((n, n)), np.empty((n, n))
    for i in range(n):
        for j in range(n):
            correlation[i, j] = joint.later_covariance[i, j] * later_inverse[i] * later_inverse[j]
            cross[i, j] = joint.cross[i, j] * inverse[i] * later_inverse[j]
    lower = _lower_root(correlation, _REDUNDANT)
    explained = _whitened(lower, cross)
    gain = _unwhitened(lower, explained)
    left = np.empty((n, n))
    for i in range(n):
        for j in range(n):
            gain[i, j] *= scale[i] * later_inverse[j]
            left[i, j] = joint.covariance[i, j] * inverse[i] * inverse[j]
            for k in range(n):
                left[i, j] -= explained[i, k] * explained[j, k]
    root = _lower_root(left, _ROUNDING)
    for i in range(n):
        for k in range(i + 1):
            root[i, k] *= scale[i]
    return Kernel(gain, joint.mean, joint.later_mean, _times_transposed(root, root))


@compiled
def mapped(kernel: Kernel, mean: _Floats, covariance: _Floats) -> tuple[_Floats, _Floats]:
    """Mean and covariance of x where x' has `mean` (n,) and `covariance` (n, n)."""
    n = mean.shape[0]
    moved, spread = np.empty(n), np.empty((n, n))
    through = _times_transposed(_times(kernel.gain, covariance), kernel.gain)
    for i in range(n):
        moved[i] = kernel.centre[i]
        for j in range(n):
            moved[i] += kernel.gain[i, j] * (mean[j] - kernel.reference[j])
            spread[i, j] = kernel.spread[i, j] + 0.5 * (through[i, j] + through[j, i])
    return moved, spread


@compiled
def composed(first: Kernel, second: Kernel) -> Kernel:
    """One kernel of two steps: x given x'', by `first` x given x' and by `second` x' given x''."""
    centre, spread = mapped(first, second.centre, second.spread)
    return Kernel(_times(first.gain, second.gain), centre, second.reference, spread)


@compiled
def _averaged(weights: _Floats, rows: _Floats) -> _Floats:
    """Weighted mean (n,) of rows (k, n)."""
    mean = np.zeros(rows.shape[1])
    for k in range(rows.shape[0]):
        for i in range(rows.shape[1]):
            mean[i] += weights[k] * rows[k, i]
    return mean


@compiled
def mixture_cross(
    weights: _Floats,
    means: _Floats,
    later_means: _Floats,
    crosses: _Floats,
) -> tuple[_Floats, _Floats, _Floats]:
    """Mean before and after, and cross covariance, of a sum of Gaussian members (k, n), (k, n, n).

    With the same means and the members' covariances it gives the sum's covariance.
    """
    members, n = means.shape
    mean, later = _averaged(weights, means), _averaged(weights, later_means)
    cross = np.zeros((n, n))
    for k in range(members):
        if weights[k] > 0.0:
            for i in range(n):
                away = means[k, i] - mean[i]
                for j in range(n):
                    spread = away * (later_means[k, j] - later[j])
                    cross[i, j] += weights[k] * (crosses[k, i, j] + spread)
    return mean, later, cross


@compiled
def mode_weights(log_weights: _Floats, modes: _Places, mode: int) -> _Floats:
    """Weights (k,) of the members of one mode, that sum to one; zeros if it has none."""
    weights = np.zeros(log_weights.shape[0])
    best = -np.inf
    for k in range(log_weights.shape[0]):
        if modes[k] == mode:
            best = max(best, log_weights[k])
    if best == -np.inf:
        return weights
    for k in range(log_weights.shape[0]):
        if modes[k] == mode:
            weights[k] = math.exp(log_weights[k] - best)
    total = np.sum(weights)
    for k in range(weights.size):
        weights[k] /= total
    return weights


@compiled
def _faded(mean: _Floats, memory: _Floats, anchor: _Floats) -> _Floats:
    faded = np.empty(mean.size)
    for i in range(mean.size):
        faded[i] = anchor[i] + memory[i] * (mean[i] - anchor[i])
    return faded


@compiled
def fading_moments(
    mean: _Floats, covariance: _Floats, memory: _Floats, anchor: _Floats, gained: _Floats
) -> Moments:
    """Joint moments of x and anchor + memory (x - anchor) + noise of covariance `gained`."""
    n = mean.shape[0]
    cross, faded = np.empty((n, n)), np.empty((n, n))
    for i in range(n):
        for j in range(n):
            cross[i, j] = covariance[i, j] * memory[j]
            faded[i, j] = memory[i] * cross[i, j] + gained[i, j]
    return Moments(mean, covariance, _faded(mean, memory, anchor), faded, cross)


@compiled
def fading_kernel(
    weights: _Floats,
    means: _Floats,
    covariances: _Floats,
    memory: _Floats,
    anchor: _Floats,
    gained: _Floats,
) -> tuple[Kernel, Moments]:
    """Kernel and joint moments of fading, for a sum of Gaussian members, see `fading_moments`."""
    mean, _, covariance = mixture_cross(weights, means, means, covariances)
    joint = fading_moments(mean, covariance, memory, anchor, gained)
    return backward_kernel(joint), joint


@compiled
def step_kernel(
    weights: _Floats,
    means: _Floats,
    covariances: _Floats,
    memory: _Floats,
    anchor: _Floats,
    gained: _Floats,
    moved_means: _Floats,
    moved_covariances: _Floats,
    crosses: _Floats,
) -> Kernel:
    """Kernel of a step in which a sum of Gaussian members fades and then moves.

    Parameters
    ----------
    weights : ndarray
        Of the members (k,), that sum to one.
    means, covariances : ndarray
        Of the members before the step, (k, n) and (k, n, n).
    memory, anchor, gained : ndarray
        Of the fading, (n,), (n,) and (n, n), see `fading_moments`.
    moved_means, moved_covariances : ndarray
        Of the members after the motion, (k, n) and (k, n, n).
    crosses : ndarray
        Covariances (k, n, n) between a member's state after fading and after the motion.

    Notes
    -----
    Fading and motion have a kernel each. The one of fading is exact without sigma points, and no
    member's covariance has to be inverted, only those of the sum.
    """
    fading, joint = fading_kernel(weights, means, covariances, memory, anchor, gained)
    faded = np.empty(means.shape)
    for k in range(means.shape[0]):
        write(faded[k], _faded(means[k], memory, anchor))
    mean, moved, cross = mixture_cross(weights, faded, moved_means, crosses)
    _, _, covariance = mixture_cross(weights, moved_means, moved_means, moved_covariances)
    motion = backward_kernel(Moments(mean, joint.later_covariance, moved, covariance, cross))
    return composed(fading, motion)
