"""The paper's example drive between given tensions, with and without the belt's inertia.

The paper feeds the closed form with tensions, not with a torque, so the arcs are solved one by one.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from belt_ros.figures import paper
from belt_ros.mechanics import (
    ArcSolution,
    Belt,
    BeltDrive,
    Distribution,
    Kinematics,
    Pulley,
    Role,
    Tensioning,
    arc_distribution,
    slip_onset_stiffness,
    solve_arc,
)
from belt_ros.mechanics.slip_onset import elastic_traction

_Floats = NDArray[np.float64]
_Arguments = tuple[ArrayLike, ...]

INSTALLED_TENSION = 422.7  # [N]; T_H + T_L is 868 N at 45 N m then, as in Table 2


def drive(friction_stiffness: float) -> BeltDrive:
    """Return the drive of Tables 1 and 2 on fixed centres, with inertia."""
    pulley = Pulley(
        paper.RADIUS, paper.WRAP_ANGLE, paper.FRICTION_COEFFICIENT, friction_stiffness, inertia=0.01
    )
    return BeltDrive(
        Belt(paper.AXIAL_STIFFNESS, paper.MASS_PER_LENGTH),
        driven=pulley,
        driver=pulley,
        span_length=paper.SPAN_LENGTH,
        tensioning=Tensioning.FIXED_CENTRES,
    )


def _belt(mass: ArrayLike) -> _Arguments:
    return paper.AXIAL_STIFFNESS, mass, paper.BELT_SPEED


def _ends(role: Role, slack: ArrayLike, tight: ArrayLike) -> _Arguments:
    return (slack, tight) if role is Role.DRIVEN else (tight, slack)


def _arc(
    role: Role, friction_stiffness: ArrayLike, slack: ArrayLike, tight: ArrayLike, mass: ArrayLike
) -> _Arguments:
    pulley = (paper.RADIUS, paper.WRAP_ANGLE, paper.FRICTION_COEFFICIENT, friction_stiffness)
    return (role, *pulley, *_belt(mass), *_ends(role, slack, tight))


def solve(
    role: Role, friction_stiffness: ArrayLike, slack: ArrayLike, tight: ArrayLike, mass: ArrayLike
) -> ArcSolution:
    """Solve one arc of the drive; arguments broadcast.

    Parameters
    ----------
    role : Role
    friction_stiffness : array_like
        kf [N/m2].
    slack, tight : array_like
        T_L, T_H [N].
    mass : array_like
        m [kg/m]; 0 leaves inertia out.
    """
    return solve_arc(*_arc(role, friction_stiffness, slack, tight, mass))


def along(
    angle: ArrayLike,
    role: Role,
    friction_stiffness: ArrayLike,
    slack: ArrayLike,
    tight: ArrayLike,
    mass: ArrayLike,
) -> Distribution:
    """Distributions at angles [rad] from the inlet; other parameters as for `solve`."""
    return arc_distribution(angle, *_arc(role, friction_stiffness, slack, tight, mass))


def least_sliding_stiffness(slack: float, tight: float, mass: float) -> float:
    """Return kf_min [N/m2] of the driven arc, Eqs. 57-60."""
    arc = _arc(Role.DRIVEN, 1.0, slack, tight, mass)
    return float(slip_onset_stiffness(*arc[:4], *arc[5:]))


def driven_speed(
    friction_stiffness: float,
    slack: float,
    tight: float,
    mass: float,
    kinematics: Kinematics = Kinematics.EXACT,
) -> float:
    """Return omega1 [rad/s] of equilibrium at given tensions."""
    ends = friction_stiffness, slack, tight, mass
    driven = float(solve(Role.DRIVEN, *ends).inlet_strain_gradient)
    driver = float(solve(Role.DRIVER, *ends).inlet_strain_gradient)
    stretch = (tight - slack) / paper.AXIAL_STIFFNESS
    if kinematics is Kinematics.EXACT:
        stretch /= 1.0 + slack / paper.AXIAL_STIFFNESS
    return paper.DRIVER_SPEED * (1.0 - driven) / (1.0 - driver) / (1.0 + stretch)


def initial_tension(
    friction_stiffness: ArrayLike, slack: ArrayLike, tight: ArrayLike, mass: ArrayLike
) -> _Floats:
    """Return T_o [N] of the driven arc, Eq. 6."""
    gradient = solve(Role.DRIVEN, friction_stiffness, slack, tight, mass).inlet_strain_gradient
    return np.asarray(np.asarray(slack) - paper.AXIAL_STIFFNESS * gradient)


def tight_tension_at_full_slip(mass: float) -> float:
    """Return T_H [N] at T_L of section 5 from which the belt slides all along either arc."""
    return tight_tension_at(paper.FRICTION_COEFFICIENT * paper.WRAP_ANGLE, mass)


def tight_tension_at(traction: float, mass: float) -> float:
    """Return T_H [N] that goes with T_L of section 5 at a traction ln(w_H/w_L) [-]."""
    lift = mass * paper.BELT_SPEED**2
    pull = (paper.SLACK_TENSION - lift) * math.expm1(traction)
    return paper.SLACK_TENSION + pull * paper.AXIAL_STIFFNESS / (paper.AXIAL_STIFFNESS - lift)


def tight_tension_at_onset(role: Role, mass: float) -> float:
    """Return T_H [N] at T_L of section 5 up to which an arc creeps elastically everywhere.

    For kf of Table 1.
    """
    net = paper.AXIAL_STIFFNESS - mass * paper.BELT_SPEED**2
    per_radian = paper.RADIUS * math.sqrt(paper.FRICTION_STIFFNESS / net)
    growth = paper.FRICTION_COEFFICIENT / per_radian
    return tight_tension_at(elastic_traction(growth, per_radian * paper.WRAP_ANGLE, role), mass)
