"""A node that is killed, stopped or given a bad file, and what it knows when it is back."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from belt_msgs.srv import RecordMaintenance
from diagnostic_msgs.msg import DiagnosticStatus
from node_harness import (
    ACTIVATE,
    CLEANUP,
    CONFIGURE,
    DEACTIVATE,
    SECOND,
    Client,
    NodeProcess,
)
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from belt_ros.estimation.memory_file import load

pytestmark = pytest.mark.ros
BAG = Path(__file__).resolve().parents[1] / "data" / "rig_bag"
STANDING = {"velocity": (0.0, 0.0), "effort": (0.0, 0.0)}
MEASURED_TENSION = RecordMaintenance.Request.MEASURED_TENSION
PRIOR_SPREAD = 60.0  # [N]
PRIOR_BIAS_SPREAD = 2e-4
NEVER = 3600.0


def rig_states() -> list[dict[str, list[float]]]:
    """The rig's joint states: a run-up, by which the ratio is learned, loads and an overload."""
    with AnyReader([BAG], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        chosen = [item for item in reader.connections if item.topic == "/joint_states"]
        messages = [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages(chosen)
        ]
    return [
        {"velocity": message.velocity.tolist(), "effort": message.effort.tolist()}
        for message in messages
    ]


def play(client: Client, states: list[dict[str, list[float]]]) -> None:
    """Publish as fast as the node follows."""
    for k, state in enumerate(states):
        sent = client.send(**state)
        if k % 20 == 19 or k == len(states) - 1:
            client.until(lambda sent=sent: client.last_stamp() == sent)


@contextmanager
def life(domain: int, log: Path, **parameters: object) -> Iterator[tuple[NodeProcess, Client]]:
    """One life of the node, and a client that is new to it and has found it.

    What DDS has left of a killed node hides the next one from an older client, for seconds.
    """
    parameters["input_reliability"] = "reliable"
    with NodeProcess(domain, log, **parameters) as node:
        node.wait_for_log("active, listening")
        client = Client(domain)
        assert client.lifecycle_state() == "active"
        client.spin(0.5)
        yield node, client
        client.close()


def test_killed_at_any_moment_it_is_back_with_what_it_had_learned(
    ros_domain: int, tmp_path: Path
) -> None:
    memory = {"memory_file": tmp_path / "belt.json", "memory_period": 0.1}
    states = rig_states()
    with life(ros_domain, tmp_path / "log", **memory) as (node, client):
        client.connect(**STANDING)
        assert client.states[-1].mean_tension_stddev == pytest.approx(PRIOR_SPREAD, rel=0.02)
        play(client, states)
        assert client.record_maintenance(MEASURED_TENSION, value=420.0, value_stddev=12.0).success
        client.drive(40, **states[-1])
        taught = client.states[-1]
        assert taught.mean_tension_stddev < 0.3 * PRIOR_SPREAD
        assert taught.ratio_bias_stddev < 0.3 * PRIOR_BIAS_SPREAD
        node.kill()

    rng = np.random.default_rng(5)
    for again in range(3):
        with life(ros_domain, tmp_path / f"log{again}", **memory) as (node, client):
            began = time.monotonic()
            first = client.next_state(**states[-1])
            assert time.monotonic() - began < 1.0

            assert "restored what was learned" in node.log
            assert first.accepted_count == 1
            assert first.mean_tension_stddev < 0.3 * PRIOR_SPREAD
            assert first.ratio_bias_stddev < 0.3 * PRIOR_BIAS_SPREAD
            assert abs(first.mean_tension - taught.mean_tension) < 3.0 * taught.mean_tension_stddev
            client.drive(int(rng.integers(1, 60)), **states[-1])
            node.kill()


def test_it_is_kept_when_the_node_stops_in_whatever_way(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    path = tmp_path / "belt.json"

    def date() -> float:
        learned = load(path, "paper_drive")
        assert learned is not None
        return learned.date

    with NodeProcess(ros_domain, tmp_path / "log", memory_file=path, memory_period=NEVER) as node:
        client.connect()
        assert not path.exists()
        assert client.transition(DEACTIVATE)
        first = date()
        assert abs(time.time() - first) < 20.0

        assert client.transition(CLEANUP)
        assert date() == first
        assert client.transition(CONFIGURE)
        assert client.transition(ACTIVATE)
        assert "paper_drive: restored what was learned" in node.log
        client.connect()
        assert client.transition(DEACTIVATE)
        second = date()
        assert second > first

        assert client.transition(ACTIVATE)
        client.connect()
        row = client.row(" memory")
        values = {pair.key: float(pair.value) for pair in row.values}
        assert row.level == DiagnosticStatus.OK
        assert values["restored"] == 1
        assert 0.0 <= values["age when restored [s]"] < 60.0
        assert values["saves"] == 1
        assert 0.0 <= values["since saved [s]"] < 60.0

        node.interrupt()
        assert node.wait_for_exit() == 0
        assert date() > second
        assert "Traceback" not in node.log


def test_a_run_is_kept_where_time_has_gone_back_while_the_node_was_inactive(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    path = tmp_path / "belt.json"
    with NodeProcess(ros_domain, tmp_path / "log", memory_file=path, memory_period=NEVER) as node:
        client.connect()
        client.drive(20)
        assert client.transition(DEACTIVATE)
        before = path.read_bytes()
        client.now_ns -= 100 * SECOND
        assert client.transition(ACTIVATE)
        client.drive(20)
        client.until(lambda: client.states[-1].reset_count == 1)

        aside = tmp_path / "belt.json.before_jump"
        node.wait_for_log(f"what was learned until then is kept as {aside}")
        assert node.log.count("the stamps went back: starting anew, as this run began") == 1
        assert aside.read_bytes() == before


def test_a_damaged_file_is_told_once_and_kept_aside(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    path = tmp_path / "belt.json"
    path.write_text("{")
    with NodeProcess(ros_domain, tmp_path / "log", memory_file=path, memory_period=NEVER) as node:
        client.connect()
        row = client.row(" memory")
        assert row.level == DiagnosticStatus.WARN
        assert "is no memory that can be used" in row.message
        assert client.transition(DEACTIVATE)

        assert node.log.count("is no memory that can be used") == 1
        assert (tmp_path / "belt.json.refused").read_text() == "{"
        assert load(path, "paper_drive") is not None


def test_a_place_that_cannot_be_written_does_not_stop_the_node(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    with NodeProcess(ros_domain, tmp_path / "log", memory_file=tmp_path, memory_period=0.1) as node:
        client.connect()
        client.drive(50)
        row = client.row(" memory")
        assert row.level == DiagnosticStatus.WARN
        assert "is no regular file" in row.message
        assert client.next_state().accepted_count > 50
        assert "Traceback" not in node.log


def test_without_a_memory_there_is_no_row_of_it(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    with NodeProcess(ros_domain, tmp_path / "log"):
        client.connect()
        client.row(" input")
        assert client.rows(" memory") == []


def test_a_memory_that_is_not_to_be_used_is_neither_read_nor_written(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    path = tmp_path / "belt.json"
    path.write_text("{")
    memory = {"memory_file": path, "memory_period": 0.1, "use_memory": "false"}
    with NodeProcess(ros_domain, tmp_path / "log", **memory) as node:
        client.connect()
        client.drive(50)
        assert client.transition(DEACTIVATE)
        assert "memory" not in node.log
    assert path.read_text() == "{"
    assert [file.name for file in tmp_path.iterdir() if "belt.json" in file.name] == ["belt.json"]
