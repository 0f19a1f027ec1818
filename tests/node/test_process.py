"""The node as a process: how it ends, and how it takes simulated time."""

import signal
import time
from pathlib import Path

import pytest
from belt_msgs.msg import BeltState, SlipAlarm
from node_harness import SECOND, Client, NodeProcess, not_finite, stamp
from rosgraph_msgs.msg import Clock

pytestmark = pytest.mark.ros


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_without_complaint_also_when_sent_twice(
    client: Client, ros_domain: int, tmp_path: Path, number: signal.Signals
) -> None:
    with NodeProcess(ros_domain, tmp_path / "log") as node:
        client.connect()
        for _ in range(20):
            client.send()
        node.interrupt(number)
        time.sleep(0.002)
        node.interrupt(number)

        assert node.wait_for_exit() == 0
        assert "Traceback" not in node.log
        assert "rror" not in node.log


def test_signals_that_go_on_until_the_end_change_nothing(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    """Also while the interpreter is taken down, after all that belongs to the node."""
    with NodeProcess(ros_domain, tmp_path / "log") as node:
        client.connect()
        while node.alive:
            node.interrupt(signal.SIGTERM)
            time.sleep(0.001)

        assert node.wait_for_exit() == 0
        assert "Traceback" not in node.log


def test_a_parameter_file_that_is_not_there_is_named(ros_domain: int, tmp_path: Path) -> None:
    with NodeProcess(ros_domain, tmp_path / "log", Path("nowhere.yaml")) as node:
        assert node.wait_for_exit() == 1
        assert "nowhere.yaml" in node.log
        assert "Traceback" not in node.log


def test_simulated_time_that_goes_back_resets_once(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    clock = client.node.create_publisher(Clock, "/clock", 10)

    def run(begin_ns: int) -> None:
        client.now_ns = begin_ns
        for _ in range(20):
            clock.publish(Clock(clock=stamp(client.now_ns + client.step_ns)))
            client.spin(0.01)
            client.send()
            client.spin(0.01)
        client.until(lambda: client.last_stamp() == client.now_ns)

    slowly = {"limits__greatest_gap": 5.0}  # for which late messages are looked for
    with NodeProcess(ros_domain, tmp_path / "log", use_sim_time="true", **slowly) as node:
        client.now_ns = 100 * SECOND
        client.connect()
        run(client.now_ns)
        first = client.states[-1]
        before = first.accepted_count
        run(50 * SECOND)

        assert first.reset_count == 0
        assert client.states[-1].reset_count == 1
        assert client.states[-1].accepted_count == before + 20
        assert sum(client.states[-1].rejection_counts) == 0
        assert node.log.count("ROS time went back") == 1

        clock.publish(Clock(clock=stamp(20 * SECOND)))
        client.until(lambda: node.log.count("ROS time went back") == 2)
        for _ in range(5):
            client.send()  # of before, as if it had been on its way
        client.spin(0.1)
        run(20 * SECOND)
        assert client.states[-1].reset_count == 2
        assert client.states[-1].rejection_counts[BeltState.REJECTION_OUT_OF_ORDER] == 5
        assert "the stamps went back" not in node.log


def test_sensors_that_are_dead_from_the_start_are_told_of(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    with NodeProcess(ros_domain, tmp_path / "log"):
        client.until(lambda: bool(client.alarms), timeout=60.0)
        alarm = client.alarms[-1]
        assert alarm.condition == SlipAlarm.CONDITION_SENSOR_STALE
        assert "Nothing is known of the belt yet" in alarm.message
        assert not_finite(alarm) == []
        assert client.trigger("acknowledge").success


def test_an_autostart_that_is_no_truth_value_is_named(ros_domain: int, tmp_path: Path) -> None:
    with NodeProcess(ros_domain, tmp_path / "log", autostart="'yes'") as node:
        node.wait_for_log("autostart is 'yes'; it must be true or false")
