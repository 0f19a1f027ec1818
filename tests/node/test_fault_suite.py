"""A slice of the fault suite: the node, the rig and a recorder over real DDS, a domain each."""

from functools import cache

import pytest

from belt_ros.estimation import Condition, Rejection
from benchmarks.faults.cases import SLIP, TRACTION, Case, Right, demo_script, there_and_back
from benchmarks.faults.judge import Verdict, judged
from benchmarks.faults.run import play
from benchmarks.faults.timeline import timeline

pytestmark = pytest.mark.ros

BEGIN, END, DURATION = 3.5, 4.7, 8.0  # [s]
LOAD = [[2.0, 0.0], [2.2, 30.0]]
IMPLAUSIBLE, STALE = (
    frozenset({Condition.SENSOR_IMPLAUSIBLE, Condition.ESTIMATOR_LOST}),
    frozenset({Condition.SENSOR_STALE}),
)


def of_sensor(name: str, right: Right, kind: str, sensor: str = "all", **more: float) -> Case:
    fault = {"kind": kind, "sensor": sensor, "at": BEGIN, "duration": END - BEGIN, **more}
    script = demo_script(LOAD, duration=DURATION, faults=[fault])
    return Case(name, "", script, right, BEGIN, END)


CASES = (
    Case(
        "overload",
        "",
        demo_script(
            LOAD,
            duration=DURATION,
            events=there_and_back("load", 72.0, 15.0, begin=BEGIN, end=END),
        ),
        Right("", frozenset({Condition.GROSS_SLIP}), 0.9, SLIP | TRACTION),
        BEGIN,
        END,
    ),
    of_sensor("dropout", Right("", STALE, 1.5), "dropout"),
    of_sensor("wrong_sign", Right("", IMPLAUSIBLE, 1.0), "wrong_sign", "driven_speed"),
    of_sensor(
        "spike",
        Right("", counted=Rejection.GATED),
        "spike",
        "driven_speed",
        value=60.0,
        duration=0.0,
    ),
)
BY_NAME = {case.name: case for case in CASES}
# Each plays at real speed, once: all that is asked of a module is asked by one worker.
NAMES = list(BY_NAME)


@cache
def verdict(name: str) -> Verdict:
    case = BY_NAME[name]
    record = play(case)
    return judged(case, record, timeline(case, record))


@pytest.mark.parametrize("name", NAMES)
def test_a_fault_is_told_in_time_or_counted_where_silence_is_right(name: str) -> None:
    assert verdict(name).detected, verdict(name)


@pytest.mark.parametrize("name", NAMES)
def test_no_other_alarm_is_raised(name: str) -> None:
    assert verdict(name).right, verdict(name)


@pytest.mark.parametrize("name", NAMES)
def test_alarms_clear_when_the_cause_is_gone(name: str) -> None:
    assert verdict(name).cleared, verdict(name)


@pytest.mark.parametrize("name", NAMES)
def test_alarms_are_latched_until_acknowledged(name: str) -> None:
    assert verdict(name).latched, verdict(name)


@pytest.mark.parametrize("name", NAMES)
def test_every_number_published_is_finite(name: str) -> None:
    assert verdict(name).finite, verdict(name)


@pytest.mark.parametrize("name", NAMES)
def test_the_node_is_alive_and_says_states_at_the_end(name: str) -> None:
    assert verdict(name).alive, verdict(name)
