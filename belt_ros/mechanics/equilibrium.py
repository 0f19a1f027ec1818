"""The two-pulley drive in steady state: torque to slip, slip to torque, capacity and margin."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.checks import as_rows, check_belt, check_load, state_arrays
from belt_ros.mechanics.constants import DriveConstants, drive_constants
from belt_ros.mechanics.creep import creep, pull_at_creep, pull_capacity
from belt_ros.mechanics.drive import BeltDrive

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
    driven_restick_angle: _Floats  # [rad], NaN where the belt does not re-stick
    driver_restick_angle: _Floats  # [rad]
    driven_inlet_gradient: _Floats  # u1'(0) [-]
    driver_inlet_gradient: _Floats  # u2'(0) [-]
    friction_loss: _Floats  # [W], power in less power out
    torque_capacity: _Floats  # [N m] on the driven pulley
    margin: _Floats  # [-]


@compiled
def _steady_states(c: DriveConstants, rows: _Floats, mu: float, kf: float) -> _Floats:
    """Rows (pull along the rotation, tension, speed) to rows of `solve_equilibrium`'s unknowns."""
    out = np.empty((rows.shape[0], 10))
    for i in range(rows.shape[0]):
        pull, tension, speed = rows[i, 0], rows[i, 1], rows[i, 2]
        forward = pull >= 0.0
        state = creep(c, abs(pull), tension, mu, kf, speed, forward)
        driven, driver = (0, 1) if forward else (1, 0)
        out[i, driven] = state.receiving_transition
        out[i, driver] = state.giving_transition
        out[i, 2 + driven] = state.receiving_restick
        out[i, 2 + driver] = np.nan
        out[i, 4 + driven] = state.receiving_gradient
        out[i, 4 + driver] = state.giving_gradient
        out[i, 6] = state.slack
        out[i, 7] = state.tight
        out[i, 8] = pull_capacity(c, tension, mu, kf, speed, forward)
        if forward:
            out[i, 9] = state.slip
        else:
            out[i, 9] = state.slip / (state.slip - 1.0) if state.slip < 1.0 else -np.inf
    return out


@compiled
def _capacities(c: DriveConstants, rows: _Floats, mu: float, kf: float) -> _Floats:
    """Rows (pull along the rotation, tension, speed) to effective pulls at gross slip."""
    out = np.empty(rows.shape[0])
    for i in range(rows.shape[0]):
        out[i] = pull_capacity(c, rows[i, 1], mu, kf, rows[i, 2], rows[i, 0] >= 0.0)
    return out


@compiled
def _pulls_at_slip(c: DriveConstants, rows: _Floats, mu: float, kf: float) -> _Floats:
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


def _solved(
    drive: BeltDrive,
    kernel: Callable[[DriveConstants, _Floats, float, float], _Floats],
    *columns: _Floats,
) -> _Floats:
    """Run a kernel over rows of states with the driven pulley's friction."""
    friction = drive.driven.friction_coefficient, drive.driven.friction_stiffness
    return kernel(drive_constants(drive), as_rows(*columns), *friction)


def torque_capacity(
    drive: BeltDrive,
    tension: ArrayLike,
    driver_speed: ArrayLike = 0.0,
    regenerating: ArrayLike = False,
) -> _Floats:
    """Torque on the driven pulley at gross slip of the pulley that slips first.

    Parameters
    ----------
    drive : BeltDrive
    tension : array_like
        What the tensioning holds [N], see `Tensioning`.
    driver_speed : array_like
        omega2 [rad/s].
    regenerating : array_like of bool
        Whether the load drives. It matters between fixed centres, to pulleys that are not alike:
        the one that does not slip takes up belt according to its role.

    Returns
    -------
    ndarray
        [N m], positive.

    Raises
    ------
    DriveError
        If the belt lifts off or runs above its critical speed.
    """
    held, speed, sign = state_arrays(tension, driver_speed, np.where(regenerating, -1.0, 1.0))
    rim_speed = np.abs(speed) * drive.driver.radius
    check_belt(drive, held, rim_speed)
    pull = _solved(drive, _capacities, sign, held, rim_speed)
    return np.asarray(pull.reshape(held.shape) * drive.driven.radius)


def margin(
    drive: BeltDrive, torque: ArrayLike, tension: ArrayLike, driver_speed: ArrayLike = 0.0
) -> _Floats:
    """Torque reserve 1 - |M| / M_max [-] under the tensioning at hand; negative beyond capacity.

    It counts torque up to gross slip, also where slip has become useless before. Parameters and
    errors as `torque_capacity`; `torque` [N m] acts on the driven pulley.
    """
    (moment,) = state_arrays(torque)
    regenerating = moment * np.where(np.less(driver_speed, 0.0), -1.0, 1.0) < 0.0
    limit = torque_capacity(drive, tension, driver_speed, regenerating)
    return np.asarray(1.0 - np.abs(moment) / limit)


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
        What the tensioning holds [N], see `Tensioning`.
    driver_speed : array_like
        omega2 [rad/s]; at standstill the limit of slow positive rotation.

    Returns
    -------
    Equilibrium

    Raises
    ------
    DriveError
        Beyond the capacity, where the belt lifts off or runs above its critical speed, or where a
        load that drives would have to push the belt back (u'(0) > 1: near the capacity of a very
        compliant contact). Where the driver drives, slip above 1 then means a driven pulley that
        turns backwards.
    """
    moment, held, speed = state_arrays(torque, tension, driver_speed)
    rim_speed = np.abs(speed) * drive.driver.radius
    check_belt(drive, held, rim_speed)
    along = np.where(speed < 0.0, -1.0, 1.0) * moment / drive.driven.radius
    solved = _solved(drive, _steady_states, along, held, rim_speed)
    columns = (column.reshape(moment.shape) for column in solved.T)
    theta1, theta2, restick1, restick2, u1, u2, slack, tight, pull_limit, slip = columns
    limit = pull_limit * drive.driven.radius
    check_load(moment, limit, slip)
    return Equilibrium(
        slip=slip,
        driven_speed=speed * drive.driver.radius / drive.driven.radius * (1.0 - slip),
        tight_tension=tight,
        slack_tension=slack,
        mean_tension=0.5 * (slack + tight),
        driven_transition_angle=theta1,
        driver_transition_angle=theta2,
        driven_restick_angle=restick1,
        driver_restick_angle=restick2,
        driven_inlet_gradient=u1,
        driver_inlet_gradient=u2,
        friction_loss=along * slip * rim_speed,
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
    ratio, held, speed = state_arrays(slip, tension, driver_speed)
    rim_speed = np.abs(speed) * drive.driver.radius
    check_belt(drive, held, rim_speed)
    pull = _solved(drive, _pulls_at_slip, ratio, held, rim_speed).reshape(ratio.shape)
    turning = np.where(speed < 0.0, -1.0, 1.0)
    return np.asarray(turning * pull * drive.driven.radius)
