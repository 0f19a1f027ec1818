"""How well each member of a Gaussian sum has foretold what was read, beside the others.

Members are compared by what they predict. How uncertain each is of loads and noise says nothing of
the belt, and where that is misjudged, it would favour the most certain for ever. So all innovations
are normalised by one covariance, that of the sum.

What a change of the torques lets expect of the speeds is part of what a member predicts: under a
greater load one belt holds, and another slips. By the covariance of the sum all would be expected
to do what the heaviest members do, and a belt that rightly holds would be ruled out while these
slip. So what is certain of such a change counts by each member's own covariance. What the sensor's
noise may explain does not: where the load is taken for livelier than it is, noise is taken for a
load, and that slip does not follow it would speak for belts far from their knee.
"""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.state import Index
from belt_ros.estimation.unscented import upper_root
from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]
_Pair = tuple[float, float]
_EXPLAINED = 3.0  # deviations of a torque's noise, within which it may explain an innovation
# Compiled code wants plain integers.
_DRIVER_TORQUE, _DRIVEN_TORQUE = int(Index.DRIVER_TORQUE), int(Index.DRIVEN_TORQUE)


@compiled
def _torques(seen: _Places) -> tuple[int, int]:
    """Return which of the readings are torques: the first and the last of them, or -1."""
    first, last = -1, -1
    for i in range(seen.size):
        if seen[i] == _DRIVER_TORQUE or seen[i] == _DRIVEN_TORQUE:
            first, last = (i if first < 0 else first), i
    return first, last


@compiled
def _certain(innovation: float, variance: float) -> float:
    """Return what of a torque's innovation its noise does not explain."""
    beyond = max(abs(innovation) - _EXPLAINED * math.sqrt(variance), 0.0)
    return math.copysign(beyond, innovation)


@compiled
def _changes(innovation: _Floats, variance: _Floats, torques: tuple[int, int]) -> _Pair:
    """Return what is certain of how the torques have changed."""
    a, b = torques
    if a < 0:
        return 0.0, 0.0
    return _certain(innovation[a], variance[a]), _certain(innovation[b], variance[b])


@compiled
def _expected(covariance: _Floats, row: int, torques: tuple[int, int], changes: _Pair) -> float:
    """Innovation that changes of the torques let expect in one reading."""
    a, b = torques
    of_a, of_b, crossed = covariance[a, a], covariance[b, b], covariance[a, b]
    if a == b:
        alone: float = covariance[row, a] / of_a * changes[0]
        return alone
    by_a = covariance[row, a] * of_b - covariance[row, b] * crossed
    by_b = covariance[row, b] * of_a - covariance[row, a] * crossed
    both: float = (by_a * changes[0] + by_b * changes[1]) / (of_a * of_b - crossed * crossed)
    return both


@compiled
def _tell(
    innovation: _Floats, torques: tuple[int, int], changes: _Pair, own: _Floats, spread: _Floats
) -> None:
    """Let changes of the torques be followed as a member's `own` covariance has it."""
    for i in range(innovation.size):
        if i != torques[0] and i != torques[1]:
            innovation[i] += _expected(spread, i, torques, changes)
            innovation[i] -= _expected(own, i, torques, changes)


@compiled
def _of_readings(covariance: _Floats, variance: _Floats, seen: _Places, out: _Floats) -> None:
    """Write the covariance of what a member foretells of the readings, noise included."""
    for i in range(seen.size):
        for j in range(seen.size):
            out[i, j] = covariance[seen[i], seen[j]]
        out[i, i] += variance[i]


@compiled
def innovations_squared(
    x: _Floats,
    covariance: _Floats,
    weights: _Floats,
    z: _Floats,
    variance: _Floats,
    seen: _Places,
) -> tuple[_Floats, _Floats]:
    """Return each member's innovation squared, normalised by the covariance of the sum.

    Parameters
    ----------
    x, covariance : ndarray
        Members before the readings, (k, n) and (k, n, n).
    weights : ndarray
        Of the members (k,), summing to one.
    z, variance, seen : ndarray
        Values, variances and the states that they read (m,), ascending.

    Returns
    -------
    squared : ndarray
        Of each member (k,).
    surprises : ndarray
        Of the sum's mean at each reading (m,), over its own variance.
    """
    members, count = weights.size, z.size
    spread, own = np.zeros((count, count)), np.empty((count, count))
    surprises = np.zeros(count)
    for i in range(count):
        spread[i, i] = variance[i]
        for j in range(count):
            for k in range(members):
                spread[i, j] += weights[k] * covariance[k, seen[i], seen[j]]
        for k in range(members):
            surprises[i] += weights[k] * (z[i] - x[k, seen[i]])
        surprises[i] = surprises[i] ** 2 / spread[i, i]
    root = upper_root(spread)
    torques = _torques(seen)
    squared, innovation = np.zeros(members), np.empty(count)
    for k in range(members):
        for i in range(count):
            innovation[i] = z[i] - x[k, seen[i]]
        changes = _changes(innovation, variance, torques)
        if changes[0] != 0.0 or changes[1] != 0.0:
            _of_readings(covariance[k], variance, seen, own)
            _tell(innovation, torques, changes, own, spread)
        for i in range(count):
            for j in range(i):
                innovation[i] -= root[j, i] * innovation[j]
            innovation[i] /= root[i, i]
            squared[k] += innovation[i] ** 2
    return squared, surprises
