"""What sender, counter and bench are made of."""

import os
import time

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed")
pytest.importorskip("belt_msgs", reason="belt_msgs is not built")

from belt_msgs.msg import BeltState
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from belt_ros.settings import load_settings
from benchmarks.graph.bench import Memory
from benchmarks.graph.counter import Heard
from benchmarks.graph.plan import Block, Plan, Sent, load_plan, load_sent, save_plan, save_sent
from benchmarks.graph.program import ROOT, processor_ns, resident_bytes
from benchmarks.graph.sender import JointStateBytes
from benchmarks.graph.signals import loaded

JOINTS = ("driver", "driven")


@pytest.mark.parametrize("drives", [1, 3])
def test_bytes_filled_in_place_are_the_message(drives: int) -> None:
    joints = [f"{joint}_{number}" for number in range(drives) for joint in JOINTS]
    numbers = np.arange(4.0 * drives).reshape(2, -1) - 2.5
    raw = JointStateBytes(joints).filled(12_000_000_034, numbers)
    message = deserialize_message(raw, JointState)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (12, 34)
    assert message.name == joints
    np.testing.assert_array_equal([message.velocity, message.effort], numbers)


def test_plans_and_what_was_sent_survive_the_file(tmp_path) -> None:
    plan = Plan(
        JOINTS, "cycle.npy", (Block(("a", "b"), 10.0, 1.5, 7, 0.0), Block(("c",), 1.0, 2.0))
    )
    save_plan(plan, tmp_path / "plan")
    assert load_plan(tmp_path / "plan") == plan
    sent = [Sent(1, 2, 3, 0.5, 4)]
    save_sent(sent, tmp_path / "sent")
    assert load_sent(tmp_path / "sent") == sent


def test_a_cycle_holds_its_levels_and_can_be_repeated_for_several_drives() -> None:
    settings = load_settings(ROOT / "config" / "paper_drive.yaml")
    cycle = loaded(settings, 100.0)
    assert cycle.joints == (settings.driver.name, settings.driven.name)
    assert cycle.numbers.shape == (600, 2, 2)
    torque = cycle.numbers[:, 1, 0]
    assert np.mean(torque[290:400]) == pytest.approx(0.8 / 0.3 * np.mean(torque[90:200]), rel=0.05)
    assert np.mean(torque[-10:]) == pytest.approx(np.mean(torque[:3]), rel=0.1)
    several = cycle.repeated(3)
    assert len(set(several.joints)) == 6
    for drive in range(3):  # each a third of the cycle ahead of the one before
        ahead = np.roll(cycle.numbers, -200 * drive, axis=0)
        np.testing.assert_array_equal(several.numbers[:, :, 2 * drive : 2 * drive + 2], ahead)


def test_what_was_heard_is_chosen_by_stamp_or_arrival_with_its_messages(tmp_path) -> None:
    messages = [serialize_message(BeltState(accepted_count=count)) for count in (1, 2, 3)]
    np.savez(
        tmp_path / "heard.npz",
        times_0=np.array([[10, 15], [20, 28], [30, 33]], dtype=np.int64),
        sizes_0=np.array([len(message) for message in messages]),
        bytes_0=np.frombuffer(b"".join(messages), dtype=np.uint8),
    )
    (heard,) = Heard.load(tmp_path / "heard.npz")
    assert heard.delays() == pytest.approx([5e-9, 8e-9, 3e-9])
    assert heard.delays(4e-9) == pytest.approx([3e-9, 6e-9, 1e-9])
    by_stamp, by_arrival = heard.between(20, 30), heard.arrived(0, 28)
    assert [by_stamp.state(k).accepted_count for k in range(2)] == [2, 3]
    assert [by_arrival.state(k).accepted_count for k in range(2)] == [1, 2]


def test_memory_growth_is_from_the_first_to_the_last_tenth() -> None:
    times = list(range(40))
    resident = [5000] * 10 + [100 + 10 * k for k in range(30)]
    assert Memory(times, resident).growth(10, 39) == 270
    assert Memory(times, [7] * 40).growth(0, 39) == 0


def test_processor_time_and_memory_of_a_process_are_its_own() -> None:
    pid = os.getpid()
    before, began = processor_ns(pid), time.process_time_ns()
    while time.process_time_ns() - began < 50_000_000:
        pass
    assert processor_ns(pid) - before == pytest.approx(time.process_time_ns() - began, rel=0.1)
    held = resident_bytes(pid)
    block = np.ones(4_000_000)
    assert resident_bytes(pid) - held > 0.9 * block.nbytes
