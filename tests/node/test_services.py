"""Services of a running node: maintenance is taken in, the ratio calibrated, nonsense refused."""

import math
import time
from collections.abc import Iterator

import numpy as np
import pytest
from belt_msgs.srv import RecordMaintenance
from diagnostic_msgs.msg import DiagnosticStatus
from node_harness import MILLISECOND, Client, NodeProcess

from belt_ros.estimation import MaintenanceKind

pytestmark = pytest.mark.ros
NAN = math.nan
RE_TENSIONED = RecordMaintenance.Request.RE_TENSIONED
BELT_REPLACED = RecordMaintenance.Request.BELT_REPLACED
MEASURED_TENSION = RecordMaintenance.Request.MEASURED_TENSION
PRIOR_SPREAD = 60.0  # [N]
RATIO_BIAS = 3e-4


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
    connected.step_ns = 10 * MILLISECOND
    assert connected.trigger("reset").success
    connected.now_ns = max(connected.now_ns, time.time_ns())
    connected.next_state()
    connected.states.clear()
    return connected


def test_its_actions_are_those_of_the_estimator() -> None:
    assert RE_TENSIONED == MaintenanceKind.RETENSIONED
    assert BELT_REPLACED == MaintenanceKind.BELT_REPLACED
    assert MEASURED_TENSION == MaintenanceKind.TENSION_MEASURED


def test_a_new_tension_stands_in_the_next_state(client: Client, node: NodeProcess) -> None:
    response = client.record_maintenance(
        RE_TENSIONED, value=500.0, value_stddev=10.0, drive_name="paper_drive", note="night\nshift"
    )
    state = client.next_state()

    assert response.success
    assert "re-tensioned from " in response.message
    assert "to 500 +/- 10 N" in response.message
    assert state.mean_tension == pytest.approx(500.0, abs=5.0)
    assert state.mean_tension_stddev == pytest.approx(10.0, abs=3.0)
    assert state.reset_count == client.states[0].reset_count
    assert "(note: 'night\\nshift')" in node.log


def test_a_measured_tension_is_weighed_with_what_was_known(client: Client) -> None:
    response = client.record_maintenance(MEASURED_TENSION, value=400.0, value_stddev=8.0)
    state = client.next_state()

    assert response.success
    assert state.mean_tension == pytest.approx(400.0, abs=8.0)
    assert state.mean_tension_stddev < 0.2 * PRIOR_SPREAD


def test_a_new_belt_is_at_its_priors(client: Client) -> None:
    client.record_maintenance(MEASURED_TENSION, value=400.0, value_stddev=8.0)
    response = client.record_maintenance(BELT_REPLACED, value=NAN, value_stddev=NAN)
    state = client.next_state()

    assert response.success
    assert state.mean_tension_stddev == pytest.approx(PRIOR_SPREAD, rel=0.1)


def test_what_a_request_leaves_out_is_not_known(client: Client) -> None:
    """As it is typed: ros2 service call ... {action: 2}."""
    client.record_maintenance(MEASURED_TENSION, value=400.0, value_stddev=8.0)
    assert client.record_maintenance(BELT_REPLACED).success
    assert client.next_state().mean_tension_stddev == pytest.approx(PRIOR_SPREAD, rel=0.1)
    assert client.record_maintenance(RE_TENSIONED, value=410.0).success
    assert client.next_state().mean_tension == pytest.approx(410.0, rel=0.1)


@pytest.mark.parametrize(
    ("action", "fields", "reason"),
    [
        (0, {}, "action 0 is unknown; 1 retensioned, 2 belt replaced, 3 tension measured"),
        (255, {}, "action 255 is unknown"),
        (RE_TENSIONED, {"value": NAN, "value_stddev": NAN}, "give it in N"),
        (MEASURED_TENSION, {"value": 400.0, "value_stddev": NAN}, "standard deviation; it is"),
        (MEASURED_TENSION, {"value": math.inf, "value_stddev": 1.0}, "the tension is inf N"),
        (RE_TENSIONED, {"value": -400.0, "value_stddev": 4.0}, "the tension is -400 N"),
        (RE_TENSIONED, {}, "give it in N"),
        (RE_TENSIONED, {"value": 400.0, "value_stddev": 0.001}, "the standard deviation is 0.001"),
        (MEASURED_TENSION, {"value": 400.0}, "standard deviation; it is"),
        (BELT_REPLACED, {"value": NAN, "value_stddev": 4.0}, "needs its tension"),
        (BELT_REPLACED, {"drive_name": "\N{GREEK SMALL LETTER OMEGA}"}, "only 'paper_drive'"),
    ],
)
def test_what_cannot_be_is_refused_with_the_reason_and_changes_nothing(
    client: Client, action: int, fields: dict[str, float], reason: str
) -> None:
    before = client.next_state()
    response = client.record_maintenance(action, **fields)
    after = client.next_state()

    assert not response.success
    assert reason in response.message
    assert after.mean_tension_stddev == pytest.approx(before.mean_tension_stddev, rel=1e-3)
    assert after.reset_count == before.reset_count


def turn(client: Client, count: int, torque: float, rng: np.random.Generator) -> None:
    """Publish what the sensors of a turning drive say, as fast as the node follows."""
    driver = 120.0 * (1.0 + RATIO_BIAS)
    for k in range(count):
        noise = rng.normal(size=4)
        sent = client.send(
            velocity=(driver + 0.013 * noise[0], 120.0 + 0.013 * noise[1]),
            effort=(torque + 0.3 * noise[2], -torque + 0.3 * noise[3]),
        )
        if k % 20 == 19:
            client.until(lambda sent=sent: client.last_stamp() == sent)


def test_the_ratio_is_calibrated_without_load(client: Client, node: NodeProcess) -> None:
    rng = np.random.default_rng(8)
    turn(client, 100, 0.0, rng)
    response = client.trigger("calibrate")
    assert response.success
    assert "without load for about 5 s" in response.message
    row = client.row(" calibration")
    assert (row.level, row.values[0].key, row.values[0].value) == (b"\0", "running", "1")

    before = len(client.diagnostics)
    turn(client, 800, 0.0, rng)
    client.until(lambda: client.rows(" calibration", before)[-1].values[0].value == "0")
    row = client.rows(" calibration")[-1]
    values = {pair.key: float(pair.value) for pair in row.values}
    assert row.level == DiagnosticStatus.OK
    assert abs(values["ratio bias [-]"] - RATIO_BIAS) < 3.0 * values["ratio bias stddev [-]"]
    assert values["ratio bias stddev [-]"] <= 5e-5
    assert abs(values["driver torque at no load [N m]"]) < 0.1
    assert node.log.count("ratio bias is ") == 1
    assert client.next_state().ratio_bias == pytest.approx(RATIO_BIAS, abs=1e-4)


def test_a_calibration_under_load_is_given_up_with_the_reason(
    client: Client, node: NodeProcess
) -> None:
    assert client.trigger("calibrate").success
    client.step_ns = 500 * MILLISECOND
    turn(client, 80, 30.0, np.random.default_rng(8))
    client.until(lambda: client.rows(" calibration")[-1].level == DiagnosticStatus.WARN)

    assert "the drive is loaded" in client.rows(" calibration")[-1].message
    assert "ratio not calibrated: " in node.log


def test_a_calibration_does_not_outlive_a_reset(client: Client) -> None:
    """A row that was sent before the reset may come after its answer, being of another topic."""
    assert client.trigger("calibrate").success
    assert client.row(" calibration").values[0].value == "1"
    assert client.trigger("reset").success
    client.until(lambda: client.rows(" calibration")[-1].values[0].value == "0")

    row = client.rows(" calibration")[-1]
    assert row.level == DiagnosticStatus.WARN
    assert row.message == "ratio not calibrated: the estimate was started anew"


def test_a_calibration_needs_an_estimate_to_begin_with(client: Client) -> None:
    assert client.trigger("reset").success
    response = client.trigger("calibrate")

    assert not response.success
    assert response.message.startswith("no estimate yet")


def test_the_node_has_lived_through_all_this(client: Client, node: NodeProcess) -> None:
    assert node.alive
    assert "Traceback" not in node.log
