"""A scenario run offline, as fast as it goes: stamps, joint states and the truth behind them."""

import dataclasses
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from belt_ros.estimation import Measurement, measurement_from_joints
from belt_ros.mechanics.constants import drive_constants
from belt_ros.rig.faults import Report
from belt_ros.rig.plant import Plant
from belt_ros.rig.running import RunningScenario
from belt_ros.rig.scenario import Scenario
from belt_ros.rig.sensors import JointSample, LoadSensors, Sensors
from belt_ros.rig.truth import Truth
from belt_ros.settings import DriveSettings

_LONGEST_STEP = 2e-4  # [s], a hundredth of the torsional period of the drive in config/paper_drive


class RigSample(NamedTuple):
    """What the rig's sensors say at one instant, what is true then, and what goes out.

    `reports` are the joint states that faults make of it; where they are None, it goes out as read.
    """

    stamp_ns: int
    joints: JointSample
    truth: Truth
    reports: tuple[Report, ...] | None = None

    @property
    def published(self) -> tuple[Report, ...]:
        """The joint states that go out at this instant: none, one or several."""
        if self.reports is None:
            return (Report(self.stamp_ns, self.joints),)
        return self.reports


def simulate(
    settings: DriveSettings,
    scenario: Scenario,
    start_ns: int = 0,
    running: RunningScenario | None = None,
) -> Iterator[RigSample]:
    """Run a scenario; the same scenario gives the same numbers every time.

    What faults still hold back at the end is lost.

    Parameters
    ----------
    settings : DriveSettings
        The drive and its joints.
    scenario : Scenario
    start_ns : int
        Stamp of the first sample [ns].
    running : RunningScenario, optional
        Of this scenario, to ask for events and faults on the way.
    """
    running = running or RunningScenario(scenario, settings)
    running.start(start_ns)
    plant_random, sensor_random, _ = _generators(scenario)
    period = 1.0 / scenario.sample_rate
    steps = math.ceil(period / _LONGEST_STEP)
    dt = period / steps
    plant = Plant(
        settings.drive,
        scenario.motor,
        scenario.model_error,
        plant_random,
        running.commands(np.zeros(1))[0],
        dt=dt,
        load_brakes=scenario.load_brakes,
    )
    sensors = Sensors(settings.driver, settings.driven, scenario.sensors, sensor_random)
    substeps = dt * np.arange(1, steps + 1, dtype=np.float64)
    for sample in range(scenario.samples):
        if sample > 0:
            plant.advance(running.commands(substeps + (sample - 1) * period))
        truth = plant.truth(settings.limits.standstill_speed)
        state = plant.state
        stamp_ns = start_ns + scenario.stamp_ns(sample)
        joints = sensors.measure(truth, state.driver_angle, state.driven_angle)
        yield RigSample(stamp_ns, joints, truth, running.reports(stamp_ns, joints))


def _generators(scenario: Scenario) -> list[np.random.Generator]:
    """Return those of plant, joint sensors and load sensors, independent of one another."""
    return np.random.default_rng(scenario.seed).spawn(3)


def measured(
    settings: DriveSettings, scenario: Scenario, *, loads: bool = False
) -> Iterator[tuple[Measurement, Truth]]:
    """Run a scenario; give what an estimator reads from its joint states, and the truth by then.

    With `loads`, hub loads and span tension are measured too.
    """
    load_sensors = LoadSensors(
        drive_constants(settings.drive), scenario.sensors, _generators(scenario)[2]
    )
    for sample in simulate(settings, scenario):
        said = load_sensors.measure(sample.truth)._asdict() if loads else None
        for stamp_ns, joints in sample.published:
            measurement = measurement_from_joints(
                settings.driver,
                settings.driven,
                stamp_ns,
                joints.names,
                joints.velocities,
                joints.efforts,
                joints.positions,
            )
            assert isinstance(measurement, Measurement), "the rig's joint states are complete"
            if said is not None:
                measurement = dataclasses.replace(measurement, **said)
            yield measurement, sample.truth
