"""A drive, what acts on it and runs of its motion, shared by the tests of motion."""

import math

from belt_ros.mechanics import Belt, BeltDrive, Pulley
from belt_ros.mechanics.constants import DriveConstants
from belt_ros.mechanics.motion import Condition, Motion, step_motion

TENSION = 435.0


def make_drive(mass: float = 0.1036, stiffness: float = 8.1e7) -> BeltDrive:
    driven = Pulley(0.08125, math.pi, 1.2, stiffness, inertia=0.05)
    driver = Pulley(0.06, 2.8, 1.25, 1.5 * stiffness, inertia=0.02)
    return BeltDrive(Belt(80068.0, mass), driven, driver, span_length=0.51)


def make_condition(
    drive: BeltDrive, driver_torque: float, driven_torque: float, **changed: float
) -> Condition:
    given_condition = Condition(
        driver_torque=driver_torque,
        driven_torque=driven_torque,
        tension=TENSION,
        friction=drive.driven.friction_coefficient,
        stiffness=drive.driven.friction_stiffness,
        ratio_bias=0.0,
        creep_error=0.0,
    )
    return given_condition._replace(**changed)


def balanced(drive: BeltDrive, torque: float) -> Condition:
    """Outside torques that a steady pull of torque/R1 balances."""
    return make_condition(drive, torque * drive.driver.radius / drive.driven.radius, -torque)


def run(c: DriveConstants, state: Motion, condition: Condition, dt: float, steps: int) -> Motion:
    for _ in range(steps):
        state = step_motion(c, state, condition, dt)
    return state


def slip_of(drive: BeltDrive, state: Motion) -> float:
    rims = drive.driven.radius * state.driven_speed, drive.driver.radius * state.driver_speed
    return 1.0 - rims[0] / rims[1]
