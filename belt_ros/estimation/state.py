"""The estimator's state vector, its law of motion and what can be read off it, compiled.

Eleven numbers: what moves (speeds, pull, torques from outside), what the belt is (logarithms of
tension, kf and mu, which are positive and may be uncertain by decades), and how far the model may
be trusted (radius-ratio bias, relative error of the predicted creep, and slip beside it while creep
develops on the arcs after a change of load).

The transmitted pull is a state of its own, so torque is linear in it, and all sensors read states
directly. What the belt is shows only through the creep that unwinds the spans.
"""

import math
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants
from belt_ros.mechanics.creep import span_tensions
from belt_ros.mechanics.motion import (
    Condition,
    Motion,
    rim_speed,
    slip_of_creep,
    steady_creep,
    step_motion,
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


STATES = len(Index)
READINGS = len(Reading)
_LOG_LIMIT = 60.0
_ROUNDING = 1.0 + 1e-6


@compiled
def _bounded_exp(value: float) -> float:
    return math.exp(min(max(value, -_LOG_LIMIT), _LOG_LIMIT))


@compiled
def _condition(row: _Floats) -> Condition:
    return Condition(
        row[3],
        row[4],
        _bounded_exp(row[5]),
        _bounded_exp(row[7]),
        _bounded_exp(row[6]),
        min(max(row[8], -0.5), 0.5),
        min(max(row[9], -0.9), 10.0),
        min(max(row[10], -2.0), 2.0),
    )


@compiled
def propagate(c: DriveConstants, states: _Floats, dt: float) -> _Floats:
    """Advance what moves in rows of states by `dt` [s]."""
    out = states.copy()
    for i in range(states.shape[0]):
        row = states[i]
        moved = step_motion(c, Motion(row[0], row[1], row[2]), _condition(row), dt)
        out[i, 0] = moved.driver_speed
        out[i, 1] = moved.driven_speed
        out[i, 2] = moved.pull
    return out


@compiled
def read(c: DriveConstants, states: _Floats, slowest: float) -> _Floats:
    """Rows of states to rows of readings; below rim speed `slowest` [m/s] slip is taken at it."""
    out = np.empty((states.shape[0], 11))
    for i in range(states.shape[0]):
        row = states[i]
        motion = Motion(row[0], row[1], row[2])
        condition = _condition(row)
        v2, v1 = rim_speed(c, motion, condition)
        base = math.copysign(max(abs(v2), slowest), v2)
        pull = abs(motion.pull)
        slip = (v2 - v1) / base
        arcs, forward, capacity = steady_creep(c, motion, condition)
        slack, tight = arcs.slack, arcs.tight
        if pull > _ROUNDING * arcs.pull:  # what the steady creep was limited to
            slack, tight = span_tensions(
                c,
                pull,
                condition.tension,
                condition.friction,
                condition.stiffness,
                abs(v2),
                forward,
            )
        steady = slip_of_creep(arcs, forward, condition.creep_error)
        receiving, giving = arcs.receiving_transition, arcs.giving_transition
        out[i, 0] = motion.pull * c.driven_radius
        out[i, 1] = slip
        out[i, 2] = steady
        out[i, 3] = slip - steady
        out[i, 4] = tight
        out[i, 5] = slack
        out[i, 6] = 0.5 * (slack + tight)
        out[i, 7] = receiving if forward else giving
        out[i, 8] = giving if forward else receiving
        out[i, 9] = 1.0 - pull / capacity if capacity > 0.0 else 0.0
        out[i, 10] = v2 - v1
    return out
