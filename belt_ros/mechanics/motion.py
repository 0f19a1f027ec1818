"""The drive in motion: two inertias, elastic spans, and creep that relaxes the spans' wind-up.

With the rim speeds v1 = R1 omega1 and v2 = R2 omega2, the effective pull F = w_H - w_L (positive
when it turns the driven pulley forward) and the torques tau from outside,

    J1 omega1' = tau1 + R1 F
    J2 omega2' = tau2 - R2 F
    (L / 2 EA) F' = v2 - v1 - v_max creep(F),      v_max = max(|v1|, |v2|)

The last line is the mass balance of the two free spans: what the driver takes in and the driven
pulley does not give out winds the tight span up, and creep unwinds it. It contains the equilibrium
(F' = 0), gross slip (creep is unbounded at the capacity, so F saturates there while the pulleys
part company), standstill (no creep) and reversal of torque and of rotation, in one smooth law. Belt
inertia is taken at the driver's rim speed.
"""

import math
from typing import NamedTuple

from belt_ros.mechanics._compile import compiled, inlined
from belt_ros.mechanics.between import pull_between
from belt_ros.mechanics.constants import DriveConstants
from belt_ros.mechanics.creep import Creep, balance, creep_of, pull_capacity
from belt_ros.mechanics.loaded_belt import (
    UNKNOWN,
    Loaded,
    MountedBelt,
    Near,
    belt_on_pulleys,
    capacity_of,
    loaded_near_pull,
)

_BELOW_CAPACITY = 1.0 - 1e-9
_LARGEST_CREEP_LOAD = 0.98


class Motion(NamedTuple):
    """Speeds of both pulleys and the effective pull."""

    driver_speed: float  # omega2 [rad/s]
    driven_speed: float  # omega1 [rad/s]
    pull: float  # F [N], signed


class Condition(NamedTuple):
    """What a step takes as constant: the belt's condition and the torques from outside."""

    driver_torque: float  # [N m]
    driven_torque: float  # [N m]
    tension: float  # held by the tensioning [N]
    friction: float  # mu of the driven pulley [-]
    stiffness: float  # kf of the driven pulley [N/m2]
    ratio_bias: float  # relative error of R1/R2 [-]
    creep_error: float  # relative error of the predicted creep [-]
    undeveloped: float = (
        0.0  # slip beside that of equilibrium, while creep develops on the arcs [-]
    )


@compiled
def rim_speed(c: DriveConstants, state: Motion, condition: Condition) -> tuple[float, float]:
    """Rim speeds (driver, driven) [m/s]."""
    driven_radius = c.driven_radius * (1.0 + condition.ratio_bias)
    return c.driver_radius * state.driver_speed, driven_radius * state.driven_speed


@compiled
def condition_capacity(
    c: DriveConstants, condition: Condition, speed: float, driven_receives: bool
) -> float:
    """Effective pull [N] at gross slip under a condition, at a belt speed [m/s]."""
    return pull_capacity(
        c, condition.tension, condition.friction, condition.stiffness, speed, driven_receives
    )


@compiled
def _turning(v2: float, v1: float) -> float:
    """Return +1.0 or -1.0: the sense in which the faster rim turns."""
    return 1.0 if (v2 if abs(v2) >= abs(v1) else v1) >= 0.0 else -1.0


@compiled
def pull_along(c: DriveConstants, state: Motion, condition: Condition) -> float:
    """Pull [N], positive where the power flows from driver to driven pulley."""
    v2, v1 = rim_speed(c, state, condition)
    return _turning(v2, v1) * state.pull


@inlined
def belt_in(
    c: DriveConstants, condition: Condition, belt_speed: float, driven_receives: bool
) -> MountedBelt:
    """Return the belt under a condition, its inertia at `belt_speed` [m/s]."""
    return belt_on_pulleys(
        c,
        condition.tension,
        condition.friction,
        condition.stiffness,
        belt_speed,
        driven_receives,
    )


@compiled
def steady_creep(
    c: DriveConstants, belt: MountedBelt, pull: float, capacity: float, near: Near
) -> tuple[Creep, Near]:
    """Creep that belongs to a pull >= 0 [N], and what is near it.

    Above 98 % of the capacity [N] it is that of 98 %: sliding beyond that is failure, not creep.
    """
    return creep_of(c, belt, min(pull, _LARGEST_CREEP_LOAD * capacity), near)


@compiled
def slip_of_creep(steady: Creep, driven_receives: bool, creep_error: float) -> float:
    """Slip 1 - v1/v2 [-] that a creep, wrong by `creep_error`, amounts to."""
    slip = min(steady.slip * (1.0 + creep_error), 0.9)
    return slip if driven_receives else slip / (slip - 1.0)


@compiled
def predicted_slip(c: DriveConstants, state: Motion, condition: Condition) -> float:
    """Steady slip 1 - v1/v2 [-] that belongs to the present pull, see `steady_creep`."""
    along = pull_along(c, state, condition)
    belt = belt_in(c, condition, abs(c.driver_radius * state.driver_speed), along >= 0.0)
    steady, _ = steady_creep(c, belt, abs(along), capacity_of(c, belt, UNKNOWN), UNKNOWN)
    return slip_of_creep(steady, along >= 0.0, condition.creep_error)


class StepLaw(NamedTuple):
    """What all steps of one length have in common: what they make of speeds and torques."""

    winding: float  # pull by a difference of rim speeds [N s/m]
    driver_gain: float  # speed of the driver by a torque on it [rad/s / (N m)]
    driven_gain: float
    driver_drive: float  # rim speed of both by a torque on the driver, belt and all [m/s / (N m)]
    driven_drive: float
    stiff: float  # [-], see `Step`


class Step(NamedTuple):
    """One implicit step, as the equation stiff * pull + relaxation * creep(pull) = along."""

    turning: float  # sense of rotation, +1.0 or -1.0
    along: float  # [N]; its sign is that of the power's flow
    stiff: float  # [-]
    relaxation: float  # [N]


@compiled
def step_law(c: DriveConstants, dt: float) -> StepLaw:
    """Return what all steps of `dt` [s] have in common."""
    winding = dt / c.span_compliance
    driver_gain, driven_gain = dt / c.driver_inertia, dt / c.driven_inertia
    mass = c.driver_inertia / c.driver_radius**2 + c.driven_inertia / c.driven_radius**2
    apart = c.driver_radius**2 * driver_gain + c.driven_radius**2 * driven_gain
    return StepLaw(
        winding,
        driver_gain,
        driven_gain,
        dt / (mass * c.driver_radius),
        dt / (mass * c.driven_radius),
        1.0 + winding * apart,
    )


@inlined
def step_equation(c: DriveConstants, law: StepLaw, state: Motion, condition: Condition) -> Step:
    """Return the equation of a step."""
    v2, v1 = rim_speed(c, state, condition)
    fastest = max(abs(v1), abs(v2))
    turning = _turning(v2, v1)
    unloaded = state.pull + law.winding * (
        v2
        - v1
        - fastest * condition.undeveloped
        + c.driver_radius * law.driver_gain * condition.driver_torque
        - c.driven_radius * law.driven_gain * condition.driven_torque
    )
    # What both pulleys gain together, which no pull between them changes.
    gained = law.driver_drive * condition.driver_torque
    gained += law.driven_drive * condition.driven_torque
    then = max(fastest + turning * gained, 0.0)
    relaxation = law.winding * then * max(1.0 + condition.creep_error, 0.0)
    return Step(turning, turning * unloaded, law.stiff, relaxation)


@inlined
def stepped_pull(
    c: DriveConstants, belt: MountedBelt, step: Step, start: Loaded, beside: Loaded
) -> tuple[float, Loaded]:
    """Size [N] of the pull after a step, and the last state evaluated, from a state near by.

    `beside` is another state of the same belt, or again `start`, where none is known.
    """
    along = abs(step.along)
    if not (belt.grips and along > 0.0):
        return 0.0, start
    if step.relaxation <= 1e-12:
        return min(along / step.stiff, _BELOW_CAPACITY * capacity_of(c, belt, start.near)), start
    weight, load = step.stiff / step.relaxation, along / step.relaxation
    pull = pull_between(c, belt, weight, load, start, beside)
    if not math.isnan(pull):
        return pull, start
    return balance(c, belt, weight, load, start)


@inlined
def stepped_motion(
    c: DriveConstants, law: StepLaw, state: Motion, condition: Condition, step: Step, pull: float
) -> Motion:
    """Motion after a step that leads to a pull of size `pull` [N]."""
    signed = step.turning * (pull if step.along >= 0.0 else -pull)
    return Motion(
        state.driver_speed + law.driver_gain * (condition.driver_torque - c.driver_radius * signed),
        state.driven_speed + law.driven_gain * (condition.driven_torque + c.driven_radius * signed),
        signed,
    )


@compiled
def step_motion(c: DriveConstants, state: Motion, condition: Condition, dt: float) -> Motion:
    """Advance by `dt` [s] with one implicit (backward Euler) step, stable for any `dt`.

    A step longer than the torsional period does not resolve that oscillation but damps it; what
    remains is the quasi-steady motion. The creep term takes the speed that the drive has at the
    step's end, as far as the torques from outside tell it.
    """
    return step_at_speed(c, state, condition, abs(c.driver_radius * state.driver_speed), dt)


@compiled
def step_at_speed(
    c: DriveConstants, state: Motion, condition: Condition, belt_speed: float, dt: float
) -> Motion:
    """As `step_motion`, with the belt's inertia at `belt_speed` [m/s]."""
    law = step_law(c, dt)
    step = step_equation(c, law, state, condition)
    belt = belt_in(c, condition, belt_speed, step.along >= 0.0)
    start = loaded_near_pull(c, belt, abs(state.pull), UNKNOWN)
    pull, _ = stepped_pull(c, belt, step, start, start)
    return stepped_motion(c, law, state, condition, step, pull)
