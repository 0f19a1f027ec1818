"""Where a step's sigma points are laid: where the torques' readings say that the load is.

A load that may wander fast leaves the pull wide open before the step's readings are taken in. Near
its knee a belt then answers points far beyond what it carries, and a straight line through those is
no model of what happened. Torques do not change in a step's motion, so what was read of them at its
end is known before it: points are laid about what the state is by these readings, and the line that
they give is followed back to where nothing had been read. What comes out is still a prediction,
in which the torques have no part but by where it has been made straight. (Posterior linearisation,
Garcia-Fernandez et al. 2015, doi:10.1109/TSP.2015.2454485, of those readings that need no solution
of the model.)
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.state import Index
from belt_ros.estimation.unscented import take_in
from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]
# Compiled code wants plain integers.
_DRIVER_TORQUE, _DRIVEN_TORQUE = int(Index.DRIVER_TORQUE), int(Index.DRIVEN_TORQUE)
_UNBELIEVABLE = 16.0  # innovation squared over its variance, from which a reading lays no points
_TELLING = 0.1  # share of that variance which is not the reading's own; with less, it tells little


class Torques(NamedTuple):
    """What was read of the torques at a step's end."""

    z: _Floats  # (m,)
    variance: _Floats  # (m,)
    places: _Places  # (m,) in the state


class Told(NamedTuple):
    """A state by these readings, and what they have taken off it."""

    mean: _Floats  # (n,)
    covariance: _Floats  # (n, n)
    taken: _Floats  # (m, n): before, the covariance was more by the sum of their squares ...
    scores: _Floats  # (m,) ... and the mean less by the sum of so many times each


NOTHING_READ = Torques(np.zeros(0), np.zeros(0), np.zeros(0, dtype=np.int64))


@compiled
def torques_among(z: _Floats, variance: _Floats, places: _Places) -> Torques:
    """Return readings of the torques among those of states, whose places ascend."""
    begin = end = 0
    for place in places:
        begin += place < _DRIVER_TORQUE
        end += place <= _DRIVEN_TORQUE
    return Torques(z[begin:end], variance[begin:end], places[begin:end])


@compiled
def told(mean: _Floats, covariance: _Floats, torques: Torques) -> Told:
    """Take readings into a state (n,) with its covariance, if they tell and can be believed."""
    count = torques.z.size
    taken, scores = np.zeros((count, mean.size)), np.zeros(count)
    for r in range(count):
        at = torques.places[r]
        deviation = math.sqrt(covariance[at, at] + torques.variance[r])
        score = (torques.z[r] - mean[at]) / deviation
        tells = covariance[at, at] > _TELLING * deviation**2
        if tells and score * score < _UNBELIEVABLE:
            scores[r] = score
            for i in range(mean.size):
                taken[r, i] = covariance[at, i] / deviation
            one = slice(r, r + 1)
            mean, covariance = take_in(
                mean, covariance, torques.z[one], torques.variance[one], torques.places[one]
            )
    return Told(mean, covariance, taken, scores)


@compiled
def _shares(columns: _Floats, order: _Places, at: int, along: _Floats, vector: _Floats) -> _Floats:
    """How often each of `unscented.columns_along` counts in a vector (n,)."""
    n = vector.size
    rest, shares = vector.copy(), np.zeros(n)
    for k in range(n):
        column, place = columns[k], order[k]
        pivot, left = column[place], rest[place]
        if place == at:
            pivot, left = 0.0, 0.0
            for i in range(n):
                pivot += along[i] * column[i]
                left += along[i] * rest[i]
        if pivot > 0.0:
            shares[k] = left / pivot
            for i in range(n):
                rest[i] -= shares[k] * column[i]
    return shares


@compiled
def moved_along(
    known: Told, columns: _Floats, order: _Places, at: int, along: _Floats, slopes: _Floats
) -> _Floats:
    """Return what becomes of each row of `known.taken` by the line through sigma points.

    Parameters
    ----------
    known : Told
    columns, order, at, along
        By which the points were laid, see `unscented.columns_along`.
    slopes : ndarray
        How much the states that move change along each column (n, m).

    Returns
    -------
    ndarray
        (r, m)
    """
    moved = np.zeros((known.scores.size, slopes.shape[1]))
    for r in range(known.scores.size):
        if known.scores[r] == 0.0:
            continue
        shares = _shares(columns, order, at, along, known.taken[r])
        for k in range(shares.size):
            for a in range(slopes.shape[1]):
                moved[r, a] += shares[k] * slopes[k, a]
    return moved
