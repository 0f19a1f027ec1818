"""Several drives in one node: each with its own parameters, topics, services, alarm and rows."""

from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml
from belt_msgs.msg import BeltState
from belt_msgs.srv import RecordMaintenance
from node_harness import PAPER_DRIVE, Client, NodeProcess, joint_state, ns
from rclpy.qos import ReliabilityPolicy
from std_srvs.srv import Trigger

from belt_ros.settings import read_parameters

LEFT = ("left_driver", "left_driven")
RIGHT = ("right_driver", "right_driven")


def description(tmp_path: Path) -> Path:
    """The paper's drive twice, one with a narrower prior and its joints' own names."""
    shared = {
        name: value
        for name, value in read_parameters(PAPER_DRIVE).items()
        if name not in {"name", "driver.joint", "driven.joint"}
    }
    own = {
        "left.driver.joint": LEFT[0],
        "left.driven.joint": LEFT[1],
        "right.driver.joint": RIGHT[0],
        "right.driven.joint": RIGHT[1],
        "right.prior.tension": 500.0,
    }
    values = {"drives": ["left", "right"], **shared, **own}
    path = tmp_path / "drives.yaml"
    path.write_text(yaml.safe_dump({"/**": {"ros__parameters": values}}))
    return path


@pytest.fixture
def client(ros_domain: int) -> Iterator[Client]:
    client = Client(ros_domain)
    yield client
    client.close()


@pytest.fixture
def node(ros_domain: int, tmp_path: Path) -> Iterator[NodeProcess]:
    with NodeProcess(ros_domain, tmp_path / "log", description(tmp_path)) as node:
        node.wait_for_log("active, listening on")
        yield node


def listen(client: Client, drive: str) -> list[BeltState]:
    states: list[BeltState] = []
    client.node.create_subscription(BeltState, f"belt_node/{drive}/state", states.append, 1000)
    return states


def test_each_drive_has_its_own_state_from_one_joint_states(
    client: Client, node: NodeProcess
) -> None:
    left, right = listen(client, "left"), listen(client, "right")

    def both() -> bool:
        client.now_ns += client.step_ns
        client.send_raw(
            joint_state(
                client.now_ns,
                (120.0, 119.4, 60.0, 59.7),
                (30.0, -30.0, 10.0, -10.0),
                (*LEFT, *RIGHT),
            )
        )
        client.spin(0.02)
        return bool(left) and bool(right) and ns(left[-1].header.stamp) == client.now_ns

    client.until(both, timeout=60.0)
    assert (left[-1].drive_name, right[-1].drive_name) == ("left", "right")
    assert left[-1].driver_speed == pytest.approx(120.0, abs=0.1)
    assert right[-1].driver_speed == pytest.approx(60.0, abs=0.1)
    assert right[-1].mean_tension - left[-1].mean_tension > 50.0
    assert client.row("belt_node: left").hardware_id == "left"
    assert client.row("belt_node: right").hardware_id == "right"
    row = client.row("belt_node: node")
    assert {value.key: value.value for value in row.values}["drives"] == "2"

    reset = client.call(Trigger, "left/reset", Trigger.Request())
    assert reset.success, reset.message
    request = RecordMaintenance.Request(
        drive_name="right",
        action=RecordMaintenance.Request.RE_TENSIONED,
        value=620.0,
        value_stddev=10.0,
    )
    done = client.call(RecordMaintenance, "record_maintenance", request)
    assert done.success, done.message
    before = len(right)
    client.until(lambda: both() and len(right) > before + 2)
    assert right[-1].reset_count == 0
    assert left[-1].reset_count == 1
    assert right[-1].mean_tension == pytest.approx(620.0, rel=0.2)
    stranger = RecordMaintenance.Request(drive_name="middle", action=1, value=620.0)
    refused = client.call(RecordMaintenance, "record_maintenance", stranger)
    assert not refused.success
    assert "'left', 'right'" in refused.message


def test_a_threshold_is_set_for_one_drive(client: Client, node: NodeProcess) -> None:
    assert client.set_parameter("left.alarm.margin_warning", 0.5) == (True, "")
    assert client.get_parameter("left.alarm.margin_warning").double_value == 0.5
    assert client.get_parameter("right.alarm.margin_warning").double_value != 0.5
    done, reason = client.set_parameter("right.alarm.margin_warning", 7.0)
    assert not done
    assert "margin_warning" in reason


@pytest.mark.parametrize(
    ("drives", "reason"),
    [
        (["left", "left"], "more than once"),
        (["driver", "left"], "the name of a parameter"),
        (["1st", "left"], "a name begins with a letter"),
    ],
)
def test_names_that_cannot_be_used_leave_the_node_unconfigured_and_saying_why(
    ros_domain: int, tmp_path: Path, drives: list[str], reason: str
) -> None:
    path = description(tmp_path)
    document = yaml.safe_load(path.read_text())
    document["/**"]["ros__parameters"]["drives"] = drives
    path.write_text(yaml.safe_dump(document))
    with NodeProcess(ros_domain, tmp_path / "log", path) as node:
        node.wait_for_log("cannot be configured")
        assert reason in node.log


ALARMS = "qos_overrides./belt_node/left/alarm.publisher.reliability"


def test_an_override_of_one_alarm_is_of_that_one_only(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    overrides = {ALARMS: "best_effort"}
    with NodeProcess(ros_domain, tmp_path / "log", description(tmp_path), **overrides) as node:
        node.wait_for_log("active, listening on")

        def reliability(drive: str) -> list[ReliabilityPolicy]:
            found = client.node.get_publishers_info_by_topic(f"/belt_node/{drive}/alarm")
            return [publisher.qos_profile.reliability for publisher in found]

        client.until(lambda: bool(reliability("left") and reliability("right")))
        assert reliability("left") == [ReliabilityPolicy.BEST_EFFORT]
        assert reliability("right") == [ReliabilityPolicy.RELIABLE]


def test_an_override_of_a_publisher_that_cannot_be_used_is_named(
    ros_domain: int, tmp_path: Path
) -> None:
    overrides = {ALARMS: "utterly"}
    with NodeProcess(ros_domain, tmp_path / "log", description(tmp_path), **overrides) as node:
        node.wait_for_log("cannot be configured")
        assert f"{ALARMS} is 'utterly'; it must be one of" in node.log
        assert "Traceback" not in node.log


def test_one_drive_that_has_a_name_has_the_service_of_the_node_as_well(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    path = description(tmp_path)
    document = yaml.safe_load(path.read_text())
    values = document["/**"]["ros__parameters"]
    document["/**"]["ros__parameters"] = {
        name: value for name, value in values.items() if not name.startswith("right.")
    } | {"drives": ["left"]}
    path.write_text(yaml.safe_dump(document))
    with NodeProcess(ros_domain, tmp_path / "log", path) as node:
        node.wait_for_log("active, listening on")
        response = client.record_maintenance(RecordMaintenance.Request.BELT_REPLACED)
        assert (response.success, response.message) == (False, "name the drive: one of 'left'")
        done = client.record_maintenance(RecordMaintenance.Request.BELT_REPLACED, drive_name="left")
        assert done.success


def test_their_memories_are_written_one_after_the_other(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    """All at once would hold up the input of a node of many drives."""
    memory = {"memory_file": tmp_path / "{drive}.json", "memory_period": 2.0}
    with NodeProcess(ros_domain, tmp_path / "log", description(tmp_path), **memory) as node:
        node.wait_for_log("active, listening on")
        files = [tmp_path / f"{name}.json" for name in ("left", "right")]

        def kept() -> bool:
            client.now_ns += client.step_ns
            speeds, torques = (120.0, 119.4, 120.0, 119.4), (30.0, -30.0, 30.0, -30.0)
            client.send_raw(joint_state(client.now_ns, speeds, torques, (*LEFT, *RIGHT)))
            client.spin(0.01)
            return all(file.exists() for file in files)

        client.until(kept)
        left, right = (file.stat().st_mtime for file in files)
        assert abs(left - right) > 0.4
