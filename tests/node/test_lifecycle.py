"""The node's lifecycle, as an orchestrator drives it."""

from pathlib import Path

import pytest
from belt_msgs.msg import SlipAlarm
from diagnostic_msgs.msg import DiagnosticStatus
from node_harness import (
    ACTIVATE,
    CLEANUP,
    CONFIGURE,
    DEACTIVATE,
    PAPER_DRIVE,
    Client,
    NodeProcess,
)

pytestmark = pytest.mark.ros


def test_every_transition_does_what_it_says(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    with NodeProcess(ros_domain, tmp_path / "log", autostart="false") as node:
        assert client.lifecycle_state() == "unconfigured"
        assert not client.trigger("reset").success

        assert client.transition(CONFIGURE)
        assert client.lifecycle_state() == "inactive"
        client.drive(20)
        assert client.states == client.alarms == client.diagnostics == []

        assert client.transition(ACTIVATE)
        client.connect()
        client.row(": paper_drive")

        assert client.alarms[-1].severity == SlipAlarm.SEVERITY_NORMAL
        assert client.transition(DEACTIVATE)
        client.until(lambda: client.rows(": paper_drive")[-1].level == DiagnosticStatus.STALE)
        assert "nobody watches the belt" in client.rows(": paper_drive")[-1].message
        late: list[SlipAlarm] = []
        client.listen_for_alarms(late)
        client.until(lambda: bool(late))
        assert late[-1].condition == SlipAlarm.CONDITION_SENSOR_STALE
        assert late[-1].severity == SlipAlarm.SEVERITY_ALARM
        assert "nobody watches the belt" in late[-1].message
        client.spin(0.1)
        seen = len(client.states), len(client.diagnostics)
        client.drive(120)
        assert (len(client.states), len(client.diagnostics)) == seen
        response = client.trigger("acknowledge")
        assert (response.success, response.message) == (
            False,
            "not active: activate the node, e.g. ros2 lifecycle set <node> activate",
        )

        assert client.transition(ACTIVATE)
        client.connect()
        client.until(lambda: late[-1].severity == SlipAlarm.SEVERITY_NORMAL)
        assert client.transition(DEACTIVATE)
        assert client.transition(CLEANUP)
        assert client.lifecycle_state() == "unconfigured"
        client.until(lambda: client.node.count_publishers("belt_node/state") == 0)

        assert client.transition(CONFIGURE)
        assert client.transition(ACTIVATE)
        client.connect()
        assert client.states[-1].reset_count == 0
        assert not client.transition(CONFIGURE)
        assert node.alive
        assert "Traceback" not in node.log


@pytest.mark.parametrize(
    ("written", "instead", "reason"),
    [
        ("radius: 0.08125", "radius: -0.08125", "driver.radius is -0.08125 m"),
        ("friction_stiffness: 8.1e+7", "friction_stiffness: 0", "prior.friction_stiffness is 0"),
        ("span_length: 0.5105", "span_lenght: 0.5105", "did you mean span_length?"),
    ],
)
def test_an_unusable_drive_leaves_the_node_alive_unconfigured_and_outspoken(
    client: Client, ros_domain: int, tmp_path: Path, written: str, instead: str, reason: str
) -> None:
    params = tmp_path / "params.yaml"
    params.write_text(PAPER_DRIVE.read_text().replace(written, instead, 1))
    with NodeProcess(ros_domain, tmp_path / "log", params) as node:
        node.wait_for_log("cannot be configured")

        assert reason in node.log
        assert client.lifecycle_state() == "unconfigured"
        assert not client.transition(CONFIGURE)
        assert node.alive


def test_without_parameters_the_first_that_is_missing_is_named(
    ros_domain: int, tmp_path: Path
) -> None:
    with NodeProcess(ros_domain, tmp_path / "log", params=None) as node:
        node.wait_for_log("cannot be configured: belt.axial_stiffness is missing")
