"""Distributions along the arcs: friction, normal force, tension, displacement, power lost.

All angles count from the inlet, in the direction of belt travel. Friction is that on the belt in
the sense of Eq. 1: positive on a driven arc, where the pulley holds the belt back.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.arc import CheckedArcs, checked_arcs
from belt_ros.mechanics.arc_profile import point_state, scaled_arc
from belt_ros.mechanics.drive import BeltDrive, DriveError, Kinematics, Pulley
from belt_ros.mechanics.equilibrium import solve_equilibrium

_Floats = NDArray[np.float64]
_ROUNDING = 1e-13


class Distribution(NamedTuple):
    """What goes on along an arc, arrays of one shape."""

    angle: _Floats  # from the inlet [rad]
    tension: _Floats  # T [N]
    normal_force: _Floats  # n on the belt, per length [N/m]
    friction: _Floats  # f per length [N/m], Eq. 1
    displacement: _Floats  # u of the belt relative to the pulley [m]
    strain: _Floats  # u'(s), the incremental strain of Eq. 5 [-]
    sliding_speed: _Floats  # of the belt relative to the rim [m/s]
    power_loss: _Floats  # per length [W/m], what friction takes


class DriveDistribution(NamedTuple):
    """Distributions on both pulleys of a drive."""

    driven: Distribution
    driver: Distribution


@compiled
def _points(rows: _Floats) -> _Floats:
    """Rows (fields of `CheckedArcs`, angle) to rows of `PointState` and the inlet's gradient."""
    out = np.empty((rows.shape[0], 5))
    for i in range(rows.shape[0]):
        row = rows[i]
        role = 1 if row[0] > 0.0 else -1
        arc = scaled_arc(row[7], row[1], row[2], row[3], row[4], row[5], role)
        point = point_state(arc, min(row[8] * row[1] / arc.unit, arc.wrap))
        out[i, 0] = point.tension
        out[i, 1] = point.stretch
        out[i, 2] = point.displacement
        out[i, 3] = point.gradient
        out[i, 4] = arc.state.gradient
    return out


def _along(
    arcs: CheckedArcs,
    angle: _Floats,
    axial_stiffness: _Floats,
    inlet_tension: _Floats,
    inlet_speed: _Floats,
    speed_stiffness: _Floats,
) -> Distribution:
    """Distributions along arcs; a tension of `speed_stiffness` [N] doubles the belt's speed."""
    columns = np.broadcast_arrays(*arcs, angle)
    solved = _points(np.stack(columns, axis=-1).reshape(-1, len(columns)))
    shaped = (column.reshape(columns[0].shape) for column in solved.T)
    ratio, spring, moved, gradient, first = shaped
    role, radius, _, _, kf, net, effective, _, where = columns
    root = np.sqrt(kf / net)
    friction = role * root * effective * spring
    gained = axial_stiffness / net * effective * (ratio - 1.0)
    sliding = inlet_speed * (role * first * effective / net + gained / speed_stiffness)
    return Distribution(
        angle=where,
        tension=inlet_tension + gained,
        normal_force=effective * ratio / radius,
        friction=friction,
        displacement=role * moved * effective / (root * net),
        strain=role * gradient * effective / net,
        sliding_speed=sliding,
        power_loss=np.maximum(friction * sliding, 0.0),  # rounding, where nothing slides
    )


def arc_distribution(
    angle: ArrayLike,
    role: ArrayLike,
    radius: ArrayLike,
    wrap_angle: ArrayLike,
    friction_coefficient: ArrayLike,
    friction_stiffness: ArrayLike,
    axial_stiffness: ArrayLike,
    mass_per_length: ArrayLike,
    inlet_speed: ArrayLike,
    inlet_tension: ArrayLike,
    outlet_tension: ArrayLike,
) -> Distribution:
    """Distributions along arcs with given tensions at both ends, Eqs. 47-54.

    Parameters
    ----------
    angle : array_like
        Where, from the inlet [rad], between 0 and the wrap angle.
    role, radius, wrap_angle, friction_coefficient, friction_stiffness, axial_stiffness, \
mass_per_length, inlet_speed, inlet_tension, outlet_tension : array_like
        As for `solve_arc`; all arguments broadcast.

    Returns
    -------
    Distribution
        The sliding speed is exact in the strain: the belt's speed is proportional to 1 + T/EA.

    Raises
    ------
    DriveError
        As `solve_arc`, and for an angle outside the arc.
    """
    arcs = checked_arcs(
        role,
        radius,
        wrap_angle,
        friction_coefficient,
        friction_stiffness,
        axial_stiffness,
        mass_per_length,
        inlet_speed,
        inlet_tension,
        outlet_tension,
    )
    where = _checked_angle(angle, arcs.wrap_angle)
    ea = np.asarray(axial_stiffness, dtype=np.float64)
    tension = np.asarray(inlet_tension, dtype=np.float64)
    speed = np.asarray(inlet_speed, dtype=np.float64)
    return _along(arcs, where, ea, tension, speed, ea + tension)


def _checked_angle(angle: ArrayLike, wrap_angle: _Floats) -> _Floats:
    where = np.asarray(angle, dtype=np.float64)
    inside = (where >= 0.0) & (where <= wrap_angle * (1.0 + 1e-12))
    if not np.all(inside):
        at, wrap = (
            float(np.broadcast_to(x, inside.shape)[~inside][0]) for x in (where, wrap_angle)
        )
        raise DriveError(f"angle {at:g} rad is not on the arc, which ends at {wrap:g} rad")
    return where


def drive_distribution(
    drive: BeltDrive, torque: float, tension: float, driver_speed: float, points: int = 181
) -> DriveDistribution:
    """Distributions along both arcs of a drive in steady state.

    Parameters
    ----------
    drive : BeltDrive
    torque, tension, driver_speed : float
        As for `solve_equilibrium`.
    points : int
        Equally spaced points on each arc, inlet and outlet included.

    Returns
    -------
    DriveDistribution
        The integrals of both power losses add up to `Equilibrium.friction_loss`.

    Raises
    ------
    DriveError
        As `solve_equilibrium`.
    """
    state = solve_equilibrium(drive, torque, tension, driver_speed)
    rim = abs(driver_speed) * drive.driver.radius
    pull = abs(torque) / drive.driven.radius
    ends = float(state.slack_tension), float(state.tight_tension)
    forward = torque >= 0.0 if driver_speed >= 0.0 else torque <= 0.0
    driven_rim = rim * (1.0 - float(state.slip))
    gradients = float(state.driven_inlet_gradient), float(state.driver_inlet_gradient)
    return DriveDistribution(
        _on_pulley(
            drive, drive.driven, forward, pull, ends, rim, driven_rim / (1.0 - gradients[0]), points
        ),
        _on_pulley(
            drive, drive.driver, not forward, pull, ends, rim, rim / (1.0 - gradients[1]), points
        ),
    )


def _on_pulley(
    drive: BeltDrive,
    pulley: Pulley,
    receives: bool,
    pull: float,
    ends: tuple[float, float],
    rim_speed: float,
    inlet_speed: float,
    points: int,
) -> Distribution:
    """Return one pulley's part; `ends` are T_L and T_H, `rim_speed` is the driver's."""
    slack, tight = ends
    lift = drive.belt.mass_per_length * rim_speed**2
    ea = drive.belt.axial_stiffness
    limit = pulley.traction_limit * (1.0 - _ROUNDING)  # tensions are known to rounding only
    arc = CheckedArcs(
        *(
            np.asarray(value, dtype=np.float64)
            for value in (
                1.0 if receives else -1.0,
                pulley.radius,
                pulley.wrap_angle,
                pulley.friction_coefficient,
                pulley.friction_stiffness,
                ea - lift,
                slack - lift + (0.0 if receives else pull),
                min(np.log1p(pull / (slack - lift)), limit),
            )
        )
    )
    tension = slack if receives else tight
    base = ea + (tension if drive.kinematics is Kinematics.EXACT else tension - slack)
    angle = np.linspace(0.0, pulley.wrap_angle, points)
    inlet = (np.asarray(value) for value in (ea, tension, inlet_speed, base))
    return _along(arc, angle, *inlet)
