"""A bag played to a running node over DDS: the node says what replay of that bag says."""

import json
import os
import pty
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from node_harness import PAPER_DRIVE, ROOT, Client, NodeProcess, ns
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability
from rosbags.interfaces import QosTime as Span
from rosbags.rosbag2 import StoragePlugin, Writer
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from belt_ros.message_types import belt_typestore
from belt_ros.replay import STATE_TOPIC, replay
from belt_ros.settings import load_settings

pytestmark = pytest.mark.ros
BAG = ROOT / "tests" / "data" / "rig_bag"
_PLAY = """
import json, sys
from belt_ros.player.run import play
from belt_ros.replay.errors import BagError
try:
    played = play(sys.argv[1], tell=lambda line: print(line, flush=True), **json.loads(sys.argv[2]))
except BagError as error:
    sys.exit(str(error))
print("messages", played.messages, "rounds", played.rounds, "interrupted", played.interrupted)
"""


class Playing:
    """The player in a process of its own."""

    def __init__(self, domain: int, bag: Path, stdin: int = subprocess.DEVNULL, **options) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-c", _PLAY, str(bag), json.dumps(options)],
            cwd=ROOT,
            stdin=stdin,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env={**os.environ, "ROS_DOMAIN_ID": str(domain)},
        )

    def __enter__(self) -> "Playing":
        return self

    def __exit__(self, *_: object) -> None:
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        self._process.stdout.close()

    def interrupt(self) -> None:
        self._process.send_signal(signal.SIGINT)

    def wait_for(self, text: str) -> None:
        """Read what it says up to a line with `text`; that much is not given by `end`."""
        for line in self._process.stdout:
            if text in line:
                return
        pytest.fail(f"it ended without saying {text!r}")

    @property
    def alive(self) -> bool:
        return self._process.poll() is None

    def end(self, timeout: float = 30.0) -> tuple[int, str]:
        said, _ = self._process.communicate(timeout=timeout)
        return self._process.returncode, said


@pytest.fixture
def client(ros_domain: int) -> Iterator[Client]:
    client = Client(ros_domain)
    yield client
    client.close()


def replayed(out: Path) -> list[object]:
    with AnyReader([out / "estimates"], default_typestore=belt_typestore()) as reader:
        chosen = [item for item in reader.connections if item.topic == STATE_TOPIC]
        return [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages(chosen)
        ]


def assert_same_bits(ours: object, theirs: object) -> None:
    for name in theirs.get_fields_and_field_types():
        if name == "header":
            assert ours.header.stamp.sec == theirs.header.stamp.sec
            assert ours.header.stamp.nanosec == theirs.header.stamp.nanosec
        else:
            np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name), err_msg=name)


def test_a_node_on_the_bags_clock_says_what_replay_says_and_a_loop_resets_it_once(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    replay(BAG, load_settings(PAPER_DRIVE), tmp_path / "out", smooth=False)
    offline = replayed(tmp_path / "out")
    with NodeProcess(
        ros_domain,
        tmp_path / "log",
        use_sim_time="true",
        input_reliability="reliable",
        input_depth="5000",  # it may not pool here, and falls behind while others use the processor
    ) as node:
        node.wait_for_log("active")
        client.until(lambda: client.node.count_publishers("belt_node/state") > 0)
        client.spin(1.0)
        with Playing(
            ros_domain, BAG, clock=True, loop=True, rate=2.0, topics=["/joint_states"], wait=20.0
        ) as playing:
            client.until(lambda: len(client.states) >= len(offline) + 20, timeout=60.0)
            playing.interrupt()
            code, said = playing.end()
        assert code == 0, said
        assert "interrupted True" in said
        first, second = client.states[: len(offline)], client.states[len(offline) :]
        for ours, theirs in zip(offline, first, strict=True):
            assert_same_bits(ours, theirs)
        assert {state.reset_count for state in second} == {1}
        assert sum(second[-1].rejection_counts) == 0
        assert node.log.count("ROS time went back") == 1


def test_the_clock_is_never_behind_a_message_that_is_out(client: Client, ros_domain: int) -> None:
    heard: list[tuple[str, int]] = []
    subscribe = client.node.create_subscription
    subscribe(Clock, "/clock", lambda clock: heard.append(("clock", ns(clock.clock))), 2000)
    subscribe(
        JointState,
        "/elsewhere",
        lambda state: heard.append(("state", ns(state.header.stamp))),
        2000,
    )
    with Playing(
        ros_domain, BAG, clock=True, rate=5.0, remap=["/joint_states:=/elsewhere"], wait=20.0
    ) as playing:
        client.until(lambda: not playing.alive, timeout=60.0)
        code, said = playing.end()
        client.spin(0.5)
    assert code == 0, said
    assert "messages 842 rounds 1" in said
    states = [stamp for kind, stamp in heard if kind == "state"]
    clocks = [stamp for kind, stamp in heard if kind == "clock"]
    assert len(states) == 701
    assert clocks == sorted(clocks)
    assert set(states) <= set(clocks)


def test_what_was_offered_is_offered_again(client: Client, ros_domain: int, tmp_path: Path) -> None:
    latched = Qos(
        QosHistory.KEEP_LAST,
        7,
        QosReliability.BEST_EFFORT,
        QosDurability.TRANSIENT_LOCAL,
        Span(3, 0),
        Span(2147483647, 4294967295),
        QosLiveliness.AUTOMATIC,
        Span(2147483647, 4294967295),
        False,
    )
    store = belt_typestore()
    kind = "sensor_msgs/msg/JointState"
    with (
        AnyReader([BAG]) as reader,
        Writer(tmp_path / "bag", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer,
    ):
        out = writer.add_connection(
            "/joint_states", kind, typestore=store, offered_qos_profiles=[latched]
        )
        chosen = [item for item in reader.connections if item.topic == "/joint_states"]
        for _, log_ns, data in reader.messages(chosen):
            writer.write(out, log_ns, data)
    file = (tmp_path / "bag" / "bag.db3").rename(tmp_path / "run#1.db3")
    with Playing(ros_domain, file, wait=0.0) as playing:
        offers = client.node.get_publishers_info_by_topic

        def offered() -> list[QoSProfile]:
            known = offers("/joint_states")
            return [one.qos_profile for one in known if one.node_name == "belt_player"]

        client.until(lambda: bool(offered()))
        quality = offered()[0]
        playing.interrupt()
        code, said = playing.end()
    assert code == 0, said
    assert quality.reliability is ReliabilityPolicy.BEST_EFFORT
    assert quality.durability is DurabilityPolicy.TRANSIENT_LOCAL
    assert quality.deadline.nanoseconds == 3_000_000_000


def test_the_space_bar_pauses_and_resumes(client: Client, ros_domain: int) -> None:
    heard: list[int] = []
    client.node.create_subscription(
        JointState, "/joint_states", lambda state: heard.append(ns(state.header.stamp)), 2000
    )
    terminal, other_end = pty.openpty()
    with Playing(ros_domain, BAG, stdin=other_end, wait=20.0) as playing:
        client.until(lambda: len(heard) > 20)
        os.write(terminal, b" ")
        client.spin(0.5)
        before = len(heard)
        client.spin(1.0)
        paused = len(heard)
        os.write(terminal, b" ")
        client.until(lambda: len(heard) > paused + 50)
        playing.interrupt()
        code, said = playing.end()
    os.close(terminal)
    os.close(other_end)
    assert paused == before
    assert code == 0, said
    assert said.count("paused") >= 1
    assert "resumed" in said
    assert np.all(np.diff(heard) == 10_000_000)


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"topics": ["/nothing"]}, "no messages on /nothing; there are /belt_rig/truth"),
        ({"remap": ["/joint_states"]}, "write /old:=/new"),
        (
            {"remap": ["/joint_states:=/belt_rig/truth"]},
            "/belt_rig/truth would carry belt_msgs/msg/BeltState and sensor_msgs/msg/JointState",
        ),
        (
            {"remap": ["/joint_states:=/clock"], "clock": True},
            "/clock would carry rosgraph_msgs/msg/Clock and sensor_msgs/msg/JointState",
        ),
        ({"rate": 0.0}, "--rate is 0; it must lie between"),
    ],
)
def test_what_cannot_be_played_is_said_in_a_line(
    ros_domain: int, options: dict[str, object], complaint: str
) -> None:
    with Playing(ros_domain, BAG, **options) as playing:
        code, said = playing.end()
    assert code == 1
    assert complaint in said
    assert "Traceback" not in said


def test_a_player_ends_when_told_to_while_it_waits_for_listeners(ros_domain: int) -> None:
    with Playing(ros_domain, BAG, wait=60.0) as playing:
        playing.wait_for("waiting up to 60 s")
        playing.interrupt()
        code, said = playing.end(timeout=10.0)
    assert code == 0, said
    assert "messages 0" in said
