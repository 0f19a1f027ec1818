"""One step of all members: a compiled call up to what was read, and one that takes it in."""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.bank_loops import predict_members, update_members
from belt_ros.estimation.foretold_slip import lead_innovation
from belt_ros.estimation.gaussian_sum import mixture_moments, normalised
from belt_ros.estimation.load import Activity
from belt_ros.estimation.process import CreepChange, Wander, drift_processes
from belt_ros.estimation.torque_told import torques_among
from belt_ros.estimation.weighing import innovations_squared
from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]
_Pair = tuple[float, float]


class Foretold(NamedTuple):
    """What was read at a step's end, beside what the members had foretold."""

    squared: _Floats  # innovation of each member (k,), by the covariance of the sum ...
    least: float  # ... that of the member whom the readings suit best, and the average
    average: float
    surprises: _Floats  # innovation squared of the sum's mean at each reading (m,)
    lead: float  # see `foretold_slip.lead_innovation`
    crosses: _Floats  # see `bank_loops.predict_members`


@compiled
def step_members(
    constants: tuple[Any, ...],
    wander: tuple[Any, ...],
    taken: _Pair,
    shown: _Pair,
    undeveloped: CreepChange,
    dt: float,
    change: float,
    x: _Floats,
    covariance: _Floats,
    mode: _Places,
    member_weights: _Floats,
    anchor: _Floats,
    order: _Places,
    spread: _Floats,
    weights: _Floats,
    z: _Floats,
    variance: _Floats,
    places: _Places,
    crosses: _Floats,
) -> tuple[_Floats, _Floats, _Floats, float, float, _Floats, float]:
    """Move members by `drift_processes` and `predict_members`, and compare them with readings.

    `DriveConstants` and `Wander` come as plain tuples: to pass a named one from Python takes numba
    as long as a quarter of a member's motion.

    Returns
    -------
    tuple
        Means, covariances, and of `Foretold` all but the crosses.
    """
    c, activity = DriveConstants(*constants), Activity(taken, shown, (0.0, 0.0))
    processes = drift_processes(Wander(*wander), c, activity, undeveloped, dt, change)
    torques = torques_among(z, variance, places)
    x, covariance = predict_members(
        c, x, covariance, processes, mode, anchor, order, spread, weights, dt, torques, crosses
    )
    squared, surprises = innovations_squared(x, covariance, member_weights, z, variance, places)
    radii = c.driver_radius, c.driven_radius
    lead = lead_innovation(radii, member_weights, x, covariance, z, variance, places)
    least, average = math.inf, 0.0
    for k in range(squared.size):
        least = min(least, squared[k])
        average += member_weights[k] * squared[k]
    return x, covariance, squared, least, average, surprises, lead


@compiled
def take_in_and_weigh(
    x: _Floats,
    covariance: _Floats,
    log_weights: _Floats,
    squared: _Floats,
    z: _Floats,
    variance: _Floats,
    places: _Places,
) -> tuple[_Floats, _Floats, _Floats, _Floats, _Floats, _Floats, bool]:
    """Take readings into members, and weigh these by what each has foretold worse than others.

    Returns
    -------
    tuple
        Means, covariances, logarithms of the weights, weights, mean and covariance of the sum, and
        whether all of it is finite.
    """
    x, covariance = update_members(x, covariance, z, variance, places)
    log_weights = log_weights.copy()
    best = -math.inf
    for k in range(squared.size):
        log_weights[k] -= 0.5 * squared[k]
        best = max(best, log_weights[k])
    for k in range(squared.size):
        log_weights[k] -= best
    weights = normalised(log_weights)
    mean, spread = mixture_moments(weights, x, covariance)
    finite = math.isfinite(log_weights.sum() + x.sum())
    return x, covariance, log_weights, weights, mean, spread, finite
