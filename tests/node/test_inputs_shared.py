"""One subscription for many drives, under names and with a quality of service that users choose."""

from collections.abc import Iterator
from contextlib import ExitStack
from functools import partial

import pytest
from inputs_harness import Graph, Listener
from node_harness import joint_state
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import ReliabilityPolicy
from sensor_msgs.msg import JointState

from belt_ros.node.inputs import TopicHub
from belt_ros.node_tables import InputKind
from belt_ros.settings import SettingsError

pytestmark = pytest.mark.ros


@pytest.fixture
def graph(ros_domain: int) -> Iterator[Graph]:
    graph = Graph(ros_domain)
    yield graph
    graph.close()


def test_names_are_relative_and_can_be_remapped(graph: Graph) -> None:
    node = graph.node(
        "belt",
        namespace="plant",
        cli_args=["--ros-args", "-r", "driver/state:=/motor", "-r", "b/driven/state:=load"],
    )
    with ExitStack() as made:
        sources = Listener(node, InputKind.PULLEY_STATE, made).inputs.sources
        prefixed = Listener(node, InputKind.PULLEY_STATE, made, prefix="b/").inputs.sources
        subscribed = {
            name for name, _ in node.get_subscriber_names_and_types_by_node("belt", "/plant")
        }

    assert sources == ("/motor", "/plant/driven/state")
    assert prefixed == ("/plant/b/driver/state", "/plant/load")
    assert subscribed >= {*sources, *prefixed}


def test_many_drives_on_one_topic_share_a_subscription(graph: Graph) -> None:
    node = graph.node("belt")
    before = len(list(node.subscriptions))
    with ExitStack() as made:
        hub = TopicHub(node, "reliable", 100, made)
        listeners = [Listener(node, InputKind.JOINT_STATE, made, hub) for _ in range(50)]
        assert len(list(node.subscriptions)) == before + 1
        graph.send("joint_states", joint_state(1))
        graph.until(lambda: all(listener.taken for listener in listeners))
        assert all(len(listener.taken) == 1 for listener in listeners)
    assert len(list(node.subscriptions)) == before


def came(times: list[int], count: int) -> bool:
    return len(times) == count


def test_a_message_arrives_at_one_time_for_all_who_listen(graph: Graph) -> None:
    node = graph.node("belt")
    with ExitStack() as made:
        hub = TopicHub(node, "reliable", 100, made)
        listeners = [Listener(node, InputKind.JOINT_STATE, made, hub) for _ in range(2)]
        times = []
        for listener in listeners:
            listener.on_heard = lambda *_: times.append(hub.now_ns())
        for stamp_ns in (1, 2):
            graph.send("joint_states", joint_state(stamp_ns))
            graph.until(partial(came, times, 2 * stamp_ns))
        first, second = times[:2], times[2:]
        assert first[0] == first[1] < second[0] == second[1] < hub.now_ns()


def test_time_goes_on_after_a_listener_that_raises(graph: Graph) -> None:
    node = graph.node("belt")
    times = []

    def fail(_: object) -> None:
        times.append(hub.now_ns())
        raise ArithmeticError

    with ExitStack() as made:
        hub = TopicHub(node, "reliable", 100, made)
        hub.subscribe(JointState, "joint_states", fail)
        graph.send("joint_states", joint_state(1))
        with pytest.raises(ArithmeticError):
            graph.until(lambda: False, 5.0)
        assert times[0] < hub.now_ns()


def quality(node: Node, topic: str) -> tuple[ReliabilityPolicy, int]:
    (found,) = [s for s in node.subscriptions if s.topic_name == topic]
    return found.qos_profile.reliability, found.qos_profile.depth


def test_quality_of_service_can_be_overridden_and_stays_through_another_configuration(
    graph: Graph,
) -> None:
    override = "qos_overrides./driver/state.subscription"
    node = graph.node(
        "belt",
        parameter_overrides=[
            Parameter(f"{override}.reliability", value="reliable"),
            Parameter(f"{override}.depth", value=7),
        ],
    )
    for _ in range(3):
        with ExitStack() as made:
            hub = TopicHub(node, "best_effort", 150, made)
            Listener(node, InputKind.PULLEY_STATE, made, hub)
            assert quality(node, "/driver/state") == (ReliabilityPolicy.RELIABLE, 7)
            assert quality(node, "/driven/state") == (ReliabilityPolicy.BEST_EFFORT, 150)
    declared = node.get_parameter("qos_overrides./driven/state.subscription.depth").value
    assert declared == 150


@pytest.mark.parametrize(
    ("policy", "value"),
    [
        ("reliability", "utterly"),
        ("reliability", 1),
        ("depth", 0),
        ("depth", "many"),
        ("history", ""),
    ],
)
def test_an_override_that_cannot_be_used_is_refused_with_the_reason(
    graph: Graph, policy: str, value: object
) -> None:
    name = f"qos_overrides./joint_states.subscription.{policy}"
    node = graph.node("belt", parameter_overrides=[Parameter(name, value=value)])
    with ExitStack() as made, pytest.raises(SettingsError, match=name):
        Listener(node, InputKind.JOINT_STATE, made)


def test_a_prefix_that_is_no_name_is_refused(graph: Graph) -> None:
    with ExitStack() as made, pytest.raises(SettingsError, match="no name of a topic"):
        Listener(graph.node("belt"), InputKind.FLOAT64, made, prefix="no name/")
