"""What replay writes is what the node, fed with the same messages, publishes: to the last bit."""

from pathlib import Path

import numpy as np
import pytest
from bags import Sample
from rosbags.highlevel import AnyReader
from test_run import ALARM, STATE, messages
from test_silence import interrupted, with_tail

from belt_ros.replay import replay

pytest.importorskip("belt_msgs")
pytest.importorskip("rclpy")
from builtin_interfaces.msg import Time
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from belt_ros.drive_inputs import measurement_from_joint_state
from belt_ros.estimation import Measurement
from belt_ros.node.conversions import (
    alarm_message,
    nanoseconds,
    state_message,
)
from belt_ros.node.pipeline import Outcome, Pipeline

BAG = Path(__file__).parents[1] / "data" / "rig_bag"


def joint_states(bag):
    with AnyReader([bag]) as reader:
        chosen = [item for item in reader.connections if item.topic == "/joint_states"]
        for connection, _, data in reader.messages(chosen):
            read = reader.deserialize(data, connection.msgtype)
            stamp = Time(sec=read.header.stamp.sec, nanosec=read.header.stamp.nanosec)
            yield JointState(
                header=Header(stamp=stamp),
                name=read.name,
                position=read.position,
                velocity=read.velocity,
                effort=read.effort,
            )


def assert_same(offline, live):
    for name in live.get_fields_and_field_types():
        ours, theirs = getattr(offline, name), getattr(live, name)
        if name == "header" or name.endswith("_time"):
            ours, theirs = getattr(ours, "stamp", ours), getattr(theirs, "stamp", theirs)
            assert (ours.sec, ours.nanosec) == (theirs.sec, theirs.nanosec)
        elif name == "conditions":
            for one, other in zip(ours, theirs, strict=True):
                assert_same(one, other)
        else:
            np.testing.assert_array_equal(ours, theirs, err_msg=name)


@pytest.mark.skipif(not BAG.is_dir(), reason="tests/data/rig_bag is not there")
def test_states_and_alarms_are_those_of_the_live_pipeline(settings, tmp_path):
    pipeline = Pipeline("belt_node", ("/joint_states",), settings)
    outcomes = [
        pipeline.take(
            measurement_from_joint_state(settings.driver, settings.driven, message),
            nanoseconds(message.header.stamp),
            now_ns=0,
        )
        for message in joint_states(BAG)
    ]
    name = settings.name
    replay(BAG, settings, tmp_path / "out")
    for topic, live in (
        (STATE, [state_message(name, o.estimate) for o in outcomes if o.estimate is not None]),
        (ALARM, [alarm_message(name, o.alarm) for o in outcomes if o.alarm is not None]),
    ):
        offline = [message for _, message in messages(tmp_path / "out", topic)]
        assert len(offline) == len(live) > 0
        for ours, theirs in zip(offline, live, strict=True):
            assert_same(ours, theirs)


def watched(settings, samples: list[Sample], end_ns: int) -> list[Outcome]:
    """What the pipeline makes of samples as they are logged, watched ten times a second."""
    now_ns = samples[0].log_ns
    pipeline = Pipeline("belt_node", ("/joint_states",), settings, steady=lambda: now_ns * 1e-9)
    outcomes, waiting = [], list(samples)
    for tick_ns in range(now_ns, end_ns, 100_000_000):
        while waiting and waiting[0].log_ns <= tick_ns:
            sample = waiting.pop(0)
            now_ns = sample.log_ns
            measurement = Measurement(sample.stamp_ns, *sample.velocity, *sample.effort)
            outcomes.append(pipeline.take(measurement, sample.stamp_ns, now_ns))
        now_ns = tick_ns
        outcomes.append(pipeline.watch(now_ns))
    return outcomes


def test_outages_are_told_as_by_the_live_pipeline_and_change_no_state(settings, tmp_path):
    samples = interrupted()
    bag = with_tail(tmp_path / "bag", samples, 3.0)
    replay(bag, settings, tmp_path / "out", smooth=False)
    outcomes = watched(settings, samples, samples[-1].log_ns + 3_000_000_000)
    live = [state_message(settings.name, o.estimate) for o in outcomes if o.estimate is not None]
    offline = [message for _, message in messages(tmp_path / "out", STATE)]
    assert len(offline) == len(live) > 300
    for ours, theirs in zip(offline, live, strict=True):
        assert_same(ours, theirs)
    told = [o.alarm for o in outcomes if o.alarm is not None]
    replayed = [message for _, message in messages(tmp_path / "out", ALARM)]
    assert len(replayed) == len(told) >= 4
    for ours, theirs in zip(replayed, told, strict=True):
        names = ("condition", "severity", "latched_severity", "acknowledged", "count")
        assert [getattr(ours, name) for name in names] == [getattr(theirs, name) for name in names]
        assert abs(nanoseconds(ours.header.stamp) - theirs.stamp_ns) < 110_000_000  # a turn
