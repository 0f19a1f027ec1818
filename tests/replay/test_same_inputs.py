"""What is made of a bag is, in order, what the live node's inputs make of its messages."""

import dataclasses
import math
from operator import itemgetter

import pytest
from bags import START_NS, cdr
from bags import Sample as JointStates
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from reading import read
from recordings import JOINT_STATE, TYPES, float64, pulley_state, record
from rosbags.rosbag2 import Reader

from belt_ros.drive_inputs import InputSettings
from belt_ros.estimation import Joint, Measurement, Rejection
from belt_ros.node_tables import InputKind

pytest.importorskip("belt_msgs")
pytest.importorskip("rclpy")
from rclpy.serialization import deserialize_message

from belt_ros.node.belt_node import _WATCH_PERIOD
from belt_ros.node.inputs import DriveInputs

PULLEYS = ("driver", "driven")
WATCH_NS = round(_WATCH_PERIOD * 1e9)


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


def live(bag, settings, inputs, phase_ns):
    """What the node's inputs make of a bag's messages, without DDS between.

    As in the node, a timer flushes them; it first expires `phase_ns` after the bag begins.
    """
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
    watch_ns = START_NS + phase_ns
    with Reader(bag) as reader:
        for connection, log_ns, data in reader.messages():
            while watch_ns < log_ns:
                node_inputs.flush()
                watch_ns += WATCH_NS
            hub.time_ns = log_ns
            message_type, listener = hub.listeners[connection.topic]
            listener(deserialize_message(bytes(data), message_type))
    node_inputs.flush()
    node_inputs.flush()
    return taken


any_number = st.one_of(st.floats(), st.floats(-200.0, 200.0), st.sampled_from([math.nan, math.inf]))
jitter = st.one_of(st.integers(0, 60_000_000), st.sampled_from(range(0, 60_000_001, 10_000_000)))
# Between 0.1 s and 0.2 s it depends on the phase of the node's timer whether it flushes.
silence = st.sampled_from([0, 0, 0, 0, 300_000_000, 1_500_000_000])
moments = st.lists(
    st.tuples(silence, jitter, st.sampled_from(PULLEYS), any_number, any_number, st.booleans()),
    min_size=1,
    max_size=25,
)


@pytest.mark.parametrize(
    ("kind", "loads"),
    [
        (InputKind.JOINT_STATE, True),
        (InputKind.PULLEY_STATE, False),
        (InputKind.FLOAT64, False),
        (InputKind.FLOAT64, True),
    ],
)
@hypothesis_settings(max_examples=60, deadline=None, derandomize=True)
@given(
    moments=moments,
    disorder=st.sampled_from([0.0, 0.02]),
    phase_ns=st.integers(0, WATCH_NS - 1),
)
def test_a_bag_gives_what_the_node_makes_of_whatever_comes(
    settings, tmp_path_factory, kind, loads, moments, disorder, phase_ns
):
    driven = Joint(settings.driven.name, sign=-1.0, drag_torque=0.3, drag_damping=0.01)
    settings = dataclasses.replace(settings, driven=driven)
    needed = [(START_NS, *message(kind, START_NS, pulley, 1.0, 1.0, True)) for pulley in PULLEYS]
    bag = record(tmp_path_factory.mktemp("any") / "bag", [*needed, *logged(kind, moments)])
    inputs = InputSettings(kind, disorder=disorder, loads=loads)
    ours = [sample.content for sample in read(bag, settings, inputs)]
    assert list(map(repr, ours)) == list(map(repr, live(bag, settings, inputs, phase_ns)))
    assert all(isinstance(each, Measurement | Rejection) for each in ours)


def logged(kind, moments):
    """Messages every 10 ms, each logged with its jitter, and silent now and then."""
    messages, stamp_ns = [], START_NS
    for silent_ns, late_ns, *rest in moments:
        stamp_ns += silent_ns
        messages.append((stamp_ns + late_ns, *message(kind, stamp_ns, *rest)))
        stamp_ns += 10_000_000
    return sorted(messages, key=itemgetter(0))


def message(kind, stamp_ns, pulley, first, second, full):
    if kind is InputKind.FLOAT64:
        return f"/{pulley}/{'speed' if full else 'torque'}", float64(first)
    if kind is InputKind.PULLEY_STATE:
        values = (1.0, first, second, 800.0, 450.0) if full else (first, *[math.nan] * 4)
        return f"/{pulley}/state", pulley_state(stamp_ns, *values)
    if full:
        sample = JointStates(stamp_ns, stamp_ns, (120.0, first), (15.0, second))
        return "/joint_states", TYPES.deserialize_cdr(cdr(sample), JOINT_STATE)
    return f"/{pulley}/hub_load", float64(first)
