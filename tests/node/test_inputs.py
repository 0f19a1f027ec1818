"""A drive's input over DDS, of every kind: what is sent on its topics becomes measurements."""

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from inputs_harness import DRIVEN, DRIVER, Graph, Listener, expected, pulley_state, said
from node_harness import MILLISECOND, NAMES, SECOND, joint_state
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from belt_ros.estimation import Measurement, Rejection
from belt_ros.node.input_meter import InputMeter
from belt_ros.node.inputs import DriveInputs
from belt_ros.node.source_meter import clock_skew
from belt_ros.node_tables import InputKind

pytestmark = pytest.mark.ros


@pytest.fixture
def graph(ros_domain: int) -> Iterator[Graph]:
    graph = Graph(ros_domain)
    yield graph
    graph.close()


def test_joint_states_are_measurements_at_once(graph: Graph) -> None:
    with ExitStack() as made:
        listener = Listener(graph.node("belt"), InputKind.JOINT_STATE, made)
        for time_ns in (30, 10, 20):  # whatever their order: the monitor judges that
            graph.send("joint_states", joint_state(time_ns, (4.0, 3.0), (2.0, 1.0)))
        graph.until(lambda: len(listener.taken) == 3)

    assert listener.inputs.sources == ("/joint_states",)
    sent = [expected(time_ns, (4.0, 3.0), (2.0, 1.0)) for time_ns in (30, 10, 20)]
    assert said(listener.measurements) == said(sent)
    assert [taken[1:] for taken in listener.taken] == [("/joint_states", t) for t in (30, 10, 20)]


def test_two_pulleys_at_different_rates_give_one_row_in_order(graph: Graph) -> None:
    with ExitStack() as made:
        listener = Listener(graph.node("belt"), InputKind.PULLEY_STATE, made)
        for topic in listener.inputs.sources:  # both are connected before the first that counts
            graph.send(topic, pulley_state(0, speed=1.0))
        graph.until(lambda: len(listener.heard) == 2)
        listener.inputs.begin()
        listener.taken.clear()
        for number in range(300):  # 1 kHz and 333 Hz, over 0.3 s
            time_ns = SECOND + number * MILLISECOND
            graph.send("driver/state", pulley_state(time_ns, 4.0 + number, 2.0, position=6.0))
            if number % 3 == 0:
                graph.send("driven/state", pulley_state(time_ns, 3.0, 1.0, position=5.0))
            if number % 50 == 0:
                graph.spin(0.01)
        graph.until(lambda: len(listener.heard) == 402)
        graph.spin(0.1)

    assert listener.inputs.sources == ("/driver/state", "/driven/state")
    assert listener.rejections == []
    # What has come after the last of the slower one waits for it.
    assert [m.stamp_ns for m in listener.measurements] == [
        SECOND + number * MILLISECOND for number in range(298)
    ]
    assert listener.inputs.pending == 2
    for number, measurement in enumerate(listener.measurements):
        both = expected(measurement.stamp_ns, (4.0 + number, 3.0), (2.0, 1.0), (6.0, 5.0))
        assert measurement.driver_speed == both.driver_speed
        if number % 3 == 0:
            assert said(measurement) == said(both)
        else:
            assert math.isnan(measurement.driven_speed)


def test_what_one_pulley_holds_up_is_released_in_silence(graph: Graph) -> None:
    with ExitStack() as made:
        listener = Listener(graph.node("belt"), InputKind.PULLEY_STATE, made)
        graph.send("driver/state", pulley_state(7, speed=4.0))
        graph.until(lambda: listener.inputs.pending == 1)

        listener.inputs.flush()  # it has just come
        assert listener.taken == []
        listener.inputs.flush()

    ((measurement, topic, stamp_ns),) = listener.taken
    assert said(measurement) == said(Measurement(7, driver_speed=2.0))
    assert (topic, stamp_ns) == ("", 7)
    assert listener.inputs.pending == 0


def test_what_comes_within_a_long_window_is_waited_for_however_often_a_timer_looks(
    graph: Graph,
) -> None:
    with ExitStack() as made:
        listener = Listener(graph.node("belt"), InputKind.PULLEY_STATE, made, window=0.5)
        graph.send("driver/state", pulley_state(7, speed=4.0))
        graph.until(lambda: listener.inputs.pending == 1)
        for _ in range(5):  # half a second but for a moment
            listener.inputs.flush(0.1)
        assert listener.taken == []
        graph.send("driven/state", pulley_state(7, speed=3.0))
        graph.until(lambda: len(listener.taken) == 1)
        graph.send("driver/state", pulley_state(8, speed=4.0))
        graph.until(lambda: listener.inputs.pending == 1)
        for _ in range(6):
            listener.inputs.flush(0.1)

    both, alone = listener.measurements
    assert (both.driver_speed, both.driven_speed) == (2.0, -3.0)
    assert math.isnan(alone.driven_speed)


def test_what_waits_is_forgotten_at_the_beginning(graph: Graph) -> None:
    with ExitStack() as made:
        listener = Listener(graph.node("belt"), InputKind.PULLEY_STATE, made)
        graph.send("driver/state", pulley_state(7, speed=4.0))
        graph.until(lambda: listener.inputs.pending == 1)
        listener.inputs.begin()
        listener.inputs.flush()
        listener.inputs.flush()

    assert listener.taken == []


def test_numbers_are_stamped_when_they_come_and_joined_within_the_slop(graph: Graph) -> None:
    topics = [f"{p}/{what}" for p in ("driver", "driven") for what in ("speed", "torque")]
    with ExitStack() as made:
        node = graph.node("belt")
        listener = Listener(node, InputKind.FLOAT64, made, prefix="saw/", slop=2.0, window=5.0)
        for topic in topics:
            graph.send(f"saw/{topic}", Float64(data=0.0))
        graph.until(lambda: len(listener.heard) == 4)
        listener.inputs.begin()
        before = node.get_clock().now().nanoseconds
        for topic, value in zip(topics, (4.0, 2.0, 3.0, 1.0), strict=True):
            graph.send(f"saw/{topic}", Float64(data=value))
        graph.until(lambda: len(listener.heard) == 8)
        listener.taken.clear()
        listener.inputs.flush()
        listener.inputs.flush()
        after = node.get_clock().now().nanoseconds

    ((measurement, _, stamp_ns),) = listener.taken
    assert before <= stamp_ns <= after
    assert said(measurement) == said(expected(stamp_ns, (4.0, 3.0), (2.0, 1.0)))
    assert listener.inputs.sources[:3] == (
        "/saw/driver/speed",
        "/saw/driver/torque",
        "/saw/driver/position",
    )


def test_hub_loads_come_beside_joint_states(graph: Graph) -> None:
    with ExitStack() as made:
        node = graph.node("belt")
        listener = Listener(node, InputKind.JOINT_STATE, made, prefix="saw/", loads=True, slop=0.4)
        graph.send("saw/driven/span_tension", Float64(data=300.0))
        graph.until(lambda: listener.inputs.pending == 1)
        now_ns = node.get_clock().now().nanoseconds
        graph.send("joint_states", joint_state(now_ns, (4.0, 3.0), (2.0, 1.0)))
        graph.until(lambda: len(listener.heard) == 2)
        listener.inputs.flush()
        listener.inputs.flush()

    (measurement,) = listener.measurements
    assert measurement.span_tension == 300.0
    assert measurement.driver_speed == 2.0


def test_clocks_that_disagree_are_seen_in_what_is_heard(graph: Graph) -> None:
    with ExitStack() as made:
        node = graph.node("belt")
        listener = Listener(node, InputKind.PULLEY_STATE, made)
        clock = node.get_clock()
        meter = InputMeter(0.0, listener.inputs.sources)

        def count(topic: str, stamp_ns: int) -> None:
            meter.heard(topic, (clock.now().nanoseconds - stamp_ns) / SECOND, 0.5)

        listener.on_heard = count
        for _ in range(20):
            now_ns = clock.now().nanoseconds
            graph.send("driver/state", pulley_state(now_ns, speed=1.0))
            graph.send("driven/state", pulley_state(now_ns + 30 * SECOND, speed=1.0))
            graph.spin(0.005)
        graph.until(lambda: len(listener.heard) == 40)
    skew = clock_skew(meter.report(1.0).sources)

    assert skew is not None
    assert (skew.ahead, skew.behind) == ("/driven/state", "/driver/state")
    assert skew.seconds == pytest.approx(30.0, abs=3.0)


def test_what_cannot_be_used_is_a_rejection_of_its_topic(graph: Graph) -> None:
    with ExitStack() as made:
        listener = Listener(graph.node("belt"), InputKind.PULLEY_STATE, made)
        bad = pulley_state(1, speed=math.inf)
        impossible = pulley_state(1, speed=1.0)
        impossible.header.stamp.nanosec = 2 * SECOND
        for message in (bad, pulley_state(2), impossible):
            graph.send("driver/state", message)
        graph.until(lambda: len(listener.taken) == 3)

    reasons = [Rejection.NOT_FINITE, Rejection.NOT_FINITE, Rejection.MALFORMED]
    assert listener.rejections == [(reason, "/driver/state") for reason in reasons]
    assert listener.heard == [("/driver/state", when) for when in (1, 2, None)]


class _Deaf:
    """A hub without ROS: it keeps the listeners."""

    def __init__(self) -> None:
        self.listeners: list[Callable[[Any], None]] = []

    def subscribe(self, message_type: type, topic: str, listener: Callable[[Any], None]) -> str:
        self.listeners.append(listener)
        return topic

    def now_ns(self) -> int:
        return 5


hostile = st.one_of(st.floats(), st.sampled_from([0.0, 1e308, -1e308, 5e-324]))
stamps = st.tuples(st.integers(-(2**31), 2**31 - 1) | st.integers(0, 3), st.integers(0, 2**32 - 1))


@settings(derandomize=True, deadline=None, max_examples=150)
@given(st.data(), st.sampled_from(list(InputKind)), st.booleans())
def test_nothing_that_comes_raises_or_is_lost(
    data: st.DataObject, kind: InputKind, loads: bool
) -> None:
    hub = _Deaf()
    taken: list[Any] = []
    inputs = DriveInputs(
        hub, kind, "", (DRIVER, DRIVEN), 0.05, 0.001, lambda *t: taken.append(t), loads=loads
    )
    for number in range(data.draw(st.integers(0, 12))):
        place = data.draw(st.integers(0, len(hub.listeners) - 1))
        topic = inputs.sources[place]
        message: Any = Float64(data=data.draw(hostile))
        if topic.endswith("state"):
            message = pulley_state(0, data.draw(hostile), data.draw(hostile))
        elif topic == "joint_states":
            message = JointState(
                name=list(NAMES), velocity=data.draw(st.lists(hostile, max_size=3))
            )
        if topic.endswith(("state", "states")):
            second, nano = data.draw(stamps)
            message.header.stamp.sec, message.header.stamp.nanosec = second, nano
            message.header.frame_id = "x" * data.draw(st.sampled_from([0, 10**6]))
        hub.listeners[place](message)
        assert len(taken) + inputs.pending <= number + 1
    inputs.flush()
    inputs.flush()

    assert inputs.pending == 0
    assert all(isinstance(item, Measurement | Rejection) for item, _, _ in taken)
