"""A run takes faults from its script and by request, and without any it is as it was."""

import contextlib
import dataclasses
import itertools
from collections.abc import Iterator
from pathlib import Path

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from belt_ros.parameter_table import SettingsError
from belt_ros.rig import JointSample, RigSample, load_scenario, measured, simulate
from belt_ros.rig.entries import QUANTITIES
from belt_ros.rig.faults import PLACES, FaultKind
from belt_ros.rig.running import RunningScenario
from belt_ros.rig.scenario import Scenario, scenario_from_mapping
from belt_ros.settings import DriveSettings, load_settings

ROOT = Path(__file__).resolve().parents[2]
SCRIPT: dict[str, object] = {"duration": 1.0, "speed": 100.0, "load": 20.0, "seed": 3}
START_NS = 10**18


@pytest.fixture
def scenario(settings: DriveSettings) -> Scenario:
    return scenario_from_mapping(SCRIPT, settings)


@pytest.fixture
def running(scenario: Scenario, settings: DriveSettings) -> RunningScenario:
    return RunningScenario(scenario, settings)


@pytest.fixture
def samples(
    running: RunningScenario, scenario: Scenario, settings: DriveSettings
) -> Iterator[RigSample]:
    return simulate(settings, scenario, START_NS, running)


def advance(samples: Iterator[RigSample], count: int) -> list[RigSample]:
    return list(itertools.islice(samples, count))


def test_faults_leave_plant_and_noise_as_they_are(settings: DriveSettings) -> None:
    faults = [
        {"at": 0.2, "kind": "dropout", "share": 0.5},
        {"at": 0.3, "kind": "spike", "sensor": "driver_speed", "value": 5.0},
    ]
    plain, faulty = (
        list(simulate(settings, scenario_from_mapping(values, settings)))
        for values in (SCRIPT, {**SCRIPT, "faults": faults})
    )
    assert [sample[:3] for sample in plain] == [sample[:3] for sample in faulty]
    assert all(sample.published == ((sample.stamp_ns, sample.joints),) for sample in plain)
    assert sum(len(sample.published) for sample in faulty) < 75


def test_measurements_come_as_faults_leave_them(settings: DriveSettings) -> None:
    faults = [
        {"at": 0.2, "kind": "dropout", "duration": 0.1},
        {"at": 0.5, "kind": "dropout", "sensor": "driven_torque", "duration": 0.1},
    ]
    script = scenario_from_mapping({**SCRIPT, "faults": faults}, settings)
    rows = [measurement for measurement, _ in measured(settings, script, loads=True)]
    assert len(rows) == 91
    missing = [m.stamp_ns for m in rows if np.isnan(m.driven_torque)]
    assert missing == [10_000_000 * number for number in range(50, 60)]
    assert not any(np.isnan(m.driver_torque + m.span_tension) for m in rows)


def test_tension_is_lost_on_request_until_cleared(
    samples: Iterator[RigSample], running: RunningScenario
) -> None:
    advance(samples, 20)
    running.request("tension=300 over=0.1")
    ramp = [sample.truth.mean_tension for sample in advance(samples, 30)]
    np.testing.assert_allclose(ramp[:2], [435.0 - 13.5, 435.0 - 27.0], rtol=1e-6)
    np.testing.assert_allclose(ramp[10:], 300.0, rtol=1e-6)

    assert running.clear() == ("tension",)
    assert advance(samples, 1)[0].truth.mean_tension == pytest.approx(435.0)
    assert running.clear() == ()


def test_contamination_and_overload_on_request_cost_margin(
    samples: Iterator[RigSample], running: RunningScenario
) -> None:
    before = advance(samples, 10)[-1].truth.margin
    running.request("friction_coefficient=0.7")
    contaminated = advance(samples, 20)[-1].truth.margin
    running.request("load=75 over=0.1")
    overloaded = advance(samples, 40)[-1].truth
    assert before > contaminated + 0.05
    assert overloaded.gross_slip


def test_sensor_fault_on_request_begins_at_once_and_ends_in_time(
    samples: Iterator[RigSample], running: RunningScenario
) -> None:
    advance(samples, 20)
    running.request("wrong_sign driven_speed duration=0.1")
    signs = [np.sign(sample.published[0].joints.velocities[1]) for sample in advance(samples, 20)]
    assert signs == [-1.0] * 9 + [1.0] * 11


def test_fault_on_request_without_duration_lasts_until_cleared(
    samples: Iterator[RigSample], running: RunningScenario
) -> None:
    running.request("dropout")  # before the start, so from the start
    assert all(sample.published == () for sample in advance(samples, 50))
    assert running.clear() == ("dropout all",)
    assert all(len(sample.published) == 1 for sample in advance(samples, 10))


def test_requests_outlast_a_repetition_and_scripted_faults_do_not(settings: DriveSettings) -> None:
    faults = [{"at": 0.5, "kind": "wrong_sign", "sensor": "driver_speed"}]
    script = scenario_from_mapping({**SCRIPT, "duration": 0.9, "faults": faults}, settings)
    running = RunningScenario(script, settings)
    first = simulate(settings, script, START_NS, running)
    advance(first, 20)
    running.request("stuck driven_torque")
    running.request("tension=300")
    list(first)
    second = list(simulate(settings, script, START_NS + 910_000_000, running))

    (begin,), (end,) = second[0].published, second[-1].published
    assert second[0].truth.mean_tension == pytest.approx(300.0)
    assert (begin.joints.velocities[0] > 0.0, end.joints.velocities[0] > 0.0) == (True, False)
    assert begin.joints.efforts[1] == end.joints.efforts[1]


def test_change_on_request_may_take_longer_than_the_script_that_is_repeated(
    settings: DriveSettings,
) -> None:
    script = scenario_from_mapping({**SCRIPT, "duration": 0.49}, settings)  # 0.5 s with a sample
    running = RunningScenario(script, settings)
    first = simulate(settings, script, START_NS, running)
    advance(first, 1)
    running.request("tension=315 over=1.2")
    samples = list(first)
    for begin in (500_000_000, 1_000_000_000):
        samples += simulate(settings, script, START_NS + begin, running)

    tensions = [sample.truth.mean_tension for sample in samples]
    times = 0.01 + 0.01 * np.arange(len(tensions))  # since the request
    np.testing.assert_allclose(tensions, 435.0 - 100.0 * np.minimum(times, 1.2), rtol=1e-9)
    assert running.clear() == ("tension",)


def test_event_under_which_the_script_cannot_begin_again_ends(settings: DriveSettings) -> None:
    script = scenario_from_mapping(
        {"duration": 0.5, "speed": [[0.0, 300.0], [0.2, 300.0], [0.3, 10.0]]}, settings
    )
    running = RunningScenario(script, settings)
    first = simulate(settings, script, 0, running)
    advance(first, 40)
    running.request("tension=50")
    assert list(first)[-1].truth.mean_tension == pytest.approx(50.0)
    again = next(simulate(settings, script, 510_000_000, running))
    assert again.truth.mean_tension == pytest.approx(435.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("broken", ["the fault", "kind is 'broken'", "dropout, stuck, spike"]),
        ("5", ["kind is '5'"]),
        ("stuck driven", ["sensor is 'driven'", "driven_speed"]),
        ("stuck driven_speed 5", ["5 has no name", "duration=5"]),
        ("stuck driven_speed duration=-1", ["duration is -1 s", "between 0 and inf"]),
        ("stuck duration=nan", ["duration is nan"]),
        ("spike driven_speed", ["value is missing: what is added"]),
        ("stuck at=3", ["at cannot be given", "at once"]),
        ("stuck kind=spike", ["kind cannot be given", "already"]),
        ("tension=0", ["tension of the event is 0 N", "0.001"]),
        ("tension=300 mu=0.3", ["the event has an unknown entry mu"]),
        ("over=3", ["the event must set exactly one of speed, load, tension"]),
        ("tension=100 load=3", ["exactly one"]),
        ("speed=1000", ["lifts off", "81.25 m/s"]),
        ("   ", ["exactly one"]),
        ("x" * 201, ["201 characters", "200"]),
    ],
)
def test_request_that_cannot_be_met_is_refused_and_changes_nothing(
    running: RunningScenario, scenario: Scenario, text: str, words: list[str]
) -> None:
    running.start(0)
    with pytest.raises(ValueError, match=r".") as raised:
        running.request(text)
    for word in words:
        assert word in str(raised.value)
    times = np.linspace(0.0, 1.0, 5)
    np.testing.assert_array_equal(running.commands(times), scenario.commands(times))
    assert running.clear() == ()


WORDS = st.one_of(
    st.sampled_from([*PLACES, *(kind.value for kind in FaultKind), "", "=", "at=1", "over=1"]),
    st.builds(
        "{}={}".format,
        st.sampled_from(["kind", "sensor", "value", "duration", "share", "over", *QUANTITIES]),
        st.one_of(st.floats(), st.text(max_size=5), st.sampled_from(list(PLACES))),
    ),
    st.text(max_size=20),
)


@hypothesis.settings(max_examples=300, deadline=None, derandomize=True)
@hypothesis.given(st.lists(WORDS, max_size=6).map(" ".join))
def test_no_text_does_more_than_be_refused(text: str) -> None:
    drive = load_settings(ROOT / "config" / "paper_drive.yaml")
    running = RunningScenario(scenario_from_mapping(SCRIPT, drive), drive)
    running.start(0)
    with contextlib.suppress(SettingsError):
        running.request(text)
    for number in range(3):
        commands = running.commands(np.array([number * 0.01]))
        assert np.all(np.isfinite(commands))
        running.reports(number * 10_000_000, JointSample(("a", "b"), (1, 2), (3, 4), (5, 6)))


def test_requests_without_end_are_refused_at_a_limit(running: RunningScenario) -> None:
    for _ in range(100):
        running.request("stuck")
    with pytest.raises(ValueError, match="100 were asked for already; clear them first"):
        running.request("tension=300")


def test_scenario_of_faults_runs_and_names_every_kind() -> None:
    drive = load_settings(ROOT / "config" / "demo_drive.yaml")
    script = load_scenario(ROOT / "config" / "scenarios" / "faults.yaml", drive)
    assert {fault.kind.value for fault in script.faults} == {
        *("dropout", "stuck", "spike", "quantised", "delayed", "reordered"),
        *("time_jump", "wrong_sign"),
    }
    short = dataclasses.replace(script, duration=5.0)
    assert sum(len(sample.published) for sample in simulate(drive, short)) == 501
