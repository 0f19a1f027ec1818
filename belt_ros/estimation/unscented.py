"""The unscented filter's work on points and covariance, compiled.

Two things are done differently from filterpy's stock class, against which tests hold the result:

* the square root is taken of the correlation matrix, since the states' scales differ by ten
  decades, and a pivot that rounding has made negative is lifted, which only widens the estimate;
* measurements read states directly, so each is taken in by Joseph's scalar form. That is what the
  unscented transform of a linear function gives, exactly, for any subset of the sensors.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]
_SMALLEST_PIVOT = 1e-14


@compiled
def sigma_points(x: _Floats, covariance: _Floats, order: _Places, spread: _Floats) -> _Floats:
    """Points x and x +- sqrt(spread[k]) times the k-th column of the Cholesky factor.

    The factor is taken in `order`: its first column is the whole of the first state in it, with all
    that goes with it, the second what is left of the second, and so on.
    """
    n = x.shape[0]
    scale = np.empty(n)
    for i in range(n):
        scale[i] = math.sqrt(max(covariance[order[i], order[i]], 1e-300))
    lower = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            total = covariance[order[i], order[j]] / (scale[i] * scale[j])
            for k in range(j):
                total -= lower[i, k] * lower[j, k]
            if i == j:
                lower[i, i] = math.sqrt(max(total, _SMALLEST_PIVOT))
            else:
                lower[i, j] = total / lower[j, j]
    points = np.empty((2 * n + 1, n))
    for i in range(n):
        at = order[i]
        points[0, at] = x[at]
        for k in range(n):
            step = math.sqrt(spread[k]) * scale[i] * lower[i, k]
            points[1 + k, at] = x[at] + step
            points[1 + n + k, at] = x[at] - step
    return points


@compiled
def moments(points: _Floats, weights: _Floats, added: _Floats) -> tuple[_Floats, _Floats]:
    """Weighted mean and covariance of rows, `added` on the covariance's diagonal."""
    count, n = points.shape
    mean = np.zeros(n)
    for p in range(count):
        for i in range(n):
            mean[i] += weights[p] * points[p, i]
    covariance = np.zeros((n, n))
    for p in range(count):
        for i in range(n):
            weighted = weights[p] * (points[p, i] - mean[i])
            for j in range(i + 1):
                covariance[i, j] += weighted * (points[p, j] - mean[j])
    for i in range(n):
        covariance[i, i] += added[i]
        for j in range(i):
            covariance[j, i] = covariance[i, j]
    return mean, covariance


@compiled
def take_in(
    x: _Floats, covariance: _Floats, z: _Floats, variance: _Floats, seen: _Places
) -> tuple[_Floats, _Floats]:
    """Update by readings `z` of the states `seen`, each of its own `variance`."""
    n = x.shape[0]
    x = x.copy()
    p = covariance.copy()
    gain = np.empty(n)
    for reading in range(z.shape[0]):
        at = seen[reading]
        total = p[at, at] + variance[reading]
        innovation = z[reading] - x[at]
        for i in range(n):
            gain[i] = p[i, at] / total
        row = p[at].copy()
        for i in range(n):
            x[i] += gain[i] * innovation
            for j in range(i + 1):
                value = p[i, j] - gain[i] * row[j] - row[i] * gain[j] + gain[i] * total * gain[j]
                p[i, j] = value
                p[j, i] = value
    return x, p


class GradedSigmaPoints:
    """Sigma points nearer where the model bends and farther where it is straight.

    Stock points all lie sqrt(n + kappa) standard deviations out, 3.5 for eleven states, which takes
    a bend seen that far out for one of the member's own width. Here each state has its own
    distance; all weights are positive, and the weighted points have the mean and covariance asked
    for. A points object for filterpy's filters.

    Parameters
    ----------
    order : sequence of int
        All states, in the order in which the Cholesky factor takes them.
    squared_distances : sequence of float
        For the first states in `order`, in variances. The other states share what weight is left.

    Raises
    ------
    ValueError
        If the first states leave no weight for the others.
    """

    def __init__(self, order: Sequence[int], squared_distances: Sequence[float]) -> None:
        self.n = len(order)
        self.order = np.array(order, dtype=np.int64)
        near = np.array(squared_distances)
        left = 1.0 - float(np.sum(1.0 / near))
        if not left > 0.0:
            raise ValueError(f"the squared distances {near} leave {left:g} of the weight; want > 0")
        others = self.n - len(near)
        self.spread = np.concatenate([near, np.full(others, others / left)])
        self.Wm = self.Wc = np.concatenate([[0.0], 0.5 / self.spread, 0.5 / self.spread])

    def num_sigmas(self) -> int:
        """Return the number of points."""
        return 2 * self.n + 1

    def sigma_points(self, x: _Floats, covariance: _Floats) -> _Floats:
        """Return the points (2 n + 1, n) of mean `x` (n,) and `covariance` (n, n)."""
        return sigma_points(x, covariance, self.order, self.spread)
