"""What the smoother's beliefs say of the drive, each quantity with its standard deviation."""

import math
from dataclasses import dataclass

import numpy as np

from belt_ros.estimation.bank import UnscentedBank
from belt_ros.estimation.estimate import Quantity, lognormal_quantity
from belt_ros.estimation.gaussian_sum import mixture_moments, normalised
from belt_ros.estimation.readings import Readings
from belt_ros.estimation.smoother import Smoothed
from belt_ros.estimation.state import STATES, Index, Reading
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.drive import BeltDrive

_GROSS_SLIP_MARGIN = 0.01  # as in the monitor


@dataclass(frozen=True, slots=True)
class HindsightEstimate:
    """State of the drive at `stamp_ns`, given the measurements after it too; SI units.

    Quantities are those of the same name in `BeltEstimate`. `changing_probability` is that of
    tension or friction being in the middle of a change.
    """

    stamp_ns: int
    driver_speed: Quantity  # [rad/s]
    driven_speed: Quantity  # [rad/s]
    transmitted_torque: Quantity  # [N m] on the driven pulley
    slip: Quantity  # [-]
    predicted_creep: Quantity  # [-]
    excess_slip: Quantity  # [-]
    tight_tension: Quantity  # [N]
    slack_tension: Quantity  # [N]
    mean_tension: Quantity  # [N]
    friction_stiffness: Quantity  # kf [N/m2], log-normal, its value the median
    friction_coefficient: Quantity  # mu [-], log-normal, its value the median
    ratio_bias: Quantity  # [-]
    creep_model_error: Quantity  # [-]
    driven_transition_angle: Quantity  # [rad]
    driver_transition_angle: Quantity  # [rad]
    margin: Quantity  # [-]
    capacity_torque: Quantity  # [N m] on the driven pulley, at gross slip
    friction_stiffness_log_stddev: float  # [-]
    gross_slip_probability: float  # [-]
    changing_probability: float  # [-]


class HindsightReader:
    """Reads quantities off smoothed beliefs as the monitor reads them off the filter's.

    Parameters
    ----------
    drive : BeltDrive
    slowest : float
        Rim speed [m/s] below which slip is referred to it.
    """

    def __init__(self, drive: BeltDrive, slowest: float) -> None:
        self._bank = UnscentedBank(drive_constants(drive), np.zeros(STATES))
        self._slowest = slowest

    def read(self, smoothed: Smoothed) -> HindsightEstimate:
        """Read all quantities, by unscented transform of every member."""
        belief = smoothed.belief
        weights = normalised(np.array([member.log_weight for member in belief]))
        self._bank.x = np.stack([member.mean for member in belief])
        self._bank.P = np.stack([member.covariance for member in belief])
        x, covariance = mixture_moments(weights, self._bank.x, self._bank.P)
        readings = Readings(weights, *self._bank.read(np.arange(len(belief)), self._slowest))
        read = readings.quantity

        def state(place: Index) -> Quantity:
            return Quantity(float(x[place]), math.sqrt(max(float(covariance[place, place]), 0.0)))

        log_stiffness = state(Index.LOG_STIFFNESS)
        return HindsightEstimate(
            stamp_ns=smoothed.stamp_ns,
            driver_speed=state(Index.DRIVER_SPEED),
            driven_speed=state(Index.DRIVEN_SPEED),
            transmitted_torque=read(Reading.TRANSMITTED_TORQUE),
            slip=read(Reading.SLIP),
            predicted_creep=read(Reading.PREDICTED_CREEP),
            excess_slip=read(Reading.EXCESS_SLIP),
            tight_tension=read(Reading.TIGHT_TENSION),
            slack_tension=read(Reading.SLACK_TENSION),
            mean_tension=read(Reading.MEAN_TENSION),
            friction_stiffness=lognormal_quantity(*log_stiffness),
            friction_coefficient=lognormal_quantity(*state(Index.LOG_FRICTION)),
            ratio_bias=state(Index.RATIO_BIAS),
            creep_model_error=state(Index.CREEP_ERROR),
            driven_transition_angle=read(Reading.DRIVEN_TRANSITION),
            driver_transition_angle=read(Reading.DRIVER_TRANSITION),
            margin=read(Reading.MARGIN),
            capacity_torque=read(Reading.CAPACITY),
            friction_stiffness_log_stddev=log_stiffness.stddev,
            gross_slip_probability=readings.probability_below(Reading.MARGIN, _GROSS_SLIP_MARGIN),
            changing_probability=float(weights @ [member.changing for member in belief]),
        )
