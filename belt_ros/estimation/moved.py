"""What a motion makes of mean and covariance, by sigma points of which only some states move.

What stays where it is keeps its covariance, and goes with what moves as the points either side of
the mean say: that is all of the unscented transform that is not known before it.
"""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.torque_told import Told
from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]


@compiled
def slopes_of(moved: _Floats, moving: _Places, spread: _Floats) -> _Floats:
    """How much the states `moving` (m,) change along each column (n, m), by points (2 n + 1, n)."""
    n = spread.size
    slopes = np.empty((n, moving.size))
    for k in range(n):
        half = 0.5 / math.sqrt(spread[k])
        for a in range(moving.size):
            slopes[k, a] = half * (moved[1 + k, moving[a]] - moved[1 + n + k, moving[a]])
    return slopes


@compiled
def _set_means_and_spread(
    mean: _Floats, covariance: _Floats, moved: _Floats, moving: _Places, weights: _Floats
) -> None:
    """Set what the points themselves tell: means of the states `moving`, and their covariance."""
    points, count = moved.shape[0], moving.size
    away = np.empty((count, points))
    for a in range(count):
        total = 0.0
        for p in range(points):
            away[a, p] = moved[p, moving[a]]
            total += weights[p] * away[a, p]
        mean[moving[a]] = total
        for p in range(points):
            away[a, p] -= total
    for a in range(count):
        for b in range(a + 1):
            total = 0.0
            for p in range(points):
                total += weights[p] * away[a, p] * away[b, p]
            covariance[moving[a], moving[b]] = covariance[moving[b], moving[a]] = total


@compiled
def moved_belief(
    mean: _Floats,
    covariance: _Floats,
    known: Told,
    columns: _Floats,
    slopes: _Floats,
    rows: _Floats,
    moved: _Floats,
    moving: _Places,
    weights: _Floats,
) -> tuple[_Floats, _Floats, _Floats]:
    """Mean and covariance after a motion, and the covariance across it.

    Parameters
    ----------
    mean, covariance : ndarray
        Before the motion (n,) and (n, n).
    known : Told
        The same by the readings that say where points are laid; what they took is given back.
    columns, slopes : ndarray
        Along which points were laid (n, n), and what moves along them (n, m), see `slopes_of`.
    rows : ndarray
        What moves along each of `known.taken` (r, m), see `torque_told.moved_along`.
    moved : ndarray
        The points after the motion (2 n + 1, n).
    moving : ndarray
        Places of the states that move (m,).
    weights : ndarray
        Of the points.

    Returns
    -------
    tuple of ndarray
        (n,), (n, n), and (n, n) with rows for before and columns for after.
    """
    n, count = mean.size, moving.size
    mean_after, covariance_after, across = mean.copy(), covariance.copy(), covariance.copy()
    together = np.zeros((count, n))
    for a in range(count):
        for k in range(n):
            for i in range(n):
                together[a, i] += slopes[k, a] * columns[k, i]
        for r in range(rows.shape[0]):
            for i in range(n):
                together[a, i] += rows[r, a] * known.taken[r, i]
        at = moving[a]
        for i in range(n):
            across[i, at] = covariance_after[i, at] = covariance_after[at, i] = together[a, i]
    _set_means_and_spread(mean_after, covariance_after, moved, moving, weights)
    for r in range(rows.shape[0]):
        for a in range(count):
            mean_after[moving[a]] -= known.scores[r] * rows[r, a]
            for b in range(count):
                covariance_after[moving[a], moving[b]] += rows[r, a] * rows[r, b]
    return mean_after, covariance_after, across
