"""A running node over DDS: every measurement gives one state, whatever comes between."""

import itertools
import math
import time
from collections.abc import Iterator
from typing import Any

import pytest
from belt_msgs.msg import BeltState, SlipAlarm
from diagnostic_msgs.msg import DiagnosticStatus
from node_harness import (
    MILLISECOND,
    NAMES,
    SECOND,
    Client,
    NodeProcess,
    joint_state,
    not_finite,
    ns,
)

pytestmark = pytest.mark.ros
NAN = math.nan


@pytest.fixture(scope="module")
def node(module_ros_domain: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[NodeProcess]:
    log = tmp_path_factory.mktemp("node") / "log"
    with NodeProcess(module_ros_domain, log, input_reliability="reliable") as node:
        yield node


@pytest.fixture(scope="module")
def connected(node: NodeProcess, module_ros_domain: int) -> Iterator[Client]:
    client = Client(module_ros_domain)
    node.wait_for_log("active, listening on /joint_states")
    client.connect()
    yield client
    client.close()


@pytest.fixture
def client(connected: Client) -> Client:
    """The client of a node that has just been reset and follows its drive."""
    assert connected.trigger("reset").success
    connected.now_ns = max(connected.now_ns, time.time_ns())
    connected.next_state()
    connected.states.clear()
    return connected


def test_every_measurement_gives_one_state_with_its_stamp(client: Client) -> None:
    client.diagnostics.clear()
    stamps = client.drive(300)
    client.until(lambda: len(client.states) >= len(stamps))

    assert [ns(state.header.stamp) for state in client.states] == stamps
    assert [name for state in client.states for name in not_finite(state)] == []
    last = client.states[-1]
    assert last.phase == BeltState.PHASE_RUNNING
    assert last.slip == pytest.approx(1.0 - 119.4 / 120.0, abs=1e-3)
    assert last.transmitted_torque == pytest.approx(30.0, rel=0.1)
    assert last.drive_name == "paper_drive"
    assert last.header.frame_id == ""
    assert sum(last.rejection_counts) == 0

    arrivals = [when for when, message in client.diagnostics if len(message.status) == 3]
    assert len(arrivals) in (2, 3, 4)
    assert all(0.5 < b - a < 1.5 for a, b in itertools.pairwise(arrivals))
    assert {row.level for row in client.rows(": paper_drive")} == {DiagnosticStatus.OK}
    values = {pair.key: float(pair.value) for pair in client.rows(" input")[-1].values}
    assert values["latency mean [ms]"] < 1000.0


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"velocity": (NAN, NAN), "effort": (NAN, NAN)}, BeltState.REJECTION_NOT_FINITE),
        ({"velocity": (120.0, math.inf)}, BeltState.REJECTION_NOT_FINITE),
        ({"effort": (-math.inf, -30.0)}, BeltState.REJECTION_NOT_FINITE),
        ({"velocity": (2e4, 119.4)}, BeltState.REJECTION_OUT_OF_RANGE),
        ({"name": ("elbow", NAMES[1])}, BeltState.REJECTION_INCOMPLETE),
        ({"velocity": ()}, BeltState.REJECTION_INCOMPLETE),
        ({"name": (), "velocity": (), "effort": ()}, BeltState.REJECTION_MALFORMED),
        ({"velocity": (120.0,)}, BeltState.REJECTION_MALFORMED),
        ({"effort": (30.0, -30.0, 0.0)}, BeltState.REJECTION_MALFORMED),
        (
            {"name": ("joint",) * 1001, "velocity": (0.0,) * 1001, "effort": ()},
            BeltState.REJECTION_MALFORMED,
        ),
    ],
)
def test_what_cannot_be_used_is_counted_by_reason(
    client: Client, fields: dict[str, Any], reason: int
) -> None:
    client.send(**fields)
    state = client.next_state()

    assert len(client.states) == 1
    assert state.last_rejection == reason
    assert state.rejection_counts[reason] == 1
    assert sum(state.rejection_counts) == 1
    assert not_finite(state) == []


def test_joint_states_of_others_on_the_same_topic_are_left_alone(client: Client) -> None:
    for _ in range(5):
        client.send(name=("elbow", "wrist"))
    state = client.next_state()

    assert len(client.states) == 1
    assert sum(state.rejection_counts) == 0


def test_what_is_not_measured_is_no_reason_to_reject(client: Client) -> None:
    state = client.next_state(effort=(NAN, -30.0))
    state = client.next_state(effort=())
    state = client.next_state(velocity=(NAN, 119.4))

    assert sum(state.rejection_counts) == 0
    assert not_finite(state) == []


def test_stamps_that_do_not_go_on_are_counted(client: Client) -> None:
    client.send_raw(joint_state(client.now_ns))
    client.send_raw(joint_state(client.now_ns - 5 * MILLISECOND))
    state = client.next_state()

    assert state.rejection_counts[BeltState.REJECTION_OUT_OF_ORDER] == 2
    assert state.reset_count == client.states[0].reset_count


def test_rejections_are_logged_once_with_advice_and_told_in_diagnostics(
    client: Client, node: NodeProcess
) -> None:
    for _ in range(20):
        client.send(velocity=(NAN, NAN), effort=(NAN, NAN))
    row = client.row(" input")

    assert row.level in (DiagnosticStatus.WARN, DiagnosticStatus.ERROR)
    assert "not finite" in row.message
    assert node.log.count("measurement rejected from /joint_states, not finite: ") == 1


def test_messages_that_never_come_are_missed_by_the_stamps_of_the_others(client: Client) -> None:
    for _ in range(30):
        client.drive(9)
        client.now_ns += client.step_ns  # the tenth
        client.spin(client.step_ns / SECOND)
    before, last = (
        {pair.key: float(pair.value) for pair in row.values} for row in client.rows(" input")[-2:]
    )
    came = last["accepted"] - before["accepted"]
    assert last["missing messages in period"] == pytest.approx(came / 9.0, abs=2.0)


def test_reset_starts_anew(client: Client) -> None:
    before = client.next_state()
    response = client.trigger("reset")
    state = client.next_state()

    assert response.success
    assert state.reset_count == before.reset_count + 1
    assert state.accepted_count == 1


def test_silence_is_noticed(client: Client) -> None:
    client.spin(1.2)
    drive, source = client.row(": paper_drive"), client.row(" input")

    assert drive.level == source.level == DiagnosticStatus.STALE
    assert "/joint_states" in source.message


def test_an_alarm_is_told_at_once_latched_and_acknowledged(client: Client) -> None:
    client.drive(50)
    client.alarms.clear()
    client.diagnostics.clear()
    while not any(alarm.severity >= SlipAlarm.SEVERITY_ALARM for alarm in client.alarms):
        assert len(client.states) < 1000
        client.drive(1, velocity=(120.0, 80.0), effort=(30.0, -30.0))
    raised = time.monotonic()
    client.until(
        lambda: any(message.status[0].level == b"\x02" for _, message in client.diagnostics)
    )
    assert time.monotonic() - raised < 0.5

    late: list[SlipAlarm] = []
    client.listen_for_alarms(late)
    client.until(lambda: bool(late))
    assert late[0].active
    assert late[0].severity >= SlipAlarm.SEVERITY_ALARM
    assert late[0].drive_name == "paper_drive"
    assert late[0].message
    assert not late[0].acknowledged

    late.clear()
    response = client.trigger("acknowledge")
    client.until(lambda: bool(late))
    assert response.success
    assert late[-1].acknowledged


def test_a_reset_takes_the_alarm_back(client: Client) -> None:
    client.until(lambda: client.alarms[-1].severity == SlipAlarm.SEVERITY_NORMAL)

    assert client.alarms[-1].acknowledged
    assert client.alarms[-1].latched_severity == SlipAlarm.SEVERITY_NORMAL


def test_parameters_change_while_running_or_are_refused_with_the_reason(client: Client) -> None:
    assert client.set_parameter("limits.greatest_speed", 50) == (True, "")
    client.send()
    client.send(velocity=(40.0, 39.8))
    assert client.set_parameter("limits.greatest_speed", 1e4) == (True, "")
    state = client.next_state()
    assert state.rejection_counts[BeltState.REJECTION_OUT_OF_RANGE] == 1

    accepted, reason = client.set_parameter("alarm.confidence", 2)
    assert not accepted
    assert reason == "alarm.confidence is 2 -; it must lie between 0.5 and 0.9999"
    accepted, reason = client.set_parameter("driver.radius", 0.1)
    assert not accepted
    assert "read-only" in reason
    assert not client.set_parameter("alarm.confidence", None)[0]
    assert client.get_parameter("driver.radius").double_value == 0.08125
    descriptor = client.describe_parameter("driver.radius")
    assert "[m]" in descriptor.description
    assert descriptor.floating_point_range[0].to_value == 100.0


def test_the_node_has_lived_through_all_this(client: Client, node: NodeProcess) -> None:
    assert node.alive
    assert "Traceback" not in node.log
