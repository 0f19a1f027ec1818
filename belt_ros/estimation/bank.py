"""A bank of unscented filters of the belt, moved, updated and read in one compiled call each.

filterpy's `UnscentedKalmanFilter` carries it: its points' weights, and predict and update, here for
all members at once. With one member it is the stock class, to rounding.
"""

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.bank_loops import (
    PULL,
    observe_members,
    predict_members,
    read_members,
    update_members,
)
from belt_ros.estimation.lean_filterpy import UnscentedKalmanFilter
from belt_ros.estimation.load import Activity
from belt_ros.estimation.one_step import Foretold, step_members
from belt_ros.estimation.process import CreepChange, Process, Wander
from belt_ros.estimation.state import STATES, Index, step_direction
from belt_ros.estimation.torque_told import NOTHING_READ, Torques
from belt_ros.estimation.unscented import GradedSigmaPoints
from belt_ros.mechanics.constants import DriveConstants

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]
# The model bends in ln kf, ln tension, ln mu and the pull, in that order. Beside the creep's error
# the other states matter to a step only by the pull that it leads to, see `step_direction`.
_BENT = {
    Index.LOG_STIFFNESS: 3.0,
    Index.LOG_TENSION: 4.0,
    Index.LOG_FRICTION: 8.0,
    Index.PULL: 8.0,
}
_ORDER = [*_BENT, Index.CREEP_ERROR]
_ORDER += [index for index in Index if index not in _ORDER]
POINTS = GradedSigmaPoints(_ORDER, list(_BENT.values()))
_NO_CROSSES = np.empty((0, STATES, STATES))


def motion_points(constants: DriveConstants, dt: float) -> GradedSigmaPoints:
    """Return the points of a step of `dt` [s]: `POINTS`, the pull's being that after the step."""
    return GradedSigmaPoints(
        _ORDER, list(_BENT.values()), PULL, lambda x: step_direction(constants, x, dt)
    )


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
        self._packed = tuple(constants)  # see `step_members`
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
        across = np.empty((len(self), STATES, STATES)) if crosses else _NO_CROSSES
        self.x, self.P = predict_members(
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

    def step(
        self,
        dt: float,
        added: tuple[Wander, Activity, CreepChange, float],
        mode: _Places,
        member_weights: _Floats,
        readings: tuple[_Floats, _Floats, _Places],
        *,
        crosses: bool = False,
    ) -> Foretold:
        """Advance as `predict` does, and compare with what was read at the end.

        Parameters
        ----------
        dt : float
        added : tuple
            Of which `process.drift_processes` makes the processes.
        mode : ndarray
            Of each member, 0 or 1.
        member_weights : ndarray
            (members,), summing to one.
        readings : tuple of ndarray
            Values, variances and the states that they read (m,), ascending.
        crosses : bool
            Whether covariances across the motion are asked for.
        """
        wander, activity, undeveloped, change = added
        z, variance, places = readings
        across = np.empty((len(self), STATES, STATES)) if crosses else _NO_CROSSES
        self.x, self.P, squared, least, average, surprises, lead = step_members(
            self._packed,
            tuple(wander),
            activity.taken,
            activity.shown,
            undeveloped,
            dt,
            change,
            self.x,
            self.P,
            mode,
            member_weights,
            self._anchor,
            POINTS.order,
            POINTS.spread,
            POINTS.Wm,
            z,
            variance,
            places,
            across,
        )
        return Foretold(squared, least, average, surprises, lead, across)

    def observe_load(self, load: int, z: float, variance: float) -> tuple[_Floats, _Floats]:
        """Take a reading `z` [N] of a `load_sensors.Load` into every member.

        A member that knows the load better than its sensor does not learn from it: load cells err
        in gain, which many readings do not average out.

        Returns
        -------
        innovation, variance : ndarray
            Of each member (members,).
        """
        self.x, self.P, innovation, spread = observe_members(
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
        self.x, self.P = update_members(self.x, self.P, z, variance, seen)

    def read(self, members: _Places, slowest: float) -> tuple[_Floats, _Floats]:
        """Means and deviations (members, 12) of `state.Reading`, by unscented transform.

        `slowest` is the rim speed [m/s] below which slip is referred to it.
        """
        return read_members(
            self._constants,
            members,
            self.x,
            self.P,
            POINTS.order,
            POINTS.spread,
            POINTS.Wm,
            slowest,
        )
