"""Measurements of a drive in steady states, from the mechanics alone and without the rig."""

import dataclasses
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from belt_ros.estimation import Measurement
from belt_ros.mechanics import solve_equilibrium
from belt_ros.settings import DriveSettings

CONFIG = Path(__file__).resolve().parents[2] / "config"
SPEED = 120.0  # rad/s
MILLISECOND = 1_000_000


@dataclasses.dataclass(frozen=True)
class Belt:
    """What is true of a drive."""

    tension: float
    friction_stiffness: float
    friction_coefficient: float
    ratio_bias: float = 0.0
    creep_error: float = 0.0

    def drive(self, settings: DriveSettings):
        contact = {
            "friction_stiffness": self.friction_stiffness,
            "friction_coefficient": self.friction_coefficient,
        }
        drive = settings.drive
        return dataclasses.replace(
            drive,
            driven=dataclasses.replace(drive.driven, **contact),
            driver=dataclasses.replace(drive.driver, **contact),
        )

    def capacity(self, settings: DriveSettings) -> float:
        state = solve_equilibrium(self.drive(settings), 0.0, self.tension, SPEED)
        return float(state.torque_capacity)


def run(
    settings: DriveSettings,
    belt: Belt,
    loads: Sequence[float],
    *,
    seed: int = 0,
    hold: float = 3.0,
    speed: float = SPEED,
    begin_ns: int = 1_750_000_000_000_000_000,
) -> Iterator[Measurement]:
    """Hold each load [N m] for a while, with the noise that the settings tell."""
    random = np.random.default_rng(seed)
    noise, drive = settings.noise, belt.drive(settings)
    count = 0
    for load in loads:
        state = solve_equilibrium(drive, load, belt.tension, speed)
        slip = float(state.slip) * (1.0 + belt.creep_error)
        driven = speed * (1.0 - slip) * drive.driver.radius / drive.driven.radius
        driven /= 1.0 + belt.ratio_bias
        torque = load * drive.driver.radius / drive.driven.radius
        for _ in range(round(100 * hold)):
            rough = random.normal(size=4)
            speeds = [
                value + math.hypot(noise.speed_relative * value, noise.speed_absolute) * error
                for value, error in zip((speed, driven), rough[:2], strict=True)
            ]
            torques = [
                value + math.hypot(noise.torque_relative * value, noise.torque_absolute) * error
                for value, error in zip((torque, -load), rough[2:], strict=True)
            ]
            yield Measurement(begin_ns + 10 * MILLISECOND * count, *speeds, *torques)
            count += 1
