"""The measurements made of a bag are those that the live node's inputs make of its messages."""

import dataclasses
from functools import partial

import pytest
from bags import START_NS
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from recordings import float64, pulley_state, record
from rosbags.rosbag2 import Reader
from test_drive_bag import read

from belt_ros.drive_inputs import InputKind, InputSettings
from belt_ros.estimation import Joint, Measurement, Rejection

pytest.importorskip("belt_msgs")
pytest.importorskip("rclpy")
from rclpy.serialization import deserialize_message

from belt_ros.node.inputs import DriveInputs


class Hub:
    """Stands for the node's subscriptions: hands out what a bag holds, at its log time."""

    def __init__(self):
        self.listeners = {}
        self.time_ns = 0

    def now_ns(self):
        return self.time_ns

    def subscribe(self, message_type, topic, listener):
        self.listeners[f"/{topic}"] = message_type, listener
        return f"/{topic}"


def live(bag, settings, inputs):
    """What the node's inputs make of a bag's messages, without DDS between."""
    hub, taken = Hub(), []
    node_inputs = DriveInputs(
        hub,
        inputs.kind,
        "",
        (settings.driver, settings.driven),
        inputs.reorder_window,
        inputs.slop,
        lambda ready, _topic, _stamp_ns: taken.append(ready),
        disorder=inputs.disorder,
        gap=settings.limits.greatest_gap,
        loads=inputs.loads,
    )
    with Reader(bag) as reader:
        for connection, log_ns, data in reader.messages():
            hub.time_ns = log_ns
            message_type, listener = hub.listeners[connection.topic]
            listener(deserialize_message(bytes(data), message_type))
    node_inputs.flush()
    node_inputs.flush()
    return taken


any_number = st.one_of(st.floats(), st.floats(-200.0, 200.0))
jitter = st.integers(0, 60_000_000)
moments = st.lists(
    st.tuples(jitter, st.sampled_from(["driver", "driven"]), any_number, any_number, st.booleans()),
    min_size=1,
    max_size=25,
)


@pytest.mark.parametrize("kind", [InputKind.PULLEY_STATE, InputKind.FLOAT64])
@hypothesis_settings(max_examples=30, deadline=None, derandomize=True)
@given(moments=moments, disorder=st.sampled_from([0.0, 0.02]))
def test_measurements_are_those_of_the_node_whatever_comes(
    settings, tmp_path_factory, kind, moments, disorder
):
    driven = Joint(settings.driven.name, sign=-1.0, drag_torque=0.3, drag_damping=0.01)
    settings = dataclasses.replace(settings, driven=driven)
    make = partial(_message, kind)
    logged = sorted(
        (START_NS + k * 10_000_000 + late, *make(START_NS + k * 10_000_000, *rest))
        for k, (late, *rest) in enumerate(moments)
    )
    needed = [(START_NS, *make(START_NS, pulley, 1.0, 1.0, True)) for pulley in _PULLEYS]
    bag = record(tmp_path_factory.mktemp("any") / "bag", [*needed, *logged])
    inputs = InputSettings(kind, disorder=disorder)
    ours = [sample.content for sample in read(bag, settings, inputs)]
    theirs = live(bag, settings, inputs)
    # When a message that cannot be used is told of, between two that can, is not compared.
    assert _told(ours, Measurement) == _told(theirs, Measurement)
    assert sorted(_told(ours, Rejection)) == sorted(_told(theirs, Rejection))
    assert all(isinstance(each, Measurement | Rejection) for each in ours)


def _told(taken, kind):
    return [repr(each) for each in taken if isinstance(each, kind)]


_PULLEYS = ("driver", "driven")


def _message(kind, stamp_ns, pulley, first, second, full):
    if kind is InputKind.FLOAT64:
        return f"/{pulley}/{'speed' if full else 'torque'}", float64(first)
    values = (1.0, first, second, 800.0, 450.0) if full else (first, *[float("nan")] * 4)
    return f"/{pulley}/state", pulley_state(stamp_ns, *values)
