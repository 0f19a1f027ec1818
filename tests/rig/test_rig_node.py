"""The rig over real DDS, in a process of its own, as users start it."""

import itertools
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

rclpy = pytest.importorskip("rclpy")
BeltState = pytest.importorskip("belt_msgs.msg").BeltState
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue  # noqa: E402
from rcl_interfaces.srv import GetParameters, SetParameters  # noqa: E402
from rclpy.qos import qos_profile_sensor_data  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from service_discovery import await_answers  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

pytestmark = pytest.mark.ros

SCENARIO = """
name: short
duration: 1.5
speed: 100.0
load: [[0.5, 10.0], [0.6, 30.0]]
"""


class Rig:
    """Starts ``belt_rig`` with parameters, and ends it."""

    def __init__(self, root: Path, scenario: Path, domain: int) -> None:
        self._parameters = {
            "config_file": root / "config" / "paper_drive.yaml",
            "scenario_file": scenario,
        }
        self._environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "PYTHONPATH": str(root)}
        self._processes: list[subprocess.Popen[str]] = []

    def start(self, **parameters: object) -> "subprocess.Popen[str]":
        arguments = ["--ros-args"]
        for name, value in {**self._parameters, **parameters}.items():
            arguments += ["-p", f"{name}:={value}"]
        process = subprocess.Popen(
            [sys.executable, "-m", "belt_ros.rig.main", *arguments],
            env=self._environment,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._processes.append(process)
        return process

    def end(self) -> None:
        for process in self._processes:
            if process.poll() is None:
                process.kill()
            process.communicate()


@pytest.fixture
def rig(root: Path, tmp_path: Path, ros_domain: int) -> Iterator[Rig]:
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(SCENARIO)
    rig = Rig(root, scenario, ros_domain)
    yield rig
    rig.end()


@pytest.fixture
def client(ros_domain: int) -> Iterator[Any]:
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    node = rclpy.create_node("client", context=context)
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(node)
    node.spin_once = executor.spin_once
    yield node
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=context)


def test_rig_plays_its_scenario_in_real_time_and_ends(rig: Rig, client: Any) -> None:
    joints: list[tuple[int, int]] = []  # stamp, arrival [ns]
    truths: list[Any] = []

    def on_joints(message: Any) -> None:
        stamp = message.header.stamp
        joints.append((stamp.sec * 10**9 + stamp.nanosec, time.time_ns()))

    client.create_subscription(JointState, "joint_states", on_joints, 200)
    client.create_subscription(BeltState, "/belt_rig/truth", truths.append, qos_profile_sensor_data)
    process = rig.start(wait_for_subscriber=20.0)
    end = time.monotonic() + 30.0
    while process.poll() is None and time.monotonic() < end:
        client.spin_once(timeout_sec=0.1)
    for _ in range(50):
        client.spin_once(timeout_sec=0.0)

    _, errors = process.communicate(timeout=10.0)
    assert process.returncode == 0, errors
    assert len(joints) == 151
    assert {later[0] - earlier[0] for earlier, later in itertools.pairwise(joints)} == {10_000_000}
    assert -0.001 < (joints[-1][1] - joints[-1][0]) * 1e-9 < 0.5
    assert len(truths) > 50
    assert truths[-1].margin == pytest.approx(0.54, abs=0.03)
    assert truths[-1].margin_stddev == 0.0
    assert "end of scenario short: 151 samples" in errors


def set_fault(client: Any, text: str) -> Any:
    """Set the rig's parameter as `ros2 param set` does, and return the result."""
    service = service_of_rig(client, SetParameters, "set_parameters")
    value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=text)
    return call(
        client, service, SetParameters.Request(parameters=[Parameter(name="fault", value=value)])
    ).results[0]


def service_of_rig(client: Any, kind: Any, name: str) -> Any:
    """A client of one of the rig's services, once the rig can answer it."""
    service = client.create_client(kind, f"/belt_rig/{name}")
    until(client, service.service_is_ready)
    ask_twice = GetParameters, "/belt_rig/get_parameters"
    await_answers(client, lambda: client.spin_once(timeout_sec=0.05), *ask_twice)
    return service


def call(client: Any, service: Any, request: Any) -> Any:
    future = service.call_async(request)
    until(client, future.done)
    return future.result()


def until(client: Any, true: Callable[[], object], timeout: float = 20.0) -> None:
    end = time.monotonic() + timeout
    while not true():
        assert time.monotonic() < end, "it did not come in time"
        client.spin_once(timeout_sec=0.05)


def test_fault_set_as_a_parameter_shows_in_joint_states_and_ends(rig: Rig, client: Any) -> None:
    messages: list[Any] = []
    truths: list[Any] = []
    client.create_subscription(JointState, "joint_states", messages.append, 500)
    client.create_subscription(BeltState, "/belt_rig/truth", truths.append, 500)
    rig.start(loop=True, wait_for_subscriber=20.0)
    until(client, lambda: len(messages) > 10)

    def signs() -> list[bool]:
        return [message.velocity[1] < 0.0 for message in messages]

    assert set_fault(client, "wrong_sign driven_speed duration=0.3").successful
    until(client, lambda: signs()[-1] is False and any(signs()))
    assert signs().count(True) in {29, 30}
    assert all(message.velocity[0] > 50.0 for message in messages)

    assert set_fault(client, "tension=300").successful
    until(client, lambda: truths[-1].mean_tension == pytest.approx(300.0, abs=1e-6))
    assert set_fault(client, "stuck driver_torque").successful
    until(client, lambda: len({message.effort[0] for message in messages[-20:]}) == 1)
    clear = service_of_rig(client, Trigger, "clear_faults")
    answer = call(client, clear, Trigger.Request())
    assert (answer.success, answer.message) == (True, "ended: tension, stuck driver_torque")
    until(client, lambda: truths[-1].mean_tension == pytest.approx(435.0))
    until(client, lambda: len({message.effort[0] for message in messages[-20:]}) > 10)

    refused = set_fault(client, "stuck driven_speed 5")
    assert not refused.successful
    assert "duration=5" in refused.reason


def test_interrupted_twice_the_rig_ends_without_a_traceback(rig: Rig) -> None:
    process = rig.start(loop=True, rate_factor=20, wait_for_subscriber=0.0)
    assert process.stderr is not None
    assert "playing scenario" in process.stderr.readline()
    time.sleep(0.3)
    for _ in range(2):
        process.send_signal(signal.SIGINT)

    _, errors = process.communicate(timeout=10.0)
    assert process.returncode == 0
    assert "Traceback" not in errors


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"scenario_file": "nowhere.yaml"}, "cannot read nowhere.yaml: No such file"),
        ({"fault": "stuck motor"}, "sensor is 'motor'; it must be one of driver_position"),
        ({"fault": 5}, "kind is '5'; it must be one of dropout"),
        ({"rate_factor": "fast"}, "parameter rate_factor is 'fast'; it must be a number"),
    ],
)
def test_bad_parameter_is_told_and_the_rig_ends(
    rig: Rig, parameters: dict[str, object], words: str
) -> None:
    process = rig.start(**parameters)

    _, errors = process.communicate(timeout=20.0)
    assert process.returncode == 2, errors
    assert words in errors
    assert "Traceback" not in errors
