"""An unscented filter whose points are moved together and whose covariance stays positive.

filterpy's `UnscentedKalmanFilter` carries the filter; here its work on points and covariance is
compiled. Tests hold the result against the stock class. Three things are done differently:

* all sigma points go through the process model in one call;
* the square root is taken of the correlation matrix, since the states' scales differ by ten
  decades, and a pivot that rounding has made negative is lifted, which only widens the estimate;
* measurements read states directly, so each is taken in by Joseph's scalar form. That is what the
  unscented transform of a linear function gives, exactly, for any subset of the sensors.
"""

import math
from collections.abc import Callable

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter
from numpy.typing import NDArray

from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]
_SMALLEST_PIVOT = 1e-14


@compiled
def sigma_points(x: _Floats, covariance: _Floats, spread: float) -> _Floats:
    """Points x and x +- rows of the upper Cholesky factor of `spread` times the covariance."""
    n = x.shape[0]
    scale = np.empty(n)
    for i in range(n):
        scale[i] = math.sqrt(max(covariance[i, i], 1e-300))
    lower = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            total = covariance[i, j] / (scale[i] * scale[j])
            for k in range(j):
                total -= lower[i, k] * lower[j, k]
            if i == j:
                lower[i, i] = math.sqrt(max(total, _SMALLEST_PIVOT))
            else:
                lower[i, j] = total / lower[j, j]
    points = np.empty((2 * n + 1, n))
    root = math.sqrt(spread)
    for i in range(n):
        points[0, i] = x[i]
        for k in range(n):
            step = root * scale[i] * lower[i, k]
            points[1 + k, i] = x[i] + step
            points[1 + n + k, i] = x[i] - step
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
) -> tuple[_Floats, _Floats, float, float]:
    """Update by readings `z` of the states `seen`, each of its own `variance`.

    Returns
    -------
    x, covariance : ndarray
    squared : float
        Normalised innovation squared of all readings together.
    log_determinant : float
        Of the innovation covariance.
    """
    n = x.shape[0]
    x = x.copy()
    p = covariance.copy()
    gain = np.empty(n)
    squared = 0.0
    log_determinant = 0.0
    for reading in range(z.shape[0]):
        at = seen[reading]
        total = p[at, at] + variance[reading]
        innovation = z[reading] - x[at]
        squared += innovation * innovation / total
        log_determinant += math.log(total)
        for i in range(n):
            gain[i] = p[i, at] / total
        row = p[at].copy()
        for i in range(n):
            x[i] += gain[i] * innovation
            for j in range(i + 1):
                value = p[i, j] - gain[i] * row[j] - row[i] * gain[j] + gain[i] * total * gain[j]
                p[i, j] = value
                p[j, i] = value
    return x, p, squared, log_determinant


class BatchedUnscentedFilter(UnscentedKalmanFilter):  # type: ignore[misc]
    """Unscented filter over `propagate(states, dt)`, with its states read directly.

    Parameters
    ----------
    dim : int
        Number of states.
    propagate : callable
        Moves an array of states (points, dim) by dt [s] and returns it.
    """

    x: _Floats
    P: _Floats

    def __init__(self, dim: int, propagate: Callable[[_Floats, float], _Floats]) -> None:
        # alpha = 1: a smaller one makes the centre weight hugely negative. beta = 0 and kappa = 1
        # keep every weight positive and alike for mean and covariance, so that the weighted sum
        # is a covariance.
        points = MerweScaledSigmaPoints(dim, 1.0, 0.0, 1.0)
        super().__init__(dim, dim, 1.0, None, None, points)
        self._propagate = propagate
        self._spread = dim + 1.0
        self.Q = np.zeros(dim)

    def posterior_points(self) -> _Floats:
        """Sigma points (2 dim + 1, dim) of the present state."""
        return sigma_points(self.x, self.P, self._spread)

    def fade(self, anchor: _Floats, memory: _Floats, added: _Floats) -> None:
        """Keep a share `memory` (dim,) of the distance from `anchor` (dim,), and add variance.

        What has so changed takes part in the motion that `predict` follows with.
        """
        self.x = anchor + memory * (self.x - anchor)
        self.P = self.P * memory * memory[:, None] + np.diag(added)

    def compute_process_sigmas(self, dt: float, *_: object) -> None:
        """Draw points from the present state and move them all at once."""
        self.sigmas_f = self._propagate(self.posterior_points(), dt)

    def predict(self, dt: float, *_: object) -> None:
        """Advance state and covariance by `dt` [s]; `Q` is the diagonal that `dt` adds."""
        self.compute_process_sigmas(dt)
        self.x, self.P = moments(self.sigmas_f, self.Wm, self.Q)

    def update(self, z: _Floats, variance: _Floats, seen: _Places) -> tuple[float, float]:
        """Take in readings of the states `seen`.

        Returns
        -------
        tuple of float
            Normalised innovation squared, and ln of the readings' likelihood.
        """
        self.x, self.P, squared, log_determinant = take_in(self.x, self.P, z, variance, seen)
        likelihood = -0.5 * (squared + log_determinant + len(z) * math.log(2.0 * math.pi))
        return squared, likelihood
