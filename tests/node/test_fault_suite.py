"""A slice of the fault suite: the node, the rig and a recorder over real DDS, a domain each."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from belt_ros.estimation import Condition, Rejection
from benchmarks.faults.cases import SLIP, TRACTION, Case, Right, demo_script, there_and_back
from benchmarks.faults.judge import Verdict, judged
from benchmarks.faults.run import play
from benchmarks.faults.timeline import timeline

pytestmark = [pytest.mark.ros, pytest.mark.long, pytest.mark.xdist_group("fault_suite")]

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
NAMES = [case.name for case in CASES]


def verdict(case: Case) -> Verdict:
    record = play(case)
    return judged(case, record, timeline(case, record))


@pytest.fixture(scope="module")
def verdicts() -> dict[str, Verdict]:
    with ThreadPoolExecutor(2) as pool:
        return dict(zip(NAMES, pool.map(verdict, CASES), strict=True))


@pytest.mark.parametrize("name", NAMES)
def test_a_fault_is_told_in_time_or_counted_where_silence_is_right(verdicts, name: str) -> None:
    assert verdicts[name].detected, verdicts[name]


@pytest.mark.parametrize("name", NAMES)
def test_no_other_alarm_is_raised(verdicts, name: str) -> None:
    assert verdicts[name].right, verdicts[name]


@pytest.mark.parametrize("name", NAMES)
def test_alarms_clear_when_the_cause_is_gone(verdicts, name: str) -> None:
    assert verdicts[name].cleared, verdicts[name]


@pytest.mark.parametrize("name", NAMES)
def test_alarms_are_latched_until_acknowledged(verdicts, name: str) -> None:
    assert verdicts[name].latched, verdicts[name]


@pytest.mark.parametrize("name", NAMES)
def test_every_number_published_is_finite(verdicts, name: str) -> None:
    assert verdicts[name].finite, verdicts[name]


@pytest.mark.parametrize("name", NAMES)
def test_the_node_is_alive_and_says_states_at_the_end(verdicts, name: str) -> None:
    assert verdicts[name].alive, verdicts[name]
