"""A bank of unscented filters of the belt, moved, updated and read in one compiled call each.

filterpy's `UnscentedKalmanFilter` carries it: its points' weights, and predict and update, here for
all members at once. With one member it is the stock class, to rounding.
"""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.lean_filterpy import UnscentedKalmanFilter
from belt_ros.estimation.load_sensors import load_readings, observe
from belt_ros.estimation.moved import moved_belief, slopes_of
from belt_ros.estimation.process import Process
from belt_ros.estimation.state import (
    MOVING,
    READINGS,
    STATES,
    Index,
    Reading,
    propagate,
    read,
    step_direction,
)
from belt_ros.estimation.torque_told import NOTHING_READ, Torques, moved_along, told
from belt_ros.estimation.unscented import (
    GradedSigmaPoints,
    columns_along,
    mean_and_deviation,
    points_about,
    sigma_points,
    take_in,
    upper_root,
)
from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]
# The model bends in ln kf, ln tension, ln mu and the pull, in that order. Beside the creep's error
# the other states matter to a step only by the pull that it leads to, see `step_direction`.
_PULL = int(Index.PULL)
_MARGIN, _CAPACITY = int(Reading.MARGIN), int(Reading.CAPACITY)
_FOLDED = 3.0  # deviations of the pull from none, within which its size hides them from the margin
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
    torques: Torques,
    crosses: _Floats,
) -> tuple[_Floats, _Floats]:
    """Fade and move each member by the process of its mode, by points laid where torques tell.

    Covariances across the motion are written to `crosses` (members, n, n), unless it is empty.
    """
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
                p[i, j] += process.covariance_before[i, j]
        known = told(mean, p, torques)
        along = step_direction(c, known.mean, dt)
        columns = columns_along(known.covariance, order, _PULL, along)
        points = points_about(known.mean, columns, spread)
        moved = propagate(c, points, dt)
        slopes = slopes_of(moved, MOVING, spread)
        rows = moved_along(known, columns, order, _PULL, along, slopes)
        x_out[k], p_out[k], across = moved_belief(
            mean, p, known, columns, slopes, rows, moved, MOVING, weights
        )
        for i in range(n):
            p_out[k, i, i] += process.variance_after[i]
        if crosses.shape[0] > 0:
            crosses[k] = across
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
def _innovations_squared(
    x: _Floats,
    covariance: _Floats,
    weights: _Floats,
    z: _Floats,
    variance: _Floats,
    seen: _Places,
) -> tuple[_Floats, _Floats]:
    """Each member's innovation squared, normalised by the covariance of the sum.

    Members are compared by what they predict. How uncertain each is of loads and noise says
    nothing of the belt, and where that is misjudged, it would favour the most certain for ever.
    """
    count = z.size
    spread = np.diag(variance)
    for k in range(weights.size):
        for i in range(count):
            for j in range(count):
                spread[i, j] += weights[k] * covariance[k, seen[i], seen[j]]
    surprises = np.zeros(count)
    for i in range(count):
        for k in range(weights.size):
            surprises[i] += weights[k] * (z[i] - x[k, seen[i]])
        surprises[i] = surprises[i] ** 2 / spread[i, i]
    root = upper_root(spread)
    squared = np.empty(weights.size)
    whitened = np.empty(count)
    for k in range(weights.size):
        for i in range(count):
            rest = z[i] - x[k, seen[i]]
            for j in range(i):
                rest -= root[j, i] * whitened[j]
            whitened[i] = rest / root[i, i]
        squared[k] = np.sum(whitened**2)
    return squared, surprises


@compiled
def _observe_members(
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
            x_out[k], p_out[k] = seen.x, seen.covariance
    return x_out, p_out, innovation, foretold


@compiled
def _read_members(
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
        means[row], deviations[row] = mean_and_deviation(read(c, points, slowest), weights)
        doubt = math.sqrt(covariance[k, _PULL, _PULL])
        if abs(x[k, _PULL]) < _FOLDED * doubt and means[row, _CAPACITY] > 0.0:
            share = doubt * c.driven_radius / means[row, _CAPACITY]
            deviations[row, _MARGIN] = max(deviations[row, _MARGIN], share)
    return means, deviations


class UnscentedBank(UnscentedKalmanFilter):  # type: ignore[misc]
    """Unscented filters of one drive, side by side.

    Parameters
    ----------
    constants : DriveConstants
    anchor : ndarray
        State (12,) to which what the belt is returns.

    Attributes
    ----------
    x : ndarray
        States (members, 12).
    P : ndarray
        Covariances (members, 12, 12).
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

    def predict(
        self,
        dt: float,
        processes: tuple[Process, Process],
        mode: _Places,
        *,
        torques: Torques = NOTHING_READ,
        crosses: bool = False,
    ) -> _Floats:
        """Advance every member by `dt` [s], by the process that its `mode`, 0 or 1, says.

        What fades does so first, and takes part in the motion that follows. `torques` at the end of
        the step are not taken in, but say where the model is to be made straight.

        Returns
        -------
        ndarray
            Covariances (members, 12, 12) of faded (row) and moved states, if `crosses` are asked
            for; else (0, 12, 12).
        """
        across = np.empty((len(self) if crosses else 0, STATES, STATES))
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
            torques,
            across,
        )
        return across

    def fade(self, processes: tuple[Process, Process], mode: _Places) -> None:
        """Let what the belt is fade as in `predict`, without any motion."""
        memory = np.stack([process.memory for process in processes])[mode]
        gained = np.stack([process.covariance_before for process in processes])[mode]
        self.x = self._anchor + memory * (self.x - self._anchor)
        self.P = self.P * memory[:, :, None] * memory[:, None, :] + gained

    def innovations_squared(
        self, weights: _Floats, z: _Floats, variance: _Floats, seen: _Places
    ) -> tuple[_Floats, _Floats]:
        """Squared innovations, normalised by the covariance of the sum.

        `weights` (members,) sum to one; readings `z` of the states `seen` have `variance`.

        Returns
        -------
        squared : ndarray
            Of each member (members,), over all sensors.
        surprises : ndarray
            Of each sensor, that of the sum's mean.
        """
        squared, surprises = _innovations_squared(self.x, self.P, weights, z, variance, seen)
        return squared, surprises

    def observe_load(self, load: int, z: float, variance: float) -> tuple[_Floats, _Floats]:
        """Take a reading `z` [N] of a `load_sensors.Load` into every member.

        A member that knows the load better than its sensor does not learn from it: load cells err
        in gain, which many readings do not average out.

        Returns
        -------
        innovation, variance : ndarray
            Of each member (members,).
        """
        self.x, self.P, innovation, spread = _observe_members(
            self._constants,
            self.x,
            self.P,
            POINTS.order,
            POINTS.spread,
            POINTS.Wm,
            load,
            z,
            variance,
        )
        return innovation, spread

    def update(self, z: _Floats, variance: _Floats, seen: _Places) -> None:
        """Take readings of the states `seen` into every member."""
        self.x, self.P = _update_members(self.x, self.P, z, variance, seen)

    def read(self, members: _Places, slowest: float) -> tuple[_Floats, _Floats]:
        """Means and deviations (members, 12) of `state.Reading`, by unscented transform.

        `slowest` is the rim speed [m/s] below which slip is referred to it.
        """
        return _read_members(
            self._constants,
            members,
            self.x,
            self.P,
            POINTS.order,
            POINTS.spread,
            POINTS.Wm,
            slowest,
        )
