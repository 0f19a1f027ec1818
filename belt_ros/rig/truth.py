"""What truly is, in the estimator's own terms, so that the two can be laid side by side."""

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation import BeltEstimate, Health, Knowledge, Phase, Quantity, Rejection
from belt_ros.estimation.estimate import LostTraction, Reserve
from belt_ros.estimation.state import STATES, Index, Reading, read
from belt_ros.mechanics.constants import DriveConstants
from belt_ros.mechanics.motion import Condition, Motion

# Creep has no bound at the capacity, so no pulley ever slides over the whole of its arc in a formal
# sense. Within this margin of it the belt's own creep no longer explains the slip.
GROSS_SLIP_MARGIN = 0.01
_IDLE_MARGIN = 0.995  # above it the pull is too small to speak of a direction of power


@dataclass(frozen=True, slots=True)
class Truth:
    """State of the drive, SI units; names and signs as in `BeltEstimate`."""

    phase: Phase
    driver_speed: float  # [rad/s]
    driven_speed: float  # [rad/s]
    driver_torque: float  # of the motor [N m]
    driven_torque: float  # of the load, in the pulley's positive direction [N m]
    transmitted_torque: float  # [N m] on the driven pulley
    slip: float  # [-]
    predicted_creep: float  # [-]
    excess_slip: float  # [-]
    accumulated_slip: float  # [m]
    tight_tension: float  # [N]
    slack_tension: float  # [N]
    mean_tension: float  # [N]
    friction_stiffness: float  # kf [N/m2]
    friction_coefficient: float  # mu [-]
    ratio_bias: float  # [-]
    creep_model_error: float  # [-]
    driven_transition_angle: float  # [rad]
    driver_transition_angle: float  # [rad]
    margin: float  # [-]
    capacity_torque: float  # at gross slip [N m]

    @property
    def pull(self) -> float:
        """Effective pull T_H - T_L >= 0 [N]."""
        return self.tight_tension - self.slack_tension

    @property
    def gross_slip(self) -> bool:
        """Whether a pulley slides over its whole arc."""
        return self.margin < GROSS_SLIP_MARGIN


def truth_row(motion: Motion, condition: Condition) -> NDArray[np.float64]:
    """Return what is read of a plant as a state of the estimator (12,), in the order of `Index`."""
    row = np.zeros(STATES)
    row[Index.DRIVER_SPEED] = motion.driver_speed
    row[Index.DRIVEN_SPEED] = motion.driven_speed
    row[Index.PULL] = motion.pull
    row[Index.LOG_TENSION] = math.log(condition.tension)
    row[Index.LOG_STIFFNESS] = math.log(condition.stiffness)
    row[Index.LOG_FRICTION] = math.log(condition.friction)
    row[Index.RATIO_BIAS] = condition.ratio_bias
    row[Index.CREEP_ERROR] = condition.creep_error
    return row


def read_truth(
    c: DriveConstants,
    motion: Motion,
    condition: Condition,
    lost_travel: float,
    standstill_speed: float,
) -> Truth:
    """Read a plant's state with the functions that the estimator uses.

    Parameters
    ----------
    c : DriveConstants
    motion : Motion
    condition : Condition
    lost_travel : float
        Rim travel lost to slip so far [m].
    standstill_speed : float
        Rim speed [m/s] below which the drive counts as standing and slip is taken at this speed.
    """
    row = truth_row(motion, condition).reshape(1, STATES)
    values = read(c, row, standstill_speed)[0].tolist()
    slip, margin = values[Reading.SLIP], values[Reading.MARGIN]
    return Truth(
        phase=_phase(c, motion, slip, margin, standstill_speed),
        driver_speed=motion.driver_speed,
        driven_speed=motion.driven_speed,
        driver_torque=condition.driver_torque,
        driven_torque=condition.driven_torque,
        transmitted_torque=values[Reading.TRANSMITTED_TORQUE],
        slip=slip,
        predicted_creep=values[Reading.PREDICTED_CREEP],
        excess_slip=values[Reading.EXCESS_SLIP],
        accumulated_slip=lost_travel,
        tight_tension=values[Reading.TIGHT_TENSION],
        slack_tension=values[Reading.SLACK_TENSION],
        mean_tension=values[Reading.MEAN_TENSION],
        friction_stiffness=condition.stiffness,
        friction_coefficient=condition.friction,
        ratio_bias=condition.ratio_bias,
        creep_model_error=condition.creep_error,
        driven_transition_angle=values[Reading.DRIVEN_TRANSITION],
        driver_transition_angle=values[Reading.DRIVER_TRANSITION],
        margin=margin,
        capacity_torque=values[Reading.CAPACITY],
    )


def _phase(
    c: DriveConstants, motion: Motion, slip: float, margin: float, standstill_speed: float
) -> Phase:
    driver_rim = c.driver_radius * motion.driver_speed
    driven_rim = c.driven_radius * motion.driven_speed
    if max(abs(driver_rim), abs(driven_rim)) < standstill_speed:
        return Phase.STANDSTILL
    if margin < GROSS_SLIP_MARGIN:
        return Phase.GROSS_SLIP
    if driver_rim * motion.pull < 0.0 and slip < 0.0 and margin < _IDLE_MARGIN:
        return Phase.REGENERATING
    return Phase.REVERSE if driver_rim < 0.0 else Phase.RUNNING


_QUANTITIES = tuple(
    field.name
    for field in dataclasses.fields(Truth)
    if field.name in BeltEstimate.__dataclass_fields__ and field.name != "phase"
)


def as_estimate(truth: Truth, stamp_ns: int) -> BeltEstimate:
    """Return the truth as an estimate without doubt: standard deviations of 0, all learned."""
    quantities: dict[str, Any] = {name: Quantity(getattr(truth, name), 0.0) for name in _QUANTITIES}
    return BeltEstimate(
        stamp_ns=stamp_ns,
        phase=truth.phase,
        **quantities,
        friction_stiffness_log_stddev=0.0,
        gross_slip_probability=1.0 if truth.gross_slip else 0.0,
        tension_knowledge=Knowledge.LEARNED,
        friction_stiffness_knowledge=Knowledge.LEARNED,
        friction_coefficient_knowledge=Knowledge.LEARNED,
        health=Health(0.0, 0, 0, 0, Rejection.NONE, (0,) * len(Rejection)),
        reserve=Reserve(Quantity(truth.capacity_torque, 0.0)),
        lost_traction=LostTraction(0.0, 0.0, 0.0),
    )
