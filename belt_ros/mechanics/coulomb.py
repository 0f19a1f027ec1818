"""Classical creep theory: rigid adhesion, then sliding under Coulomb friction. The baseline.

On every pulley the belt first adheres, at constant tension and at the speed of the rim, and slides
over the last part of the arc, where the capstan law w' = +-(mu/R) w takes the effective tension
w = T - m v^2 to that of the next span (Johnson 1985, Contact Mechanics, section 8.3). With the
traction x = ln(w_H/w_L) either pulley slides over the angle x/mu, and slip is strain alone:

    slip = 1 - (1 + T_L/EA)/(1 + T_H/EA)

It is the limit kf -> infinity of EPP friction, with the same capacity. The interface is that of
`equilibrium`, friction stiffness being ignored.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.arc_profile import ScaledArc
from belt_ros.mechanics.arc_state import ArcState
from belt_ros.mechanics.checks import as_rows, check_belt, check_load, state_arrays
from belt_ros.mechanics.constants import DriveConstants, drive_constants, traction_limit
from belt_ros.mechanics.drive import BeltDrive
from belt_ros.mechanics.equilibrium import Equilibrium
from belt_ros.mechanics.tensioning import slack_at_traction

_Floats = NDArray[np.float64]

_LARGEST_EXPONENT = 500.0
_SOLVE_STEPS = 200


class _Loaded(NamedTuple):
    """State of the drive at a traction."""

    pull: float  # w_H - w_L [N]
    slip: float  # of the receiving pulley against the giving one [-]
    slack: float  # T_L [N]
    tight: float  # T_H [N]


@compiled
def _arc(traction: float, radius: float, wrap_angle: float, mu: float, role: int) -> ScaledArc:
    """Return an arc that adheres and slides; lengths in m."""
    wrap, growth = radius * wrap_angle, mu / radius
    begin = max(wrap - traction / growth, 0.0)
    state = ArcState(0.0, 0.0, begin, math.nan, traction, -1.0 / growth)
    return ScaledArc(role, growth, wrap, 1.0, begin, wrap, 0.0, state)


@compiled
def _slack(
    c: DriveConstants, traction: float, held: float, lift: float, mu: float, driven_receives: bool
) -> float:
    """Effective slack tension w_L [N] that the tensioning leaves at a traction."""
    role = 1 if driven_receives else -1
    driven = _arc(traction, c.driven_radius, c.driven_wrap, mu, role)
    driver = _arc(traction, c.driver_radius, c.driver_wrap, mu * c.friction_ratio, -role)
    receiving, giving = (driven, driver) if driven_receives else (driver, driven)
    return slack_at_traction(c, traction, held, lift, receiving, giving)[0]


@compiled
def _loaded(
    c: DriveConstants, traction: float, held: float, lift: float, mu: float, driven_receives: bool
) -> _Loaded:
    slack = _slack(c, traction, held, lift, mu, driven_receives)
    pull = slack * math.expm1(traction)
    rise = pull * c.axial_stiffness / (c.axial_stiffness - lift)
    base = c.axial_stiffness + (slack + lift if c.exact_strain else 0.0)
    return _Loaded(pull, rise / (base + rise), slack + lift, slack + lift + rise)


@compiled
def _traction(
    c: DriveConstants,
    goal: float,
    of_slip: bool,
    held: float,
    lift: float,
    mu: float,
    driven_receives: bool,
) -> float:
    """Traction at a pull [N] or a slip [-]; its limit at and beyond the capacity.

    Both rise with the traction: false position with Illinois weights, and every third step halves.
    """
    low, high = 0.0, min(traction_limit(c, mu), _LARGEST_EXPONENT)
    most = _loaded(c, high, held, lift, mu, driven_receives)
    at_low, at_high = -goal, (most.slip if of_slip else most.pull) - goal
    if not (at_low < 0.0 < at_high):
        return high if at_low < 0.0 else low
    x, side = high, 0
    for step in range(_SOLVE_STEPS):
        before = x
        x = (low * at_high - high * at_low) / (at_high - at_low)
        if step % 3 == 2 or not (low < x < high):
            x = 0.5 * (low + high)
        state = _loaded(c, x, held, lift, mu, driven_receives)
        error = (state.slip if of_slip else state.pull) - goal
        if error > 0.0:
            high, at_high = x, error
            at_low *= 0.5 if side > 0 else 1.0
            side = 1
        else:
            low, at_low = x, error
            at_high *= 0.5 if side < 0 else 1.0
            side = -1
        if error == 0.0 or high - low <= 4e-16 * high or abs(x - before) <= 2e-16 * x:
            break
    return x


@compiled
def _steady_states(c: DriveConstants, rows: _Floats, mu: float) -> _Floats:
    """Rows (pull along the rotation, held tension, speed) to (traction, slip, T_L, T_H, limit)."""
    out = np.empty((rows.shape[0], 5))
    for i in range(rows.shape[0]):
        pull, held, speed = rows[i, 0], rows[i, 1], rows[i, 2]
        lift, forward = c.mass_per_length * speed * speed, pull >= 0.0
        x = _traction(c, abs(pull), False, held, lift, mu, forward)
        state = _loaded(c, x, held, lift, mu, forward)
        largest = min(traction_limit(c, mu), _LARGEST_EXPONENT)
        out[i, 0] = x
        out[i, 1] = state.slip if forward else state.slip / (state.slip - 1.0)
        out[i, 2] = state.slack
        out[i, 3] = state.tight
        out[i, 4] = _loaded(c, largest, held, lift, mu, forward).pull
    return out


@compiled
def _pulls_at_slip(c: DriveConstants, rows: _Floats, mu: float) -> _Floats:
    """Rows (slip, held tension, speed) to effective pulls."""
    out = np.empty(rows.shape[0])
    for i in range(rows.shape[0]):
        slip, held, speed = rows[i, 0], rows[i, 1], rows[i, 2]
        lift, forward = c.mass_per_length * speed * speed, slip >= 0.0
        received = slip if forward else slip / (slip - 1.0)
        x = _traction(c, received, True, held, lift, mu, forward)
        pull = _loaded(c, x, held, lift, mu, forward).pull
        out[i] = pull if forward else -pull
    return out


def solve_coulomb(
    drive: BeltDrive, torque: ArrayLike, tension: ArrayLike, driver_speed: ArrayLike
) -> Equilibrium:
    """Steady state at a transmitted torque in classical creep theory. Arguments broadcast.

    Parameters
    ----------
    drive : BeltDrive
        Friction stiffness is ignored.
    torque, tension, driver_speed : array_like
        As for `solve_equilibrium`.

    Returns
    -------
    Equilibrium
        The transition angle is where adhesion ends; inlet gradients are zero, re-stick angles NaN.

    Raises
    ------
    DriveError
        Beyond the capacity, or where the belt lifts off or runs above its critical speed.
    """
    moment, held, speed = state_arrays(torque, tension, driver_speed)
    rim_speed = np.abs(speed) * drive.driver.radius
    check_belt(drive, held, rim_speed)
    along = np.where(speed < 0.0, -1.0, 1.0) * moment / drive.driven.radius
    solved = _steady_states(
        drive_constants(drive), as_rows(along, held, rim_speed), drive.driven.friction_coefficient
    )
    columns = (column.reshape(moment.shape) for column in solved.T)
    traction, slip, slack, tight, pull_limit = columns
    limit = pull_limit * drive.driven.radius
    check_load(moment, limit, slip)
    driven, driver = drive.driven, drive.driver
    return Equilibrium(
        slip=slip,
        driven_speed=speed * driver.radius / driven.radius * (1.0 - slip),
        tight_tension=tight,
        slack_tension=slack,
        mean_tension=0.5 * (slack + tight),
        driven_transition_angle=driven.wrap_angle - traction / driven.friction_coefficient,
        driver_transition_angle=driver.wrap_angle - traction / driver.friction_coefficient,
        driven_restick_angle=np.full(moment.shape, np.nan),
        driver_restick_angle=np.full(moment.shape, np.nan),
        driven_inlet_gradient=np.zeros(moment.shape),
        driver_inlet_gradient=np.zeros(moment.shape),
        friction_loss=along * slip * rim_speed,
        torque_capacity=limit,
        margin=1.0 - np.abs(moment) / limit,
    )


def coulomb_torque_from_slip(
    drive: BeltDrive, slip: ArrayLike, tension: ArrayLike, driver_speed: ArrayLike
) -> _Floats:
    """Torque on the driven pulley [N m] at a slip: in proportion to creep, then the capacity.

    Its inverse is `solve_coulomb` up to the capacity. There it has many values: the whole belt
    slides, and every slip beyond that of the strain goes with the one torque.

    Parameters
    ----------
    drive : BeltDrive
        Friction stiffness is ignored.
    slip : array_like
        1 - (R1 omega1)/(R2 omega2) [-]; any finite number.
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
    rows = as_rows(ratio, held, rim_speed)
    pull = _pulls_at_slip(drive_constants(drive), rows, drive.driven.friction_coefficient)
    turning = np.where(speed < 0.0, -1.0, 1.0)
    return np.asarray(turning * pull.reshape(ratio.shape) * drive.driven.radius)
