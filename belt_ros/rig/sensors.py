"""What sensors make of the truth: encoders and torques, as a joint state carries them, and loads.

Speed is what a servo drive reports: measured by its own fast loop, so without delay, noisy and
rounded to the drive's resolution. Position is counted by the encoder. Torque and loads are noisy.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from belt_ros.estimation import Joint
from belt_ros.estimation.assumptions import setting
from belt_ros.estimation.load_sensors import loads_of_tensions
from belt_ros.mechanics.constants import DriveConstants
from belt_ros.rig.truth import Truth


@dataclass(frozen=True)
class SensorErrors:
    """Imperfections of the sensors, at the pulley.

    Of two steps given for a quantity, a resolution and a quantum, the coarser counts.
    """

    counts_per_turn: float = setting(131072.0, "encoder counts per turn", "-", 1.0, 1e12)
    speed_resolution: float = setting(1e-3, "step of the reported speed", "rad/s", 0.0, 1e3)
    speed_relative: float = setting(1e-4, "speed noise relative to speed", "-", 0.0, 1.0)
    speed_absolute: float = setting(1e-3, "speed noise, independent of speed", "rad/s", 0.0, 1e6)
    torque_relative: float = setting(0.01, "torque noise relative to torque", "-", 0.0, 1.0)
    torque_absolute: float = setting(0.1, "torque noise, independent of torque", "N m", 0.0, 1e9)
    speed_quantum: float = setting(0.0, "coarser step of speed, if any", "rad/s", 0.0, 1e6)
    position_absolute: float = setting(0.0, "position noise before it is counted", "rad", 0.0, 1e3)
    position_quantum: float = setting(0.0, "coarser step of position, if any", "rad", 0.0, 1e3)
    load_relative: float = setting(0.01, "load noise relative to the load", "-", 0.0, 1.0)
    load_absolute: float = setting(1.0, "load noise, independent of the load", "N", 0.0, 1e9)

    @property
    def speed_step(self) -> float:
        """Step of the reported speed [rad/s]; 0: none."""
        return max(self.speed_resolution, self.speed_quantum)

    @property
    def counts(self) -> float:
        """Counts of the reported position per turn."""
        if self.position_quantum <= 0.0:
            return self.counts_per_turn
        return min(self.counts_per_turn, 2.0 * math.pi / self.position_quantum)


class JointSample(NamedTuple):
    """Contents of one sensor_msgs/JointState: driver, driven."""

    names: tuple[str, str]
    positions: tuple[float, float]  # [rad]
    velocities: tuple[float, float]  # [rad/s]
    efforts: tuple[float, float]


class LoadSample(NamedTuple):
    """What load sensors say [N], as `Measurement` describes it."""

    driver_hub_load: float
    driven_hub_load: float
    span_tension: float


def joint_values(
    joint: Joint, angle: float, speed: float, torque: float
) -> tuple[float, float, float]:
    """Position, velocity and effort of a joint; the inverse of what `Joint` reads from them."""
    position = joint.sign * angle * joint.gear_ratio
    velocity = joint.sign * speed * joint.gear_ratio
    return position, velocity, joint.effort(torque, speed)


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
        self._position_random = random.spawn(1)[0]  # leaves the noise of all else as it is

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
        if errors.position_absolute > 0.0:
            angle += errors.position_absolute * self._position_random.standard_normal()
        position, velocity, _ = joint_values(
            joint,
            counted(angle, errors.counts),
            rounded(speed + noise[0] * speed_stddev, errors.speed_step),
            0.0,
        )
        # The bearings know the true speed.
        return position, velocity, joint.effort(torque + noise[1] * torque_stddev, speed)


class LoadSensors:
    """Load cells under both shafts, and a roller in the span that leaves the driven pulley.

    Parameters
    ----------
    constants : DriveConstants
    errors : SensorErrors
    random : numpy.random.Generator
    """

    def __init__(
        self, constants: DriveConstants, errors: SensorErrors, random: np.random.Generator
    ) -> None:
        self._constants = constants
        self._errors = errors
        self._random = random

    def measure(self, truth: Truth) -> LoadSample:
        """Return what they say of a state."""
        c = self._constants
        speed = abs(c.driver_radius * truth.driver_speed)
        loads = loads_of_tensions(
            c, truth.tight_tension, truth.slack_tension, truth.transmitted_torque, speed
        )
        noise = self._random.standard_normal(3).tolist()
        return LoadSample(*(self._noisy(*pair) for pair in zip(loads, noise, strict=True)))

    def _noisy(self, load: float, noise: float) -> float:
        errors = self._errors
        return load + noise * math.hypot(errors.load_relative * load, errors.load_absolute)
