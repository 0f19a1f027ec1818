"""A scenario run offline, as fast as it goes: stamps, joint states and the truth behind them."""

import dataclasses
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from belt_ros.estimation import Measurement, measurement_from_joints
from belt_ros.mechanics.constants import drive_constants
from belt_ros.rig.plant import Plant
from belt_ros.rig.scenario import Scenario
from belt_ros.rig.sensors import JointSample, LoadSensors, Sensors
from belt_ros.rig.truth import Truth
from belt_ros.settings import DriveSettings

_LONGEST_STEP = 2e-4  # [s], a hundredth of the torsional period of the drive in config/paper_drive


class RigSample(NamedTuple):
    """What the rig says at one instant, and what is true then."""

    stamp_ns: int
    joints: JointSample
    truth: Truth


def simulate(settings: DriveSettings, scenario: Scenario, start_ns: int = 0) -> Iterator[RigSample]:
    """Run a scenario; the same scenario gives the same numbers every time.

    Parameters
    ----------
    settings : DriveSettings
        The drive and its joints.
    scenario : Scenario
    start_ns : int
        Stamp of the first sample [ns].
    """
    plant_random, sensor_random, _ = _generators(scenario)
    period = 1.0 / scenario.sample_rate
    steps = math.ceil(period / _LONGEST_STEP)
    dt = period / steps
    plant = Plant(
        settings.drive,
        scenario.motor,
        scenario.model_error,
        plant_random,
        scenario.commands(np.zeros(1))[0],
        dt=dt,
        load_brakes=scenario.load_brakes,
    )
    sensors = Sensors(settings.driver, settings.driven, scenario.sensors, sensor_random)
    substeps = dt * np.arange(1, steps + 1, dtype=np.float64)
    for sample in range(scenario.samples):
        if sample > 0:
            plant.advance(scenario.commands(substeps + (sample - 1) * period))
        truth = plant.truth(settings.limits.standstill_speed)
        state = plant.state
        yield RigSample(
            start_ns + scenario.stamp_ns(sample),
            sensors.measure(truth, state.driver_angle, state.driven_angle),
            truth,
        )


def _generators(scenario: Scenario) -> list[np.random.Generator]:
    """Return those of plant, joint sensors and load sensors, independent of one another."""
    return np.random.default_rng(scenario.seed).spawn(3)


def measured(
    settings: DriveSettings, scenario: Scenario, *, loads: bool = False
) -> Iterator[tuple[Measurement, Truth]]:
    """Run a scenario; give what an estimator reads from its joint states, and the truth.

    With `loads`, hub loads and span tension are measured too.
    """
    load_sensors = LoadSensors(
        drive_constants(settings.drive), scenario.sensors, _generators(scenario)[2]
    )
    for sample in simulate(settings, scenario):
        joints = sample.joints
        measurement = measurement_from_joints(
            settings.driver,
            settings.driven,
            sample.stamp_ns,
            joints.names,
            joints.velocities,
            joints.efforts,
            joints.positions,
        )
        assert isinstance(measurement, Measurement), "the rig's joint states are complete"
        if loads:
            measurement = dataclasses.replace(
                measurement, **load_sensors.measure(sample.truth)._asdict()
            )
        yield measurement, sample.truth
