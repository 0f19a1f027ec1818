"""What encoders and torque sensors make of the truth, as a joint state carries it.

Speed is what a servo drive reports: measured by its own fast loop, so without delay, noisy and
rounded to the drive's resolution. Position is counted by the encoder. Torque is noisy.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from belt_ros.estimation import Joint
from belt_ros.estimation.assumptions import setting
from belt_ros.rig.truth import Truth


@dataclass(frozen=True)
class SensorErrors:
    """Imperfections of both pulleys' sensors, at the pulley."""

    counts_per_turn: float = setting(131072.0, "encoder counts per turn", "-", 1.0, 1e12)
    speed_resolution: float = setting(1e-3, "step of the reported speed", "rad/s", 0.0, 1e3)
    speed_relative: float = setting(1e-4, "speed noise relative to speed", "-", 0.0, 1.0)
    speed_absolute: float = setting(1e-3, "speed noise, independent of speed", "rad/s", 0.0, 1e6)
    torque_relative: float = setting(0.01, "torque noise relative to torque", "-", 0.0, 1.0)
    torque_absolute: float = setting(0.1, "torque noise, independent of torque", "N m", 0.0, 1e9)


class JointSample(NamedTuple):
    """Contents of one sensor_msgs/JointState: driver, driven."""

    names: tuple[str, str]
    positions: tuple[float, float]  # [rad]
    velocities: tuple[float, float]  # [rad/s]
    efforts: tuple[float, float]


def joint_values(
    joint: Joint, angle: float, speed: float, torque: float
) -> tuple[float, float, float]:
    """Position, velocity and effort of a joint; the inverse of what `Joint` reads from them."""
    position = joint.sign * angle * joint.gear_ratio
    velocity = joint.sign * speed * joint.gear_ratio
    per_effort = joint.sign * joint.torque_scale * joint.gear_ratio
    return position, velocity, torque / per_effort + joint.torque_offset


def counted(angle: float, counts_per_turn: float) -> float:
    """Angle [rad] at the last encoder count that has been passed."""
    count = 2.0 * math.pi / counts_per_turn
    return math.floor(angle / count) * count


def rounded(value: float, resolution: float) -> float:
    """`value` to the nearest multiple of `resolution`; as it is where that is 0."""
    return round(value / resolution) * resolution if resolution > 0.0 else value


class Sensors:
    """Encoders and torque sensors of both pulleys.

    Parameters
    ----------
    driver, driven : Joint
        Their names, gear ratios, signs and scales.
    errors : SensorErrors
    random : numpy.random.Generator
    """

    def __init__(
        self, driver: Joint, driven: Joint, errors: SensorErrors, random: np.random.Generator
    ) -> None:
        for role, joint in (("driver", driver), ("driven", driven)):
            if joint.torque_scale == 0.0:
                raise ValueError(
                    f"{role}.torque_scale is 0; the rig cannot express a torque with it, give the "
                    "N m per unit of effort"
                )
        self._driver = driver
        self._driven = driven
        self._errors = errors
        self._random = random

    def measure(self, truth: Truth, driver_angle: float, driven_angle: float) -> JointSample:
        """Return what the sensors say of a state and of the pulleys' angles [rad]."""
        noise = self._random.standard_normal(4).tolist()
        driver = self._pulley(
            self._driver, driver_angle, truth.driver_speed, truth.driver_torque, noise[:2]
        )
        driven = self._pulley(
            self._driven, driven_angle, truth.driven_speed, truth.driven_torque, noise[2:]
        )
        positions, velocities, efforts = zip(driver, driven, strict=True)
        return JointSample((self._driver.name, self._driven.name), positions, velocities, efforts)

    def _pulley(
        self, joint: Joint, angle: float, speed: float, torque: float, noise: list[float]
    ) -> tuple[float, float, float]:
        errors = self._errors
        speed_stddev = math.hypot(errors.speed_relative * speed, errors.speed_absolute)
        torque_stddev = math.hypot(errors.torque_relative * torque, errors.torque_absolute)
        return joint_values(
            joint,
            counted(angle, errors.counts_per_turn),
            rounded(speed + noise[0] * speed_stddev, errors.speed_resolution),
            torque + noise[1] * torque_stddev,
        )
