"""The estimator's state vector, its law of motion and what can be read off it, compiled.

Twelve numbers: what moves (speeds, pull, torques from outside), what the belt is (logarithms of
tension, kf and mu, which are positive and may be uncertain by decades), how far the model may be
trusted (radius-ratio bias, relative error of the predicted creep, and slip beside it while creep
develops on the arcs after a change of load), and the rim travel that one pulley is ahead of the
other, which is what position sensors see.

The transmitted pull is a state of its own, so torque is linear in it, and all sensors read states
directly. What the belt is shows only through the creep that unwinds the spans.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants
from belt_ros.mechanics.creep import Creep, tensions_at_pull
from belt_ros.mechanics.loaded_belt import (
    UNKNOWN,
    MountedBelt,
    Near,
    capacity_of,
    loaded_near_pull,
    near_on,
)
from belt_ros.mechanics.motion import (
    Condition,
    Motion,
    belt_in,
    predicted_slip,
    pull_along,
    rim_speed,
    slip_of_creep,
    steady_creep,
    step_equation,
    step_law,
    stepped_motion,
    stepped_pull,
)

_Floats = NDArray[np.float64]


class Index(IntEnum):
    """Places in the state vector."""

    DRIVER_SPEED = 0  # omega2 [rad/s]
    DRIVEN_SPEED = 1  # omega1 [rad/s]
    PULL = 2  # F [N]
    DRIVER_TORQUE = 3  # tau2 [N m]
    DRIVEN_TORQUE = 4  # tau1 [N m]
    LOG_TENSION = 5  # ln of the held tension [N]
    LOG_STIFFNESS = 6  # ln kf [N/m2]
    LOG_FRICTION = 7  # ln mu
    RATIO_BIAS = 8  # [-]
    CREEP_ERROR = 9  # [-]
    UNDEVELOPED = 10  # [-]
    TRAVEL = 11  # R2 theta2 - R1 theta1 since positions were first read, radii as told [m]


class Reading(IntEnum):
    """Places in a row of what is read off a state."""

    TRANSMITTED_TORQUE = 0  # [N m]
    SLIP = 1
    PREDICTED_CREEP = 2
    EXCESS_SLIP = 3
    TIGHT_TENSION = 4  # [N]
    SLACK_TENSION = 5  # [N]
    MEAN_TENSION = 6  # [N]
    DRIVEN_TRANSITION = 7  # [rad]
    DRIVER_TRANSITION = 8  # [rad]
    MARGIN = 9
    SLIP_SPEED = 10  # v2 - v1 [m/s]
    CAPACITY = 11  # torque at gross slip on the driven pulley [N m]


STATES = len(Index)
READINGS = len(Reading)
# What `propagate` changes.
MOVING = np.array([Index.DRIVER_SPEED, Index.DRIVEN_SPEED, Index.PULL, Index.TRAVEL])
# Beyond these, which no drive comes near, the mechanics has no digits left.
_TENSIONS, _STIFFNESSES, _FRICTIONS = (-14.0, 28.0), (-2.0, 39.0), (-14.0, 3.4)  # logarithms
_ROUNDING = 1.0 + 1e-6
_TELLING_PULL = 0.05  # over the tension; at less, creep is too small to be told per pull


@compiled
def _bounded_exp(value: float, limits: tuple[float, float]) -> float:
    return math.exp(min(max(value, limits[0]), limits[1]))


class _Row(NamedTuple):
    """A state's numbers but the travel, within bounds: cheaper to pass on than a view of them."""

    motion: Motion
    driver_torque: float
    driven_torque: float
    log_tension: float
    log_stiffness: float
    log_friction: float
    ratio_bias: float
    creep_error: float
    undeveloped: float


@compiled
def _row(states: _Floats, i: int) -> _Row:
    return _Row(
        Motion(states[i, 0], states[i, 1], states[i, 2]),
        states[i, 3],
        states[i, 4],
        states[i, 5],
        states[i, 6],
        states[i, 7],
        min(max(states[i, 8], -0.5), 0.5),
        min(max(states[i, 9], -0.9), 10.0),
        min(max(states[i, 10], -2.0), 2.0),
    )


@compiled
def _condition(row: _Row) -> Condition:
    return _on_belt(
        row,
        _bounded_exp(row.log_tension, _TENSIONS),
        _bounded_exp(row.log_friction, _FRICTIONS),
        _bounded_exp(row.log_stiffness, _STIFFNESSES),
    )


@compiled
def _on_belt(row: _Row, tension: float, friction: float, stiffness: float) -> Condition:
    """Condition of a row whose belt is known."""
    return Condition(
        row.driver_torque,
        row.driven_torque,
        tension,
        friction,
        stiffness,
        row.ratio_bias,
        row.creep_error,
        row.undeveloped,
    )


@compiled
def _condition_beside(row: _Row, base: _Row, of_base: Condition) -> Condition:
    """Condition of a row, by that of another: what both have in common is not computed again."""
    tension, friction, stiffness = of_base.tension, of_base.friction, of_base.stiffness
    if row.log_tension != base.log_tension:
        tension = _bounded_exp(row.log_tension, _TENSIONS)
    if row.log_friction != base.log_friction:
        friction = _bounded_exp(row.log_friction, _FRICTIONS)
    if row.log_stiffness != base.log_stiffness:
        stiffness = _bounded_exp(row.log_stiffness, _STIFFNESSES)
    return _on_belt(row, tension, friction, stiffness)


@compiled
def _same_belt(row: _Row, other: _Row) -> bool:
    return (
        row.log_tension == other.log_tension
        and row.log_stiffness == other.log_stiffness
        and row.log_friction == other.log_friction
    )


@compiled
def propagate(c: DriveConstants, states: _Floats, dt: float) -> _Floats:
    """Return rows of states `dt` [s] later, see `propagate_each`."""
    out = states.copy()
    propagate_each(c, out, dt)
    return out


@compiled
def propagate_each(c: DriveConstants, states: _Floats, dt: float) -> None:
    """Advance what moves in rows of states by `dt` [s]: `motion.step_at_speed` for each.

    The belt's inertia is taken at the first row's speed. Each row is solved from the solution of
    the first; where only the motion differs, that is mostly a step without another evaluation, or
    a cubic through that solution and another one of the same belt.
    """
    base = _row(states, 0)
    speed = abs(c.driver_radius * base.motion.driver_speed)
    law, first_condition = step_law(c, dt), _condition(base)
    first_step = step_equation(c, law, base.motion, first_condition)
    forward = first_step.along >= 0.0
    first_belt = belt_in(c, first_condition, speed, forward)
    first = loaded_near_pull(c, first_belt, abs(base.motion.pull), UNKNOWN)
    first_pull, first = stepped_pull(c, first_belt, first_step, first, first)
    beside = first
    for i in range(states.shape[0]):
        row = _row(states, i)
        motion, same_belt = row.motion, _same_belt(row, base)
        condition = _condition_beside(row, base, first_condition)
        step = step_equation(c, law, motion, condition)
        alike = (step.along >= 0.0) == forward
        if alike and same_belt:
            pull, last = stepped_pull(c, first_belt, step, first, beside)
            if last.traction != first.traction:
                beside = last
        else:
            belt = belt_in(c, condition, speed, step.along >= 0.0)
            near = near_on(belt, first_belt, first.near) if alike else UNKNOWN
            guess = first_pull + (abs(step.along) - abs(first_step.along)) / step.stiff
            start = loaded_near_pull(c, belt, guess, near)
            pull, _ = stepped_pull(c, belt, step, start, start)
        moved = stepped_motion(c, law, motion, condition, step, pull)
        states[i, 0] = moved.driver_speed
        states[i, 1] = moved.driven_speed
        states[i, 2] = moved.pull
        turned2 = motion.driver_speed + moved.driver_speed
        turned1 = motion.driven_speed + moved.driven_speed
        states[i, 11] += 0.5 * dt * (c.driver_radius * turned2 - c.driven_radius * turned1)


@compiled
def step_direction(c: DriveConstants, state: _Floats, dt: float) -> _Floats:
    """Gradient (12,), in the state, of the pull that a step of `dt` [s] without creep leads to.

    Scaled to 1 in the pull. States that do not change this sum, tension, kf, mu or the creep's
    error hardly change the step.
    """
    gain = dt / c.span_compliance
    driven_radius = c.driven_radius * (1.0 + state[8])
    v2, v1 = c.driver_radius * state[0], driven_radius * state[1]
    direction = np.zeros(STATES)
    direction[0] = gain * c.driver_radius
    direction[1] = -gain * driven_radius
    direction[2] = 1.0
    direction[3] = gain * dt * c.driver_radius / c.driver_inertia
    direction[4] = -gain * dt * c.driven_radius / c.driven_inertia
    direction[8] = -gain * c.driven_radius * state[1]
    direction[10] = -gain * max(abs(v1), abs(v2))
    return direction


@compiled
def slip_per_pull(c: DriveConstants, state: _Floats) -> float:
    """Slip [-] per pull [1/N] of steady creep, by a state (12,); at least the belt's own strain."""
    condition = _condition(_row(state.reshape(1, STATES), 0))
    pull = max(abs(state[2]), _TELLING_PULL * condition.tension)
    motion = Motion(state[0], state[1], math.copysign(pull, state[2]))
    creep: float = abs(predicted_slip(c, motion, condition)) / pull
    strain: float = 1.0 / c.axial_stiffness
    return max(creep, strain)


class _Steady(NamedTuple):
    """What a belt and a pull determine of the readings."""

    belt: MountedBelt
    forward: bool
    pull: float
    capacity: float
    creep: Creep
    slack: float
    tight: float
    near: Near


@compiled
def _steady(
    c: DriveConstants, belt: MountedBelt, along: float, capacity: float, near: Near
) -> _Steady:
    pull = abs(along)
    creep, near = steady_creep(c, belt, pull, capacity, near)
    slack, tight = creep.slack, creep.tight
    if pull > _ROUNDING * creep.pull:  # what the steady creep was limited to
        slack, tight = tensions_at_pull(c, belt, pull, capacity, near)
    return _Steady(belt, along >= 0.0, pull, capacity, creep, slack, tight, near)


@compiled
def read(c: DriveConstants, states: _Floats, slowest: float) -> _Floats:
    """Rows of states to rows of readings; below rim speed `slowest` [m/s] slip is taken at it.

    The belt's inertia is taken at the first row's speed. Each row is solved from the first's
    solution; where pull and belt are the first's, so is the creep.
    """
    out = np.empty((states.shape[0], READINGS))
    base = _row(states, 0)
    condition, motion = _condition(base), base.motion
    speed, along = abs(c.driver_radius * motion.driver_speed), pull_along(c, motion, condition)
    belt = belt_in(c, condition, speed, along >= 0.0)
    capacity = capacity_of(c, belt, UNKNOWN)
    first = _steady(c, belt, along, capacity, UNKNOWN)
    of_base = condition
    for i in range(states.shape[0]):
        row = _row(states, i)
        motion, same_belt = row.motion, _same_belt(row, base)
        condition = _condition_beside(row, base, of_base)
        along = pull_along(c, motion, condition)
        at = first
        if (along >= 0.0) != first.forward or not same_belt:
            belt = belt_in(c, condition, speed, along >= 0.0)
            near = UNKNOWN
            if (along >= 0.0) == first.forward:
                near = near_on(belt, first.belt, first.near)
            capacity = capacity_of(c, belt, near)
            at = _steady(c, belt, along, capacity, near)
        elif abs(along) != first.pull:
            at = _steady(c, first.belt, along, first.capacity, first.near)
        v2, v1 = rim_speed(c, motion, condition)
        slip = (v2 - v1) / math.copysign(max(abs(v2), slowest), v2)
        steady = slip_of_creep(at.creep, at.forward, condition.creep_error)
        receiving, giving = at.creep.receiving_transition, at.creep.giving_transition
        out[i, 0] = motion.pull * c.driven_radius
        out[i, 1] = slip
        out[i, 2] = steady
        out[i, 3] = slip - steady
        out[i, 4] = at.tight
        out[i, 5] = at.slack
        out[i, 6] = 0.5 * (at.slack + at.tight)
        out[i, 7] = receiving if at.forward else giving
        out[i, 8] = giving if at.forward else receiving
        out[i, 9] = 1.0 - at.pull / at.capacity if at.capacity > 0.0 else 0.0
        out[i, 10] = v2 - v1
        out[i, 11] = at.capacity * c.driven_radius
    return out
