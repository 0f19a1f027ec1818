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
    """Set what the points themselves tell: means of the states `moving`, and their covariance.

    Leaves of each point how far it is from the mean.
    """
    points, count = moved.shape[0], moving.size
    for a in range(count):
        at, total = moving[a], 0.0
        for p in range(points):
            total += weights[p] * moved[p, at]
        mean[at] = total
        for p in range(points):
            moved[p, at] -= total
    for a in range(count):
        for b in range(a + 1):
            one, other, total = moving[a], moving[b], 0.0
            for p in range(points):
                total += weights[p] * moved[p, one] * moved[p, other]
            covariance[one, other] = covariance[other, one] = total


@compiled
def together(known: Told, columns: _Floats, slopes: _Floats, rows: _Floats) -> _Floats:
    """Covariances (m, n) of the states that move, after a motion, with all before it.

    Parameters
    ----------
    known : Told
        By the readings that say where points are laid; what they took is given back.
    columns, slopes : ndarray
        Along which points were laid (n, n), and what moves along them (n, m), see `slopes_of`.
    rows : ndarray
        What moves along each of `known.taken` (r, m), see `torque_told.moved_along`.
    """
    n, count = slopes.shape
    out = np.zeros((count, n))
    for a in range(count):
        for k in range(n):
            for i in range(n):
                out[a, i] += slopes[k, a] * columns[k, i]
        for r in range(rows.shape[0]):
            for i in range(n):
                out[a, i] += rows[r, a] * known.taken[r, i]
    return out


@compiled
def across(covariance: _Floats, moving: _Places, shared: _Floats) -> _Floats:
    """Covariance (n, n) with rows for before and columns for after a motion.

    By that before (n, n), and `shared` (m, n) from `together`.
    """
    out = covariance.copy()
    for a in range(moving.size):
        for i in range(out.shape[0]):
            out[i, moving[a]] = shared[a, i]
    return out


@compiled
def move_belief(
    mean: _Floats,
    covariance: _Floats,
    scores: _Floats,
    rows: _Floats,
    shared: _Floats,
    moved: _Floats,
    moving: _Places,
    weights: _Floats,
) -> None:
    """Make of mean and covariance before a motion those after it.

    Parameters
    ----------
    mean, covariance : ndarray
        (n,) and (n, n), to be changed.
    scores : ndarray
        Of the readings that say where points are laid (r,), see `Told`.
    rows : ndarray
        What moves along each of `Told.taken` (r, m), see `torque_told.moved_along`.
    shared : ndarray
        (m, n) from `together`.
    moved : ndarray
        The points after the motion (2 n + 1, n); lost.
    moving : ndarray
        Places of the states that move (m,).
    weights : ndarray
        Of the points.
    """
    count = moving.size
    for a in range(count):
        at = moving[a]
        for i in range(mean.size):
            covariance[i, at] = covariance[at, i] = shared[a, i]
    _set_means_and_spread(mean, covariance, moved, moving, weights)
    for r in range(scores.size):
        for a in range(count):
            mean[moving[a]] -= scores[r] * rows[r, a]
            for b in range(count):
                covariance[moving[a], moving[b]] += rows[r, a] * rows[r, b]
