"""What the sensors said at one instant, and why it may be turned away."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

from belt_ros.estimation.assumptions import Joint, SensorLimits


class Rejection(IntEnum):
    """Why a measurement was not used; the numbers are those of belt_msgs/BeltState."""

    NONE = 0
    NOT_FINITE = 1
    OUT_OF_RANGE = 2
    STALE = 3
    OUT_OF_ORDER = 4
    GATED = 5
    INCOMPLETE = 6
    MALFORMED = 7


@dataclass(frozen=True, slots=True)
class Measurement:
    """One stamped set of pulley speeds and torques. NaN: not measured.

    Attributes
    ----------
    stamp_ns : int
        Time of the measurement [ns], on the sensors' clock.
    driver_speed, driven_speed : float
        omega2, omega1 [rad/s].
    driver_torque, driven_torque : float
        Put on the pulley from outside (motor, load), in its positive direction [N m].
    """

    stamp_ns: int
    driver_speed: float = math.nan
    driven_speed: float = math.nan
    driver_torque: float = math.nan
    driven_torque: float = math.nan


def check_measurement(measurement: Measurement, limits: SensorLimits) -> Rejection:
    """Return why `measurement` cannot be used by itself, or `Rejection.NONE`."""
    speeds = (measurement.driver_speed, measurement.driven_speed)
    torques = (measurement.driver_torque, measurement.driven_torque)
    if any(math.isinf(value) for value in (*speeds, *torques)):
        return Rejection.NOT_FINITE
    if any(math.isnan(speed) for speed in speeds):
        return Rejection.NOT_FINITE
    if any(abs(speed) > limits.greatest_speed for speed in speeds):
        return Rejection.OUT_OF_RANGE
    if any(abs(torque) > limits.greatest_torque for torque in torques):
        return Rejection.OUT_OF_RANGE
    return Rejection.NONE


def measurement_from_joints(
    driver: Joint,
    driven: Joint,
    stamp_ns: int,
    names: Sequence[str],
    velocities: Sequence[float],
    efforts: Sequence[float],
) -> Measurement | Rejection:
    """Read the two pulleys out of a joint state (sensor_msgs/JointState, live or from a bag).

    A torque that the message does not carry is NaN; a message without the two joints, or whose
    arrays do not match its names, gives the reason instead.
    """
    count = len(names)
    if count == 0 or len(velocities) not in (0, count) or len(efforts) not in (0, count):
        return Rejection.MALFORMED
    if len(velocities) == 0:
        return Rejection.INCOMPLETE
    try:
        at_driver = names.index(driver.name)
        at_driven = names.index(driven.name)
    except ValueError:
        return Rejection.INCOMPLETE
    if len(efforts) == 0:
        driver_effort = driven_effort = math.nan
    else:
        driver_effort = float(efforts[at_driver])
        driven_effort = float(efforts[at_driven])
    return Measurement(
        stamp_ns,
        driver.pulley_speed(float(velocities[at_driver])),
        driven.pulley_speed(float(velocities[at_driven])),
        driver.pulley_torque(driver_effort),
        driven.pulley_torque(driven_effort),
    )
