"""Topics count by their name and type: what is called as a drive's and is none is left alone."""

import dataclasses
import math

import pytest
from bags import PERIOD_NS, START_NS, steady_run
from reading import expected, measured, read
from recordings import float32, float64, numbers, record, text
from rosbags.rosbag2 import StoragePlugin
from test_drive_bag import NUMBERS
from test_drive_bag import _joint_state as joint_state

from belt_ros.drive_inputs import InputSettings
from belt_ros.replay import BagError
from belt_ros.replay.drive_bag import DriveBag

WITH_LOADS = dataclasses.replace(InputSettings(), loads=True)


def test_a_torque_of_another_type_is_left_out_and_said_so(settings, tmp_path):
    logged = [
        (log_ns, topic, float32(15.0) if topic == "/driver/torque" else message)
        for log_ns, topic, message in numbers(20)
    ]
    bag = record(tmp_path / "bag", logged)
    with DriveBag(bag, settings, NUMBERS) as source:
        assert "/driver/torque" not in source.topics
        assert source.note == (
            "/driver/torque is of type std_msgs/msg/Float32, not std_msgs/msg/Float64, and was "
            "not read."
        )
        rows = measured(source.samples())
    assert len(rows) == 20
    assert all(math.isnan(row.driver_torque) and row.driven_torque == -15.0 for row in rows)


@pytest.mark.parametrize("plugin", list(StoragePlugin), ids=lambda plugin: plugin.name)
def test_of_a_topic_with_two_types_only_the_right_one_is_read(settings, tmp_path, plugin):
    samples = steady_run(10)
    others = [(START_NS + k * PERIOD_NS, "/joint_states", text("idle")) for k in range(10)]
    joints = [(sample.log_ns, "/joint_states", joint_state(sample)) for sample in samples]
    bag = record(
        tmp_path / "bag", sorted([*others, *joints], key=lambda each: each[0]), plugin=plugin
    )
    assert read(bag, settings) == expected(samples)
    with DriveBag(bag, settings) as source:
        assert source.count == 10
        assert source.joints_seen == ["driver_pulley_joint", "driven_pulley_joint"]


def test_a_load_cell_of_another_type_is_left_out_too(settings, tmp_path):
    samples = steady_run(5)
    joints = [(sample.log_ns, "/joint_states", joint_state(sample)) for sample in samples]
    loads = [(log_ns + 1, "/driver/hub_load", text("heavy")) for log_ns, _, _ in joints]
    bag = record(tmp_path / "bag", [*joints, *loads])
    with DriveBag(bag, settings, WITH_LOADS) as source:
        assert source.topics == ("/joint_states",)
        assert "/driver/hub_load is of type std_msgs/msg/String" in source.note


def test_a_speed_of_another_type_is_refused_with_what_there_is(settings, tmp_path):
    logged = [(START_NS, f"/{pulley}/speed", float32(120.0)) for pulley in ("driver", "driven")]
    bag = record(tmp_path / "bag", [*logged, (START_NS, "/driver/torque", float64(1.0))])
    there = (
        r"no topics driver/speed and driven/speed of type std_msgs/msg/Float64\. .*/driver/speed "
    )
    with pytest.raises(BagError, match=there + r"\[std_msgs/msg/Float32\]"):
        read(bag, settings, NUMBERS)
