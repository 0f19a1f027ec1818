"""The drive as it truly is: a motor under speed control, the belt, a load, and what is unknown.

The mechanics are those of `belt_ros.mechanics.motion`, in steps fine enough to follow the torsional
oscillation of the two pulleys on the belt. No clock, no ROS: commands come in as arrays.
"""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.assumptions import setting
from belt_ros.estimation.state import slip_per_pull
from belt_ros.mechanics import BeltDrive
from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants, drive_constants
from belt_ros.mechanics.motion import (
    Condition,
    Motion,
    condition_capacity,
    rim_speed,
    step_motion,
)
from belt_ros.rig.model_error import CreepErrors, ModelError
from belt_ros.rig.truth import Truth, read_truth, truth_row

_Floats = NDArray[np.float64]
_BRAKE_ROUNDING = 0.05  # [rad/s] below which a brake's torque fades out
_LARGEST_START_LOAD = 0.95  # of the capacity
_LARGEST_GAIN = 0.5  # of what would stop the bare driver within one step
_SLOWEST = 1e-9  # [m/s] rim speed to which slip is referred at standstill


class Command(IntEnum):
    """Places in a row of commands: what a scenario prescribes at an instant."""

    SPEED = 0  # of the driver [rad/s]
    LOAD = 1  # against the driven pulley's rotation [N m]
    TENSION = 2  # held by the tensioning [N]
    FRICTION_COEFFICIENT = 3  # of the driven pulley [-]
    FRICTION_STIFFNESS = 4  # of the driven pulley [N/m2]


@dataclass(frozen=True)
class Motor:
    """The driver's speed control: a PI controller without overshoot, with limited torque."""

    bandwidth: float = setting(15.0, "natural frequency of the speed control", "rad/s", 0.1, 1e3)
    torque_limit: float = setting(1e3, "greatest torque of the motor", "N m", 1e-6, 1e9)


class Control(NamedTuple):
    """Motor and load in the form that compiled code takes."""

    proportional: float  # [N m s/rad]
    integral: float  # [N m/rad]
    limit: float  # [N m]
    brakes: bool  # the load turns round with the rotation, rather than keep its direction


class PlantState(NamedTuple):
    """All that changes while the plant runs."""

    motion: Motion
    driver_torque: float  # of the motor [N m]
    driven_torque: float  # of the load, in the pulley's positive direction [N m]
    integral: float  # of the controller [N m]
    driver_angle: float  # [rad]
    driven_angle: float  # [rad]
    lost_travel: float  # rim travel lost to slip [m]


def _control(c: DriveConstants, motor: Motor, dt: float, *, brakes: bool) -> Control:
    """Gains for critical damping of both inertias, as far as steps of `dt` [s] allow."""
    inertia = c.driver_inertia + c.driven_inertia * (c.driver_radius / c.driven_radius) ** 2
    proportional = 2.0 * motor.bandwidth * inertia
    reduction = min(1.0, _LARGEST_GAIN * c.driver_inertia / dt / proportional)
    return Control(
        proportional * reduction,
        motor.bandwidth**2 * inertia * reduction**2,
        motor.torque_limit,
        brakes,
    )


@compiled
def _load_torque(control: Control, load: float, speed: float, gain: float) -> float:
    """Torque of the load on the driven pulley [N m]; a brake never turns it back within a step.

    `gain` is the change of speed per torque in one step, dt/J.
    """
    if not control.brakes:
        return -load
    return -load * math.tanh(speed / max(_BRAKE_ROUNDING, abs(load) * gain))


@compiled
def _advance(
    c: DriveConstants,
    control: Control,
    state: PlantState,
    commands: _Floats,
    ratio_bias: float,
    creep_error: float,
    undeveloped: float,
    dt: float,
) -> PlantState:
    """Take one step of `dt` [s] for each row of commands."""
    motion = state.motion
    motor_torque, load_torque = state.driver_torque, state.driven_torque
    integral, lost_travel = state.integral, state.lost_travel
    driver_angle, driven_angle = state.driver_angle, state.driven_angle
    for i in range(commands.shape[0]):
        error = commands[i, 0] - motion.driver_speed
        wanted = control.proportional * error + integral
        motor_torque = min(max(wanted, -control.limit), control.limit)
        # Integrating at the limit would wind the controller up; integrating back never does.
        if motor_torque == wanted or error * wanted < 0.0:
            integral += control.integral * error * dt
        load_torque = _load_torque(
            control, commands[i, 1], motion.driven_speed, dt / c.driven_inertia
        )
        condition = Condition(
            motor_torque,
            load_torque,
            commands[i, 2],
            commands[i, 3],
            commands[i, 4],
            ratio_bias,
            creep_error,
            undeveloped,
        )
        motion = step_motion(c, motion, condition, dt)
        v2, v1 = rim_speed(c, motion, condition)
        lost_travel += dt * (v2 - v1)
        driver_angle += dt * motion.driver_speed
        driven_angle += dt * motion.driven_speed
    return PlantState(
        motion, motor_torque, load_torque, integral, driver_angle, driven_angle, lost_travel
    )


class Plant:
    """One belt drive in motion.

    Parameters
    ----------
    drive : BeltDrive
        Geometry, belt and inertias; its kf and mu count only as ratios between the pulleys.
    motor : Motor
    error : ModelError
    random : numpy.random.Generator
        Makes the creep error wander.
    start : ndarray
        Commands (5,) at the start, in the order of `Command`. The plant starts in the steady state
        that belongs to them, or as near below the capacity as there is one.
    dt : float
        Length of a step [s].
    load_brakes : bool
        True: the load turns round with the rotation, as a brake's does; False: it keeps its
        direction.
    """

    def __init__(
        self,
        drive: BeltDrive,
        motor: Motor,
        error: ModelError,
        random: np.random.Generator,
        start: _Floats,
        *,
        dt: float = 2e-4,
        load_brakes: bool = True,
    ) -> None:
        assert dt > 0.0
        self._constants = drive_constants(drive)
        self._control = _control(self._constants, motor, dt, brakes=load_brakes)
        self._error = error
        self._dt = dt
        self._command = np.asarray(start, dtype=np.float64)
        self._creep = CreepErrors(error, self._constants, random)
        self.state = self._steady_state()
        self._creep.start(self.state.motion.pull)

    def _condition(self, driver_torque: float, driven_torque: float) -> Condition:
        """Return the true condition under the present command."""
        return Condition(
            driver_torque,
            driven_torque,
            float(self._command[Command.TENSION]),
            float(self._command[Command.FRICTION_COEFFICIENT]),
            float(self._command[Command.FRICTION_STIFFNESS]),
            self._error.ratio_bias,
            self._creep.relative,
            self._creep.beside,
        )

    def _steady_state(self) -> PlantState:
        c = self._constants
        speed = float(self._command[Command.SPEED])
        driven_radius = c.driven_radius * (1.0 + self._error.ratio_bias)
        rim = c.driver_radius * speed
        load = _load_torque(self._control, float(self._command[Command.LOAD]), speed, 0.0)
        condition = self._condition(0.0, load)
        capacity = condition_capacity(c, condition, abs(rim), rim * load <= 0.0)
        limit = _LARGEST_START_LOAD * capacity
        pull = min(max(-load / c.driven_radius, -limit), limit)
        carried = Motion(speed, rim / driven_radius, pull)
        slip = read_truth(c, carried, condition, 0.0, _SLOWEST).predicted_creep
        motor = pull * c.driver_radius
        motion = Motion(speed, rim * (1.0 - slip) / driven_radius, pull)
        return PlantState(motion, motor, load, motor, 0.0, 0.0, 0.0)

    def advance(self, commands: _Floats) -> None:
        """Take one step for each row of `commands` (n, 5), in the order of `Command`."""
        self._let_creep_wander(self._dt * commands.shape[0])
        self._command = commands[-1]
        self.state = _advance(
            self._constants,
            self._control,
            self.state,
            commands,
            self._error.ratio_bias,
            self._creep.relative,
            self._creep.beside,
            self._dt,
        )

    def _let_creep_wander(self, dt: float) -> None:
        state, c, per_pull = self.state, self._constants, 0.0
        if self._error.undeveloped_creep > 0.0:
            condition = self._condition(state.driver_torque, state.driven_torque)
            per_pull = slip_per_pull(c, truth_row(state.motion, condition))
        speed = c.driver_radius * abs(state.motion.driver_speed)
        self._creep.advance(state.motion.pull, per_pull, speed, dt)

    def truth(self, standstill_speed: float) -> Truth:
        """Return all quantities of the present state; see `read_truth`."""
        state = self.state
        return read_truth(
            self._constants,
            state.motion,
            self._condition(state.driver_torque, state.driven_torque),
            state.lost_travel,
            standstill_speed,
        )
