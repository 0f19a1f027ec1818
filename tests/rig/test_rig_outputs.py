"""What the rig publishes as, over real DDS: pulley states, numbers, and many drives at once."""

import itertools
import math
import os
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

rclpy = pytest.importorskip("rclpy")
PulleyState = pytest.importorskip("belt_msgs.msg").PulleyState
from rclpy.qos import QoSProfile, qos_profile_sensor_data  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_msgs.msg import Float64  # noqa: E402

pytestmark = pytest.mark.ros

SCENARIO = """
name: short
duration: 1.0
speed: 100.0
load: 20.0
faults:
  - {at: 0.3, kind: dropout, sensor: driven_torque, duration: 0.2}
"""
RESULT = {"joint_states": JointState, "state": PulleyState}


def kind_of(topic: str) -> type:
    return RESULT.get(topic.rpartition("/")[2], Float64)


def ns(message: Any) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


class Listener:
    """Hears a run of the rig from its first message to its end."""

    def __init__(self, domain: int, root: Path, scenario: Path) -> None:
        self._domain = domain
        self._root = root
        self._scenario = scenario
        self._context = rclpy.Context()
        rclpy.init(context=self._context, domain_id=domain)
        self._node = rclpy.create_node("listener", context=self._context)
        self._executor = rclpy.executors.SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)

    def close(self) -> None:
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)

    def hear(
        self, topics: list[str], drive: str = "paper_drive", **parameters: object
    ) -> dict[str, list[Any]]:
        """Play the scenario; return the messages of each topic."""
        given = {
            "config_file": self._root / "config" / f"{drive}.yaml",
            "scenario_file": self._scenario,
            "wait_for_subscriber": 20.0,
            **parameters,
        }
        arguments = [word for name, value in given.items() for word in ("-p", f"{name}:={value}")]
        return self.listen(topics, "belt_ros.rig.main", "--ros-args", *arguments)

    def command(self, topics: list[str], drive: str, *more: str) -> dict[str, list[Any]]:
        """As `hear`, by `belt rig` with more words after its own."""
        config = str(self._root / "config" / f"{drive}.yaml")
        words = ("rig", "--config", config, "--scenario", str(self._scenario), *more)
        return self.listen(topics, "belt_ros.cli", *words)

    def listen(self, topics: list[str], *command: str) -> dict[str, list[Any]]:
        """Run a module; return the messages of each topic."""
        heard: dict[str, list[Any]] = defaultdict(list)
        for topic in topics:
            self._node.create_subscription(
                kind_of(topic), topic, heard[topic].append, QoSProfile(depth=1000)
            )
        process = subprocess.Popen(
            [sys.executable, "-m", *command],
            env={**os.environ, "ROS_DOMAIN_ID": str(self._domain), "PYTHONPATH": str(self._root)},
        )
        end = time.monotonic() + 100.0  # kernels may have to be compiled
        try:
            while process.poll() is None and time.monotonic() < end:
                self._executor.spin_once(timeout_sec=0.1)
        finally:
            process.kill()
            process.wait()
        for _ in range(500):
            self._executor.spin_once(timeout_sec=0.0)
        assert process.returncode == 0
        return heard


@pytest.fixture
def listener(ros_domain: int, root: Path, tmp_path: Path) -> Iterator[Listener]:
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(SCENARIO)
    listener = Listener(ros_domain, root, scenario)
    yield listener
    listener.close()


def test_pulley_states_come_at_the_rate_of_their_pulley_and_with_faults(listener: Listener) -> None:
    heard = listener.hear(
        ["driver/state", "driven/state"], output="pulley_state", driven_rate=25, loads=True
    )
    driver, driven = heard["driver/state"], heard["driven/state"]

    assert (len(driver), len(driven)) == (101, 26)
    assert {ns(b) - ns(a) for a, b in itertools.pairwise(driven)} == {40_000_000}
    assert {ns(message) for message in driven} < {ns(message) for message in driver}
    dropped = [math.isnan(message.torque) for message in driven]
    assert dropped == [0.3 <= number / 25 < 0.5 for number in range(26)]
    assert driven[-1].torque == pytest.approx(-20.0, rel=0.1)
    assert driver[-1].speed == pytest.approx(100.0, rel=1e-3)
    assert driver[-1].hub_load == pytest.approx(2.0 * 435.0, rel=0.1)
    assert math.isnan(driver[-1].span_tension)
    assert driven[-1].span_tension == pytest.approx(435.0 + 123.0, rel=0.1)


def test_numbers_have_a_topic_for_each_quantity(listener: Listener) -> None:
    quantities = [f"driven/{name}" for name in ("speed", "torque", "position", "span_tension")]
    heard = listener.hear(["driver/speed", *quantities], output="float64", loads=True)

    assert [len(heard[topic]) for topic in ("driver/speed", *quantities)] == [101] * 5
    values = {topic: [message.data for message in heard[topic]] for topic in heard}
    assert values["driver/speed"][-1] == pytest.approx(100.0, rel=1e-3)
    assert values["driven/position"][-1] == pytest.approx(99.5, rel=0.01)
    assert sum(math.isnan(value) for value in values["driven/torque"]) == 20


def test_fifty_drives_at_100_hz_share_a_joint_state(listener: Listener) -> None:
    heard = listener.hear(["joint_states"], drives=50, truth_rate=1)["joint_states"]

    assert len(heard) == 101
    assert {ns(b) - ns(a) for a, b in itertools.pairwise(heard)} == {10_000_000}
    names = heard[0].name
    assert len(names) == len(set(names)) == 100
    assert names[:2] == ["drive_1_driver_pulley_joint", "drive_1_driven_pulley_joint"]
    assert list(heard[50].velocity[2:4]) == list(heard[50].velocity[:2])


def test_topics_of_several_drives_begin_with_their_names(listener: Listener) -> None:
    topics = [f"{name}/driven/state" for name in ("infeed", "outfeed", "lift")]
    drivers = [f"{name}/driver/state" for name in ("infeed", "outfeed", "lift")]
    truths = [f"/belt_rig/{name}/truth" for name in ("infeed", "outfeed", "lift")]
    told: dict[str, list[Any]] = {topic: [] for topic in truths}
    kind = pytest.importorskip("belt_msgs.msg").BeltState
    for topic in truths:
        listener._node.create_subscription(kind, topic, told[topic].append, qos_profile_sensor_data)
    heard = listener.hear(
        [*topics, *drivers],  # the rig waits until all are heard
        "several_drives",
        output="pulley_state",
        truth_rate=10,
        fault="'wrong_sign driven_speed drive=lift'",
    )

    signs = [{message.speed > 0.0 for message in heard[topic]} for topic in topics]
    assert signs == [{True}, {True}, {False}]
    assert {messages[-1].drive_name for messages in told.values()} == {"infeed", "outfeed", "lift"}
    assert told["/belt_rig/lift/truth"][-1].mean_tension == pytest.approx(600.0)


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"output": "joints"}, "must be one of joint_state, pulley_state, float64"),
        ({"driven_rate": 200.0}, "driven_rate is 200 Hz, the scenario has 100 samples a second"),
        ({"drives": 501}, "drives is 501; it must lie between 0 and 500"),
        ({"loads": 1}, "loads is 1; it must be true or false"),
    ],
)
def test_what_cannot_be_published_is_told(
    root: Path, tmp_path: Path, ros_domain: int, parameters: dict[str, object], words: str
) -> None:
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(SCENARIO)
    given = {"config_file": root / "config" / "paper_drive.yaml", "scenario_file": scenario}
    arguments = [
        word
        for name, value in {**given, **parameters}.items()
        for word in ("-p", f"{name}:={value}")
    ]
    run = subprocess.run(
        [sys.executable, "-m", "belt_ros.rig.main", "--ros-args", *arguments],
        env={**os.environ, "ROS_DOMAIN_ID": str(ros_domain), "PYTHONPATH": str(root)},
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    assert run.returncode == 2
    assert words in run.stderr
    assert "Traceback" not in run.stderr


def test_the_command_plays_several_drives_and_passes_on_what_is_for_the_node(
    listener: Listener,
) -> None:
    names = itertools.product(("infeed", "outfeed", "lift"), ("driver", "driven"))
    heard = listener.command(
        [f"{drive}/{pulley}/state" for drive, pulley in names],  # the rig waits until all are heard
        "several_drives",
        *("--ros-args", "-p", "output:=pulley_state", "-p", "wait_for_subscriber:=20.0"),
    )
    assert [len(messages) for messages in heard.values()] == [101] * 6
