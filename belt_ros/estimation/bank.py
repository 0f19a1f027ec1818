"""A bank of unscented filters of the belt, moved, updated and read in one compiled call each.

filterpy's `UnscentedKalmanFilter` carries it: its points' weights, and predict and update, here for
all members at once. With one member it is the stock class, to rounding.
"""

import numpy as np
from filterpy.kalman import UnscentedKalmanFilter
from numpy.typing import NDArray

from belt_ros.estimation.process import Process
from belt_ros.estimation.state import READINGS, STATES, Index, propagate, read, step_direction
from belt_ros.estimation.unscented import (
    GradedSigmaPoints,
    mean_and_deviation,
    moments,
    sigma_points,
    sigma_points_along,
    take_in,
)
from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]
# The model bends in ln kf, ln tension, ln mu and the pull, in that order. Beside the creep's error
# the other states matter to a step only by the pull that it leads to, see `step_direction`.
_PULL = int(Index.PULL)
_BENT = {
    Index.LOG_STIFFNESS: 3.0,
    Index.LOG_TENSION: 4.0,
    Index.LOG_FRICTION: 8.0,
    Index.PULL: 8.0,
}
_ORDER = [*_BENT, Index.CREEP_ERROR]
_ORDER += [index for index in Index if index not in _ORDER]
POINTS = GradedSigmaPoints(_ORDER, list(_BENT.values()))


def motion_points(constants: DriveConstants, dt: float) -> GradedSigmaPoints:
    """Return the points of a step of `dt` [s]: `POINTS`, the pull's being that after the step."""
    return GradedSigmaPoints(
        _ORDER, list(_BENT.values()), _PULL, lambda x: step_direction(constants, x, dt)
    )


@compiled
def _predict_members(
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
) -> tuple[_Floats, _Floats]:
    """Fade and move each member by the process of its mode."""
    members, n = x.shape
    x_out = np.empty((members, n))
    p_out = np.empty((members, n, n))
    mean = np.empty(n)
    p = np.empty((n, n))
    for k in range(members):
        process = processes[mode[k]]
        memory = process.memory
        for i in range(n):
            mean[i] = anchor[i] + memory[i] * (x[k, i] - anchor[i])
            for j in range(n):
                p[i, j] = covariance[k, i, j] * memory[i] * memory[j]
            p[i, i] += process.belt_variance[i]
        along = step_direction(c, mean, dt)
        moved = propagate(c, sigma_points_along(mean, p, order, spread, _PULL, along), dt)
        x_out[k], p_out[k] = moments(moved, weights, process.motion_variance)
    return x_out, p_out


@compiled
def _update_members(
    x: _Floats, covariance: _Floats, z: _Floats, variance: _Floats, seen: _Places
) -> tuple[_Floats, _Floats]:
    x_out = np.empty_like(x)
    p_out = np.empty_like(covariance)
    for k in range(x.shape[0]):
        x_out[k], p_out[k] = take_in(x[k], covariance[k], z, variance, seen)
    return x_out, p_out


@compiled
def _read_members(
    c: DriveConstants,
    x: _Floats,
    covariance: _Floats,
    order: _Places,
    spread: _Floats,
    weights: _Floats,
    slowest: float,
) -> tuple[_Floats, _Floats]:
    """Means and standard deviations of the readings, a row for each member."""
    members = x.shape[0]
    means = np.empty((members, READINGS))
    deviations = np.empty((members, READINGS))
    for k in range(members):
        points = sigma_points(x[k], covariance[k], order, spread)
        means[k], deviations[k] = mean_and_deviation(read(c, points, slowest), weights)
    return means, deviations


class UnscentedBank(UnscentedKalmanFilter):  # type: ignore[misc]
    """Unscented filters of one drive, side by side.

    Parameters
    ----------
    constants : DriveConstants
    anchor : ndarray
        State (11,) to which what the belt is returns.

    Attributes
    ----------
    x : ndarray
        States (members, 11).
    P : ndarray
        Covariances (members, 11, 11).
    """

    x: _Floats
    P: _Floats

    def __init__(self, constants: DriveConstants, anchor: _Floats) -> None:
        super().__init__(STATES, STATES, 1.0, None, None, POINTS)
        self._constants = constants
        self._anchor = anchor
        self.x = np.zeros((0, STATES))
        self.P = np.zeros((0, STATES, STATES))

    def __len__(self) -> int:
        """Return the number of members."""
        return len(self.x)

    def predict(self, dt: float, processes: tuple[Process, Process], mode: _Places) -> None:
        """Advance every member by `dt` [s], by the process that its `mode`, 0 or 1, says.

        What fades does so first, and takes part in the motion that follows.
        """
        self.x, self.P = _predict_members(
            self._constants,
            self.x,
            self.P,
            processes,
            mode,
            self._anchor,
            POINTS.order,
            POINTS.spread,
            POINTS.Wm,
            dt,
        )

    def fade(self, processes: tuple[Process, Process], mode: _Places) -> None:
        """Let what the belt is fade as in `predict`, without any motion."""
        memory = np.stack([process.memory for process in processes])[mode]
        faded = np.stack([process.belt_variance for process in processes])[mode]
        self.x = self._anchor + memory * (self.x - self._anchor)
        self.P = self.P * memory[:, :, None] * memory[:, None, :]
        self.P[:, range(STATES), range(STATES)] += faded

    def update(self, z: _Floats, variance: _Floats, seen: _Places) -> None:
        """Take readings of the states `seen` into every member."""
        self.x, self.P = _update_members(self.x, self.P, z, variance, seen)

    def read(self, members: _Places, slowest: float) -> tuple[_Floats, _Floats]:
        """Means and deviations (members, 11) of `state.Reading`, by unscented transform.

        `slowest` is the rim speed [m/s] below which slip is referred to it.
        """
        return _read_members(
            self._constants,
            self.x[members],
            self.P[members],
            POINTS.order,
            POINTS.spread,
            POINTS.Wm,
            slowest,
        )
