"""The drives in config/: they load, make physical sense, and are estimated as they say."""

import dataclasses
import math
from pathlib import Path

import pytest

from belt_ros.estimation import Severity
from belt_ros.mechanics import torque_capacity
from belt_ros.rig import Scenario, load_scenario, measured, simulate
from belt_ros.settings import DriveSettings, load_settings, names_of_drives, read_parameters

CONFIG = Path(__file__).resolve().parents[2] / "config"
FILES = sorted(path.name for path in CONFIG.glob("*.yaml") if path.name != "analyzers.yaml")
# With the driven pulley's torque at nominal load [N m].
PAIRS = {
    "conveyor_drive.yaml": ("conveyor.yaml", 60.0),
    "robot_joint.yaml": ("robot_joint.yaml", 0.9),
}
pairs = pytest.mark.parametrize("name", sorted(PAIRS))
NAMES = ("tight_tension", "mean_tension", "capacity_torque", "margin", "friction_coefficient")


def drives(name: str) -> list[DriveSettings]:
    path = CONFIG / name
    return [
        load_settings(path, drive=drive)
        for drive in names_of_drives(read_parameters(path)) or ("",)
    ]


def played(name: str) -> tuple[DriveSettings, Scenario]:
    (settings,) = drives(name)
    return settings, load_scenario(CONFIG / "scenarios" / PAIRS[name][0], settings)


@pytest.mark.parametrize("name", FILES)
def test_its_drives_hold_a_belt_that_does_not_lift_off(name: str) -> None:
    for settings in drives(name):
        belt = settings.drive.belt
        strain = settings.prior.tension / belt.axial_stiffness
        assert 1e-4 < strain < 0.08
        assert settings.prior.tension_stddev < 0.5 * settings.prior.tension
        assert float(torque_capacity(settings.drive, settings.prior.tension)) > 0.0


def test_the_names_of_several_drives_and_of_their_joints_differ() -> None:
    several = drives("several_drives.yaml")

    assert [settings.name for settings in several] == ["infeed", "outfeed", "lift"]
    joints = [joint.name for settings in several for joint in (settings.driver, settings.driven)]
    assert len(set(joints)) == 6
    assert several[2].drive.driver == several[0].drive.driver
    assert several[2].drive.driven.inertia != several[0].drive.driven.inertia


@pairs
def test_nominal_load_leaves_a_reserve_and_creeps_no_more_than_its_belt_does(name: str) -> None:
    settings, _ = played(name)
    load = PAIRS[name][1]
    capacity = float(torque_capacity(settings.drive, settings.prior.tension))
    creep = load / settings.drive.driven.radius / settings.drive.belt.axial_stiffness

    assert 0.1 < load / capacity < 0.5
    assert creep < 0.02


@pairs
def test_its_minute_is_run_as_scripted(name: str) -> None:
    settings, scenario = played(name)
    slower = dataclasses.replace(scenario, sample_rate=5.0)
    truths = [sample.truth for sample in simulate(settings, slower)]

    assert len(truths) == 301
    assert 0.4 < min(truth.margin for truth in truths) < 0.8
    fastest = max(abs(value) for value in scenario.profiles[0].values)
    assert max(abs(truth.driver_speed) for truth in truths) == pytest.approx(fastest, rel=0.1)


@pairs
@pytest.mark.slow
def test_a_short_run_stays_within_its_error_bars_and_quiet(name: str) -> None:
    settings, scenario = played(name)
    monitor = settings.monitor()
    raised = []
    outside = dict.fromkeys(NAMES, 0)
    judged = 0
    run = dataclasses.replace(scenario, duration=20.0, sample_rate=50.0)
    for measurement, truth in measured(settings, run):
        output = monitor.step(measurement)
        assert output.estimate is not None
        if output.alarm is not None and output.alarm.severity > Severity.NORMAL:
            raised.append(output.alarm)
        judged += 1
        for quantity in NAMES:
            low, high = getattr(output.estimate, quantity).interval(1.96)
            outside[quantity] += not low <= getattr(truth, quantity) <= high

    assert raised == []
    assert all(count <= 0.05 * judged for count in outside.values()), outside
    assert output.estimate.margin.value == pytest.approx(truth.margin, abs=0.05)
    assert math.isfinite(output.estimate.margin.stddev)
