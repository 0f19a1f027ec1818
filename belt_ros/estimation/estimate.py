"""What the estimator says of a drive at one instant, each quantity with its standard deviation."""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

from belt_ros.estimation.measurement import Rejection


class Phase(IntEnum):
    """Phase of operation; the numbers are those of belt_msgs/BeltState."""

    UNKNOWN = 0
    STANDSTILL = 1
    RUNNING = 2
    REVERSE = 3
    REGENERATING = 4
    GROSS_SLIP = 5
    LOST = 6


class Knowledge(IntEnum):
    """Whether the data have narrowed a quantity; the numbers are those of belt_msgs/BeltState."""

    UNKNOWN = 0
    AT_PRIOR = 1
    LEARNED = 2


class Consistency(IntEnum):
    """Whether innovations are as large as stated; the numbers are those of belt_msgs/BeltState."""

    UNKNOWN = 0
    CONSISTENT = 1
    OVERCONFIDENT = 2
    UNDERCONFIDENT = 3


class Quantity(NamedTuple):
    """A value and its standard deviation, in the same unit."""

    value: float
    stddev: float

    def interval(self, sigmas: float = 1.96) -> tuple[float, float]:
        """Return the lower and upper bound at `sigmas` standard deviations (1.96: 95 %)."""
        return self.value - sigmas * self.stddev, self.value + sigmas * self.stddev


_FARTHEST = 230.0  # logarithm of 1e100
UNKNOWN = Quantity(math.nan, math.nan)


class Fit(NamedTuple):
    """Mean innovation squared per degree of freedom, 1 if the filter is right, see `fit`."""

    consistency: Consistency = Consistency.UNKNOWN
    mean: float = 0.0  # [-], 0 while unknown, as are the limits
    lowest: float = 0.0  # mean that still counts as consistent [-]
    highest: float = 0.0


class Reserve(NamedTuple):
    """What the drive can carry."""

    capacity_torque: Quantity = UNKNOWN  # [N m] on the driven pulley, at gross slip
    gross_slip_probability_at_peak_load: float = 0.0  # [-], 0 if no peak load is set


class LostTraction(NamedTuple):
    """Probabilities that traction has been lost, and that one cause alone explains it [-]."""

    traction: float = math.nan
    tension: float = math.nan
    friction: float = math.nan


UNKNOWN_FIT = Fit()
UNKNOWN_RESERVE = Reserve()
UNKNOWN_LOSS = LostTraction()


def probability_below(quantity: Quantity, limit: float) -> float:
    """Probability that a normally distributed quantity lies below `limit`."""
    if quantity.stddev <= 0.0:
        return 1.0 if quantity.value < limit else 0.0
    return 0.5 * math.erfc((quantity.value - limit) / (quantity.stddev * math.sqrt(2.0)))


def lognormal_quantity(log_mean: float, log_stddev: float) -> Quantity:
    """Median and standard deviation of a log-normal, from those of its logarithm.

    Always finite: beyond `_FARTHEST` and ten standard deviations there is nothing to be told.
    """
    variance = min(log_stddev, 10.0) ** 2
    median = math.exp(min(max(log_mean, -_FARTHEST), _FARTHEST))
    return Quantity(median, median * math.exp(0.5 * variance) * math.sqrt(math.expm1(variance)))


def log_spread(quantity: Quantity) -> float:
    """Return the standard deviation of ln x of a `lognormal_quantity`."""
    ratio = quantity.stddev / quantity.value
    return math.sqrt(math.log(0.5 + 0.5 * math.sqrt(1.0 + 4.0 * ratio * ratio)))


@dataclass(frozen=True, slots=True)
class Health:
    """How well measurements fit, and what became of them."""

    innovation_squared: float  # normalised, of the last update [-]
    degrees_of_freedom: int
    accepted: int
    resets: int
    last_rejection: Rejection
    rejections: tuple[int, ...]  # by Rejection
    fit: Fit = UNKNOWN_FIT
    sensor_fits: tuple[tuple[str, Fit], ...] = ()  # by sensor


@dataclass(frozen=True, slots=True)
class BeltEstimate:
    """State of the drive at `stamp_ns`; SI units, angles from each pulley's inlet.

    `friction_stiffness` is log-normal: its value is the median, and
    `friction_stiffness_log_stddev` the standard deviation of ln kf.
    """

    stamp_ns: int
    phase: Phase
    driver_speed: Quantity  # [rad/s]
    driven_speed: Quantity  # [rad/s]
    transmitted_torque: Quantity  # [N m] on the driven pulley
    slip: Quantity  # [-]
    predicted_creep: Quantity  # [-]
    excess_slip: Quantity  # [-]
    accumulated_slip: Quantity  # [m]
    tight_tension: Quantity  # [N]
    slack_tension: Quantity  # [N]
    mean_tension: Quantity  # [N]
    friction_stiffness: Quantity  # kf [N/m2]
    friction_stiffness_log_stddev: float  # [-]
    friction_coefficient: Quantity  # mu [-]
    ratio_bias: Quantity  # [-]
    creep_model_error: Quantity  # [-]
    driven_transition_angle: Quantity  # [rad]
    driver_transition_angle: Quantity  # [rad]
    margin: Quantity  # [-]
    gross_slip_probability: float  # [-]
    tension_knowledge: Knowledge
    friction_stiffness_knowledge: Knowledge
    friction_coefficient_knowledge: Knowledge
    health: Health
    reserve: Reserve = UNKNOWN_RESERVE
    lost_traction: LostTraction = UNKNOWN_LOSS

    @property
    def capacity_torque(self) -> Quantity:
        """Torque [N m] on the driven pulley at gross slip of the pulley that slips first."""
        return self.reserve.capacity_torque
