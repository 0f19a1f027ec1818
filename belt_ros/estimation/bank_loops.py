"""The work of a bank of unscented filters on all members, a compiled call each."""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.load_sensors import load_readings, observe
from belt_ros.estimation.moved import across, move_belief, slopes_of, together
from belt_ros.estimation.process import Process
from belt_ros.estimation.state import (
    MOVING,
    READINGS,
    Index,
    Reading,
    propagate_each,
    read,
    step_direction,
)
from belt_ros.estimation.torque_told import Torques, moved_along, told
from belt_ros.estimation.unscented import (
    columns_along,
    lay_points,
    mean_and_deviation,
    sigma_points,
    take_in_place,
)
from belt_ros.estimation.written import write, write_matrix
from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]
_FOLDED = 3.0  # deviations of the pull from none, within which its size hides them from the margin
# Compiled code wants plain integers.
PULL = int(Index.PULL)
_MARGIN, _CAPACITY = int(Reading.MARGIN), int(Reading.CAPACITY)


@compiled
def predict_members(
    c: DriveConstants,
    x: _Floats,
    covariance: _Floats,
    processes: tuple[Process, Process],
    mode: _Places,
    anchor: _Floats,
    order: _Places,
    spread: _Floats,
    weights: _Floats,
    dt: float,
    torques: Torques,
    crosses: _Floats,
) -> tuple[_Floats, _Floats]:
    """Fade and move each member by the process of its mode, by points laid where torques tell.

    Covariances across the motion are written to `crosses` (members, n, n), unless it is empty.
    """
    members, n = x.shape
    x_out = np.empty((members, n))
    p_out = np.empty((members, n, n))
    points = np.empty((2 * n + 1, n))
    for k in range(members):
        mean, p = x_out[k], p_out[k]
        process = processes[mode[k]]
        memory = process.memory
        for i in range(n):
            mean[i] = anchor[i] + memory[i] * (x[k, i] - anchor[i])
            for j in range(n):
                p[i, j] = covariance[k, i, j] * memory[i] * memory[j]
                p[i, j] += process.covariance_before[i, j]
        known = told(mean, p, torques)
        along = step_direction(c, known.mean, dt)
        columns = columns_along(known.covariance, order, PULL, along)
        lay_points(points, known.mean, columns, spread)
        propagate_each(c, points, dt)
        slopes = slopes_of(points, MOVING, spread)
        rows = moved_along(known, columns, order, PULL, along, slopes)
        shared = together(known, columns, slopes, rows)
        if crosses.shape[0] > 0:
            write_matrix(crosses[k], across(p, MOVING, shared))
        move_belief(mean, p, known.scores, rows, shared, points, MOVING, weights)
        for i in range(n):
            p[i, i] += process.variance_after[i]
    return x_out, p_out


@compiled
def update_members(
    x: _Floats, covariance: _Floats, z: _Floats, variance: _Floats, seen: _Places
) -> tuple[_Floats, _Floats]:
    """Take readings of the states `seen` into each member."""
    x_out, p_out = x.copy(), covariance.copy()
    scratch = np.empty((4, x.shape[1]))
    for k in range(x.shape[0]):
        take_in_place(x_out[k], p_out[k], z, variance, seen, scratch)
    return x_out, p_out


@compiled
def observe_members(
    c: DriveConstants,
    x: _Floats,
    covariance: _Floats,
    order: _Places,
    spread: _Floats,
    weights: _Floats,
    load: int,
    z: float,
    variance: float,
) -> tuple[_Floats, _Floats, _Floats, _Floats]:
    """Take a load into each member."""
    members = x.shape[0]
    x_out, p_out = x.copy(), covariance.copy()
    innovation, foretold = np.empty(members), np.empty(members)
    for k in range(members):
        points = sigma_points(x[k], covariance[k], order, spread)
        predicted = load_readings(c, points, read(c, points, 1.0))[:, load].copy()
        seen = observe(x[k], covariance[k], points, weights, predicted, z, variance)
        innovation[k], foretold[k] = seen.innovation, seen.variance
        if seen.variance > 2.0 * variance:
            write(x_out[k], seen.x)
            write_matrix(p_out[k], seen.covariance)
    return x_out, p_out, innovation, foretold


@compiled
def read_members(
    c: DriveConstants,
    members: _Places,
    x: _Floats,
    covariance: _Floats,
    order: _Places,
    spread: _Floats,
    weights: _Floats,
    slowest: float,
) -> tuple[_Floats, _Floats]:
    """Means and standard deviations of the readings, a row for each of some members."""
    means = np.empty((members.size, READINGS))
    deviations = np.empty((members.size, READINGS))
    for row, k in enumerate(members):
        points = sigma_points(x[k], covariance[k], order, spread)
        mean, deviation = mean_and_deviation(read(c, points, slowest), weights)
        write(means[row], mean)
        write(deviations[row], deviation)
        doubt = math.sqrt(covariance[k, PULL, PULL])
        if abs(x[k, PULL]) < _FOLDED * doubt and means[row, _CAPACITY] > 0.0:
            share = doubt * c.driven_radius / means[row, _CAPACITY]
            deviations[row, _MARGIN] = max(deviations[row, _MARGIN], share)
    return means, deviations
