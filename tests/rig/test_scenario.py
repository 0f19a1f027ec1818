"""Scenarios are checked before they run, and the demonstration tells the story it is meant to."""

import math
from pathlib import Path

import numpy as np
import pytest

from belt_ros.estimation import Phase
from belt_ros.rig import ScenarioError, load_scenario, simulate
from belt_ros.rig.faults import FaultKind
from belt_ros.rig.plant import Command
from belt_ros.rig.profile import Profile
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.settings import DriveSettings, load_settings


def test_profile_is_straight_between_points_and_held_beyond() -> None:
    profile = Profile((1.0, 3.0), (10.0, 20.0))
    np.testing.assert_allclose(
        profile.at(np.array([0.0, 1.0, 2.0, 3.0, 9.0])), [10, 10, 15, 20, 20]
    )


def test_two_points_at_one_time_are_a_step() -> None:
    profile = Profile((0.0, 1.0, 1.0, 2.0), (0.0, 0.0, 5.0, 5.0))
    np.testing.assert_allclose(profile.at(np.array([0.999, 1.0, 1.5])), [0.0, 5.0, 5.0])


def test_event_moves_from_the_present_value_and_holds(settings: DriveSettings) -> None:
    scenario = scenario_from_mapping(
        {
            "duration": 10.0,
            "condition.tension": 400.0,
            "events": [
                {"at": 6.0, "tension": 500.0},
                {"at": 2.0, "tension": 200.0, "over": 2.0},
            ],
        },
        settings,
    )

    tension = scenario.commands(np.array([1.0, 3.0, 5.0, 5.99, 6.0, 9.0]))[:, Command.TENSION]
    np.testing.assert_allclose(tension, [400.0, 300.0, 200.0, 200.0, 500.0, 500.0])


def test_event_may_interrupt_another(settings: DriveSettings) -> None:
    scenario = scenario_from_mapping(
        {
            "duration": 10.0,
            "events": [
                {"at": 1.0, "load": 40.0, "over": 4.0},
                {"at": 3.0, "load": 0.0, "over": 1.0},
            ],
        },
        settings,
    )

    load = scenario.commands(np.array([3.0, 3.5, 4.5]))[:, Command.LOAD]
    np.testing.assert_allclose(load, [20.0, 10.0, 0.0])


def test_defaults_come_from_the_drive_description(settings: DriveSettings) -> None:
    scenario = scenario_from_mapping({"duration": 1.0}, settings)

    start = scenario.commands(np.zeros(1))[0]
    assert start[Command.TENSION] == settings.prior.tension
    assert start[Command.FRICTION_STIFFNESS] == settings.prior.friction_stiffness
    assert scenario.sensors.speed_absolute == settings.noise.speed_absolute
    assert scenario.samples == 101


def test_faults_are_read_with_their_defaults(settings: DriveSettings) -> None:
    faults = [
        {"at": 1.0, "kind": "stuck", "sensor": "driven_speed"},
        {"at": 2, "kind": "spike", "sensor": "driver_torque", "value": "5e1"},
        {"at": 3.0, "kind": "dropout", "duration": 2.0, "share": 0.5},
    ]
    stuck, spike, dropout = scenario_from_mapping(
        {"duration": 10.0, "faults": faults}, settings
    ).faults
    assert (stuck.kind, stuck.begin, stuck.end) == (FaultKind.STUCK, 1.0, math.inf)
    assert (stuck.sensor, stuck.share) == ("driven_speed", 1.0)
    assert (spike.begin, spike.end, spike.value, spike.share) == (2.0, 2.0, 50.0, 1.0)
    assert (dropout.begin, dropout.end, dropout.sensor, dropout.share) == (3.0, 5.0, "all", 0.5)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({}, ["duration is missing"]),
        ({"duration": -1.0}, ["duration is -1 s", "between 0.01"]),
        ({"duration": "long"}, ["duration is 'long'", "number"]),
        ({"sample_rate": 1e6}, ["sample_rate is 1e+06 Hz", "10000"]),
        ({"duration": 1e6, "sample_rate": 1e4}, ["samples"]),
        ({"seed": 1.5}, ["seed is 1.5", "whole"]),
        ({"spede": 1.0}, ["unknown entry spede", "did you mean speed"]),
        ({"condition.tensoin": 1.0}, ["did you mean condition.tension"]),
        ({"condition.tension": -5.0}, ["condition.tension is -5 N", "0.001"]),
        ({"speed": []}, ["speed has 0 points"]),
        ({"speed": [[0.0, 1.0], [0.0]]}, ["speed[1] is [0.0]"]),
        ({"speed": [[2.0, 1.0], [1.0, 1.0]]}, ["time of speed[1] is 1 s", "2 s"]),
        ({"speed": [[99.0, 1.0]]}, ["time of speed[0] is 99 s", "10"]),
        ({"load": [[0.0, float("nan")]]}, ["value of load[0] is nan"]),
        ({"load_direction": "up"}, ["load_direction is 'up'", "fixed"]),
        ({"sensors.speed_relative": 2.0}, ["sensors.speed_relative is 2", "0 and 1"]),
        ({"events": 5}, ["events must be a list"]),
        ({"events": [5]}, ["events[0] is 5", "{at, <quantity>, over}"]),
        ({"events": [{"at": 1.0}]}, ["events[0] must set exactly one of speed, load, tension"]),
        ({"events": [{"at": 1.0, "load": 1.0, "tension": 1.0}]}, ["exactly one"]),
        ({"events": [{"load": 1.0}]}, ["events[0]", "at is missing"]),
        ({"events": [{"at": 11.0, "load": 1.0}]}, ["events[0]", "at is 11 s", "10"]),
        ({"events": [{"at": 1.0, "load": 1.0, "ower": 2.0}]}, ["unknown entry ower"]),
        ({"events": [{"at": 1.0, "tension": 0.0}]}, ["tension of events[0] is 0 N"]),
        (
            {"load": [[0.0, 0.0], [5.0, 9.0]], "events": [{"at": 1.0, "load": 1.0}]},
            ["event of load at 1 s", "last point of load, at 5 s"],
        ),
        ({"faults": "stuck"}, ["faults must be a list"]),
        ({"faults": ["stuck"]}, ["faults[0] is 'stuck'", "{at, kind, sensor"]),
        ({"faults": [{"at": 1.0}]}, ["faults[0]: kind is missing", "dropout, stuck"]),
        ({"faults": [{"kind": "stuck"}]}, ["faults[0]: at is missing", "[s]"]),
        ({"faults": [{"at": 11.0, "kind": "stuck"}]}, ["faults[0]: at is 11 s", "10"]),
        ({"faults": [{"at": 1.0, "kind": "stuk"}]}, ["kind is 'stuk'", "stuck, spike"]),
        (
            {"faults": [{"at": 1.0, "kind": "stuck", "sensor": "motor"}]},
            ["faults[0]: sensor is 'motor'", "driver_speed"],
        ),
        (
            {"faults": [{"at": 1.0, "kind": "quantised", "value": 1.0}]},
            ["sensor is 'all'; quantised takes driver_position"],
        ),
        (
            {"faults": [{"at": 1.0, "kind": "reordered", "sensor": "driver_speed"}]},
            ["sensor is 'driver_speed'; reordered takes all"],
        ),
        (
            {"faults": [{"at": 1.0, "kind": "delayed"}]},
            ["faults[0]: value is missing: by how much, [s]"],
        ),
        (
            {"faults": [{"at": 1.0, "kind": "delayed", "value": -1.0}]},
            ["value is -1 s", "between 1e-09"],
        ),
        (
            {"faults": [{"at": 1.0, "kind": "time_jump", "value": 1e7}]},
            ["value is 1e+07 s", "-1e+06 and 1e+06"],
        ),
        (
            {"faults": [{"at": 1.0, "kind": "dropout", "share": 2.0}]},
            ["share is 2", "0 and 1"],
        ),
        (
            {"faults": [{"at": 1.0, "kind": "stuck", "value": 1.0}]},
            ["faults[0] has an unknown entry value"],
        ),
        ({"speed": 1000.0}, ["lifts off", "81.25 m/s", "435 N"]),
    ],
)
def test_what_cannot_run_is_refused_by_name_value_and_limit(
    settings: DriveSettings, values: dict[str, object], words: list[str]
) -> None:
    given = values if values == {} else {"duration": 10.0, **values}
    with pytest.raises(ValueError, match=r".") as raised:
        scenario_from_mapping(given, settings)
    for word in words:
        assert word in str(raised.value)


def test_error_in_a_file_names_the_file(tmp_path: Path, settings: DriveSettings) -> None:
    path = tmp_path / "run.yaml"
    with pytest.raises(ScenarioError, match=r"run\.yaml: No such file"):
        load_scenario(path, settings)
    path.write_text("duration: [")
    with pytest.raises(ScenarioError, match=r"run\.yaml is no valid YAML"):
        load_scenario(path, settings)
    path.write_text("duration: 0")
    with pytest.raises(ScenarioError, match=r"run\.yaml: duration is 0 s"):
        load_scenario(path, settings)
    path.write_text("duration: 5\nevents:\n  - {at: 1.0, load: 5.0, load: 9.0}\n")
    with pytest.raises(ScenarioError, match=r"run\.yaml .*load is given in line 3 and again"):
        load_scenario(path, settings)


def test_demonstration_loses_tension_slips_and_recovers(root: Path) -> None:
    settings = load_settings(root / "config" / "demo_drive.yaml")
    scenario = load_scenario(root / "config" / "scenarios" / "demo.yaml", settings)
    truth = {sample.stamp_ns / 1e9: sample.truth for sample in simulate(settings, scenario)}

    def margins(start: float, end: float) -> list[float]:
        return [value.margin for time, value in truth.items() if start <= time <= end]

    assert min(margins(0.0, 10.5)) > 0.25
    assert 0.02 < min(margins(11.6, 14.4)) < 0.15
    assert min(margins(15.6, 18.4)) > 0.15
    assert all(truth[time].phase is Phase.GROSS_SLIP for time in (19.0, 19.5, 19.9))
    assert truth[19.9].slip > 0.2
    assert min(margins(20.4, 23.0)) > 0.5
    assert truth[23.0].phase is Phase.STANDSTILL
