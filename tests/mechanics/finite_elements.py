"""A drive of finite elements, its runs and EPP equilibrium beside it, shared by their tests."""

import math
from typing import Any

import numpy as np

from belt_ros.mechanics import Belt, BeltDrive, Pulley, Role, solve_arc
from belt_ros.mechanics.finite_element import FiniteElementRun, History
from belt_ros.mechanics.finite_element_mesh import Discretisation, open_belt

RADIUS = 0.08125
SPEED = 120.0
TORQUE = 45.0
INSTALLED = 422.5
COARSE = Discretisation(elements_per_half_pulley=30)


def make_drive(stiffness: float = 2e8, r1: float = RADIUS, r2: float = RADIUS) -> BeltDrive:
    """Table 1, spans 2 pi R; other radii on the same centres."""
    wrap1, wrap2, span = open_belt(r1, r2, 2.0 * math.pi * RADIUS)
    return BeltDrive(
        Belt(80068.0, 0.1036),
        Pulley(r1, wrap1, 1.2, stiffness, inertia=0.01),
        Pulley(r2, wrap2, 1.2, stiffness, inertia=0.01),
        span_length=span,
    )


def ramp(duration: float, torque: float, speed: float = SPEED, rise: float = 0.25) -> History:
    """Driver and load from rest, without kinks that would ring."""
    q = np.linspace(0.0, 1.0, 41)
    smooth = np.append(q * q * (3.0 - 2.0 * q), 1.0)
    return History(np.append(rise * q, duration), speed * smooth, torque * smooth)


def tail(values: np.ndarray, share: float = 0.15) -> float:
    return float(np.mean(values[-max(int(share * values.size), 1) :]))


def tensions(run: FiniteElementRun) -> tuple[float, float]:
    """Tight and slack [N] at the end."""
    ends = tail(run.to_driver_tension), tail(run.to_driven_tension)
    return max(ends), min(ends)


def equilibrium_arc(
    drive: BeltDrive, role: Role, pulley: Pulley, inlet: float, outlet: float
) -> Any:
    return solve_arc(
        role,
        pulley.radius,
        pulley.wrap_angle,
        pulley.friction_coefficient,
        pulley.friction_stiffness,
        drive.belt.axial_stiffness,
        drive.belt.mass_per_length,
        SPEED * drive.driver.radius,
        inlet,
        outlet,
    )


def equilibrium_speed(drive: BeltDrive, tight: float, slack: float) -> float:
    """omega1 of EPP equilibrium at these tensions, the driver giving the power."""
    u1 = equilibrium_arc(drive, Role.DRIVEN, drive.driven, slack, tight).inlet_strain_gradient
    u2 = equilibrium_arc(drive, Role.DRIVER, drive.driver, tight, slack).inlet_strain_gradient
    ea = drive.belt.axial_stiffness
    ratio = float((1.0 - u1) / (1.0 - u2)) * (1.0 + slack / ea) / (1.0 + tight / ea)
    return ratio * SPEED * drive.driver.radius / drive.driven.radius
