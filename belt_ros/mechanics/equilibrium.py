"""The two-pulley drive in steady state: torque to slip, slip to torque, capacity and margin."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.creep import (
    DriveConstants,
    creep,
    drive_constants,
    pull_at_creep,
    pull_capacity,
)
from belt_ros.mechanics.drive import BeltDrive, DriveError, Tensioning

_Floats = NDArray[np.float64]


class Equilibrium(NamedTuple):
    """Steady states of a drive, arrays of one common shape.

    Angles count from each pulley's own inlet. Slip is 1 - (R1 omega1)/(R2 omega2), negative when
    the load drives; torques are positive in the positive direction of rotation.
    """

    slip: _Floats  # [-]
    driven_speed: _Floats  # [rad/s]
    tight_tension: _Floats  # [N]
    slack_tension: _Floats  # [N]
    mean_tension: _Floats  # [N]
    driven_transition_angle: _Floats  # [rad]
    driver_transition_angle: _Floats  # [rad]
    driven_inlet_gradient: _Floats  # u1'(0) [-]
    driver_inlet_gradient: _Floats  # u2'(0) [-]
    torque_capacity: _Floats  # [N m] on the driven pulley
    margin: _Floats  # [-]


@compiled
def _steady_state(
    c: DriveConstants, force: float, tension: float, mu: float, kf: float, speed: float
) -> tuple[float, float, float, float, float]:
    """Slip, transition angles and gradients (driven, driver) at a pull along the rotation."""
    forward = force >= 0.0
    state = creep(c, abs(force), tension, mu, kf, speed, forward)
    if forward:
        return (
            state.slip,
            state.receiving_transition,
            state.giving_transition,
            state.receiving_gradient,
            state.giving_gradient,
        )
    return (
        state.slip / (state.slip - 1.0) if state.slip < 1.0 else -math.inf,
        state.giving_transition,
        state.receiving_transition,
        state.giving_gradient,
        state.receiving_gradient,
    )


@compiled
def _steady_states(c: DriveConstants, rows: _Floats, mu: float, kf: float) -> _Floats:
    """Rows (force, tension, speed) to rows of `_steady_state` and the capacity."""
    out = np.empty((rows.shape[0], 6))
    for i in range(rows.shape[0]):
        force, tension, speed = rows[i, 0], rows[i, 1], rows[i, 2]
        state = _steady_state(c, force, tension, mu, kf, speed)
        for j in range(5):
            out[i, j] = state[j]
        out[i, 5] = pull_capacity(c, tension, mu, speed)
    return out


@compiled
def _forces_at_slip(c: DriveConstants, rows: _Floats, mu: float, kf: float) -> _Floats:
    """Rows (slip, tension, speed) to effective pulls."""
    out = np.empty(rows.shape[0])
    for i in range(rows.shape[0]):
        slip, tension, speed = rows[i, 0], rows[i, 1], rows[i, 2]
        forward = slip >= 0.0
        received = slip if forward else slip / (slip - 1.0)
        start = received * c.axial_stiffness
        pull = pull_at_creep(c, 0.0, received, start, tension, mu, kf, speed, forward)
        out[i] = pull if forward else -pull
    return out


def _state_arrays(*values: ArrayLike) -> list[_Floats]:
    arrays = np.broadcast_arrays(*(np.asarray(value, dtype=np.float64) for value in values))
    if not all(np.all(np.isfinite(array)) for array in arrays):
        raise DriveError("the state asked for contains NaN or infinity")
    return list(arrays)


def _rows(*arrays: _Floats) -> _Floats:
    return np.stack(arrays, axis=-1).reshape(-1, len(arrays))


def _check_belt(drive: BeltDrive, tension: _Floats, rim_speed: _Floats) -> None:
    """Raise unless the belt stays on the pulleys at this speed."""
    limit = drive.belt.critical_speed
    if np.any(bad := ~(rim_speed < limit)):
        raise DriveError(
            f"belt speed {rim_speed[bad].flat[0]:g} m/s is not below the critical speed {limit:g}"
        )
    lift = drive.belt.mass_per_length * rim_speed**2
    if np.any(bad := ~(tension > lift)):
        raise DriveError(
            f"the belt lifts off: tension {tension[bad].flat[0]:g} N is not above "
            f"m v^2 = {lift[bad].flat[0]:g} N"
        )


def torque_capacity(drive: BeltDrive, tension: ArrayLike, driver_speed: ArrayLike = 0.0) -> _Floats:
    """Torque on the driven pulley at gross slip of the pulley that slips first.

    Parameters
    ----------
    drive : BeltDrive
    tension : array_like
        What the tensioning holds constant, mean or slack tension [N].
    driver_speed : array_like
        omega2 [rad/s].

    Returns
    -------
    ndarray
        [N m], positive.

    Raises
    ------
    DriveError
        If the belt lifts off or runs above its critical speed.
    """
    held, speed = _state_arrays(tension, driver_speed)
    rim_speed = np.abs(speed) * drive.driver.radius
    _check_belt(drive, held, rim_speed)
    c = drive_constants(drive)
    limits = (drive.driven.traction_limit, drive.driver.traction_limit)
    growth = np.expm1(min(*limits, 500.0))
    lift = drive.belt.mass_per_length * rim_speed**2
    share = 1.0 - lift / drive.belt.axial_stiffness
    return np.asarray(
        growth * (held - lift) / (share + c.slack_share * growth) * drive.driven.radius
    )


def margin(
    drive: BeltDrive, torque: ArrayLike, tension: ArrayLike, driver_speed: ArrayLike = 0.0
) -> _Floats:
    """Torque reserve 1 - |M| / M_max [-] under the tensioning at hand; negative beyond capacity.

    Parameters and errors as `torque_capacity`; `torque` [N m] acts on the driven pulley.
    """
    return np.asarray(1.0 - np.abs(torque) / torque_capacity(drive, tension, driver_speed))


def solve_equilibrium(
    drive: BeltDrive, torque: ArrayLike, tension: ArrayLike, driver_speed: ArrayLike
) -> Equilibrium:
    """Steady state at a transmitted torque. Arguments broadcast.

    Parameters
    ----------
    drive : BeltDrive
    torque : array_like
        Torque that the belt puts on the driven pulley [N m], in the joint's positive direction.
    tension : array_like
        What the tensioning holds constant, mean or slack tension [N].
    driver_speed : array_like
        omega2 [rad/s]; at standstill the limit of slow positive rotation.

    Returns
    -------
    Equilibrium

    Raises
    ------
    DriveError
        Beyond the capacity, or where the belt lifts off or runs above its critical speed.
    """
    moment, held, speed = _state_arrays(torque, tension, driver_speed)
    limit = torque_capacity(drive, held, speed)
    if np.any(bad := ~(np.abs(moment) < limit)):
        raise DriveError(
            f"torque {moment[bad].flat[0]:g} N m is not within the capacity of "
            f"{limit[bad].flat[0]:g} N m: gross slip"
        )
    c = drive_constants(drive)
    turning = np.where(speed < 0.0, -1.0, 1.0)
    force = moment / drive.driven.radius
    rows = _rows(turning * force, held, np.abs(speed) * drive.driver.radius)
    solved = _steady_states(
        c, rows, drive.driven.friction_coefficient, drive.driven.friction_stiffness
    )
    if np.any(bad := ~np.isfinite(solved[:, 0])):
        raise DriveError(
            f"torque {moment.ravel()[bad][0]:g} N m needs a slip beyond 100 %: no steady state"
        )
    slip, theta1, theta2, u1, u2, _ = (column.reshape(moment.shape) for column in solved.T)
    slack = held - c.slack_share * np.abs(force)
    return Equilibrium(
        slip=slip,
        driven_speed=speed * drive.driver.radius / drive.driven.radius * (1.0 - slip),
        tight_tension=slack + np.abs(force),
        slack_tension=slack,
        mean_tension=slack + 0.5 * np.abs(force),
        driven_transition_angle=theta1,
        driver_transition_angle=theta2,
        driven_inlet_gradient=u1,
        driver_inlet_gradient=u2,
        torque_capacity=limit,
        margin=1.0 - np.abs(moment) / limit,
    )


def torque_from_slip(
    drive: BeltDrive, slip: ArrayLike, tension: ArrayLike, driver_speed: ArrayLike
) -> _Floats:
    """Torque on the driven pulley [N m] at a slip; defined and monotone for every slip < inf.

    Parameters
    ----------
    drive : BeltDrive
    slip : array_like
        1 - (R1 omega1)/(R2 omega2) [-]; any finite number, gross slip included.
    tension, driver_speed : array_like
        As for `solve_equilibrium`.

    Raises
    ------
    DriveError
        Where the belt lifts off or runs above its critical speed, or for a value not finite.
    """
    ratio, held, speed = _state_arrays(slip, tension, driver_speed)
    rim_speed = np.abs(speed) * drive.driver.radius
    _check_belt(drive, held, rim_speed)
    force = _forces_at_slip(
        drive_constants(drive),
        _rows(ratio, held, rim_speed),
        drive.driven.friction_coefficient,
        drive.driven.friction_stiffness,
    ).reshape(ratio.shape)
    turning = np.where(speed < 0.0, -1.0, 1.0)
    return np.asarray(turning * force * drive.driven.radius)


def mean_from_held_tension(drive: BeltDrive, held: float, pull: float) -> float:
    """Mean tension [N] at a pull [N], from what the tensioning holds constant."""
    if drive.tensioning is Tensioning.CONSTANT_MEAN:
        return held
    return held + 0.5 * math.fabs(pull)
