"""The unscented filter's work on points and covariance, compiled.

Two things are done differently from filterpy's stock class, against which tests hold the result:

* the square root is taken of the correlation matrix, since the states' scales differ by ten
  decades, and a pivot that rounding has made negative is lifted, which only widens the estimate;
* measurements read states directly, so each is taken in by Joseph's scalar form. That is what the
  unscented transform of a linear function gives, exactly, for any subset of the sensors.
"""

import math

import numpy as np
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
