"""Parameters of a node in this process: declared, described, refused."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from node_harness import PAPER_DRIVE, context_in, joint_state
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

from belt_ros.node import pipeline
from belt_ros.node.belt_node import BeltNode
from belt_ros.node_tables import DRIVE_PARAMETERS, NODE_PARAMETERS
from belt_ros.settings import read_parameters

MakeNode = Callable[..., BeltNode]
CONFIGURED = TransitionCallbackReturn.SUCCESS
REFUSED = TransitionCallbackReturn.FAILURE


@pytest.fixture
def make_node(ros_domain: int) -> Iterator[MakeNode]:
    """Make unconfigured nodes of the example drive, with changes; None leaves a value out."""
    nodes = ExitStack()

    def make(**changes: Any) -> BeltNode:
        values = read_parameters(PAPER_DRIVE) | {"autostart": False}
        values |= {name.replace("__", "."): value for name, value in changes.items()}
        given = [
            Parameter(name, value=value) for name, value in values.items() if value is not None
        ]
        node = BeltNode(context=context, parameter_overrides=given)
        nodes.callback(node.destroy_node)
        return node

    with context_in(ros_domain) as context:
        yield make
        nodes.close()


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Collect what nodes log, whatever the level."""
    lines: list[str] = []

    class Logger:
        def __getattr__(self, level: str) -> Callable[[str], None]:
            return lines.append

    monkeypatch.setattr(BeltNode, "get_logger", lambda node: Logger())
    return lines


def set_value(node: BeltNode, name: str, value: Any) -> Any:
    return node.set_parameters([Parameter(name, value=value)])[0]


def hear(node: BeltNode, message: JointState) -> None:
    """Hand a message to the node as its executor does."""
    (subscription,) = [s for s in node.subscriptions if s.topic_name == "/joint_states"]
    subscription.callback(message)


def test_every_parameter_is_declared_and_described(make_node: MakeNode) -> None:
    node = make_node()

    for name, parameter in (DRIVE_PARAMETERS | NODE_PARAMETERS).items():
        descriptor = node.describe_parameter(name)
        assert parameter.meaning in descriptor.description
        assert parameter.unit in descriptor.description
        assert descriptor.read_only == parameter.fixed
        assert descriptor.dynamic_typing
        if parameter.low > -1e300 and parameter.high < 1e300:
            assert descriptor.floating_point_range[0].from_value == parameter.low
            assert descriptor.floating_point_range[0].to_value == parameter.high


def test_a_whole_number_is_taken_for_a_real_one(make_node: MakeNode) -> None:
    node = make_node(span_length=1, alarm__on_delay=1, diagnostics_period=1)

    assert node.trigger_configure() is CONFIGURED


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"driver__radius": -1.0}, "driver.radius is -1 m"),
        ({"driver__radius": -1}, "driver.radius is -1 m"),
        ({"driver__radius": None}, "driver.radius is missing"),
        ({"driver__radius": "8 cm"}, "driver.radius is '8 cm'; it must be a number"),
        ({"driver__radius": float("nan")}, "driver.radius is nan"),
        ({"prior__friction_stiffness": 0}, "prior.friction_stiffness is 0 N/m2"),
        ({"kinematics": "exakt"}, "must be one of"),
        ({"belt__axial_stifness": 1.0}, "did you mean belt.axial_stiffness?"),
        ({"autostrat": True}, "did you mean autostart?"),
        ({"alarm__loud": True}, "unknown parameter alarm.loud"),
        ({"alarm__margin_alarm": 0.5}, "alarm.margin_alarm must not be above alarm.margin_warning"),
        ({"alarm__excess_slip_trip": 0.005}, "alarm.excess_slip_alarm is 0.03 and alarm"),
        ({"autostart": "yes"}, "autostart is 'yes'; it must be true or false"),
        ({"input_depth": 0}, "input_depth is 0 messages"),
        ({"memory_file": 7}, "memory_file is 7; it must be text"),
        ({"memory_file": "~nobody_of_that_name/x"}, "memory_file is '~nobody_of_that_name/x'"),
        ({"memory_flie": "x"}, "did you mean memory_file?"),
        ({"input_reliability": "perfect"}, "best_effort, reliable"),
    ],
)
def test_an_unusable_description_fails_the_transition_and_says_why(
    make_node: MakeNode, said: list[str], changes: dict[str, Any], reason: str
) -> None:
    node = make_node(**changes)

    assert node.trigger_configure() is REFUSED
    assert reason in said[-1]


def test_parameters_of_others_are_mentioned_and_ignored(
    make_node: MakeNode, said: list[str]
) -> None:
    node = make_node(robot_description="<robot/>")

    assert node.trigger_configure() is CONFIGURED
    assert "not parameters of this node: robot_description" in said


def test_geometry_cannot_be_changed(make_node: MakeNode) -> None:
    result = set_value(make_node(), "driver.radius", 0.1)

    assert not result.successful
    assert "read-only" in result.reason


def test_the_memory_is_chosen_before_the_node_is_configured(
    make_node: MakeNode, said: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    node = make_node()
    assert set_value(node, "memory_file", "~/belt.json").successful
    node.trigger_configure()
    assert f"paper_drive: no memory yet in '{tmp_path / 'belt.json'}'" in said

    refused = set_value(node, "memory_file", "elsewhere.json")
    assert refused.reason == "memory_file can be changed only while the node is unconfigured"
    assert set_value(node, "memory_file", "~/belt.json").successful
    node.trigger_cleanup()
    assert set_value(node, "memory_file", "").successful


@pytest.mark.parametrize("configured", [True, False])
def test_a_threshold_is_checked_against_its_range_and_type(
    make_node: MakeNode, configured: bool
) -> None:
    node = make_node()
    if configured:
        node.trigger_configure()

    for wrong in (2, 2.0, "much", None, True):
        assert not set_value(node, "alarm.margin_warning", wrong).successful
    assert set_value(node, "alarm.margin_warning", 0.3).successful
    assert node.get_parameter("alarm.margin_warning").value == 0.3


def test_a_change_reaches_the_monitor(make_node: MakeNode, monkeypatch: pytest.MonkeyPatch) -> None:
    retuned = []
    monkeypatch.setattr(pipeline.Pipeline, "retune", lambda _, settings: retuned.append(settings))
    node = make_node()
    node.trigger_configure()

    set_value(node, "limits.greatest_gap", 2)

    assert [settings.limits.greatest_gap for settings in retuned] == [2.0]


def test_a_prior_that_is_changed_too_late_is_told_of(make_node: MakeNode, said: list[str]) -> None:
    """It counts once the node is configured anew; a tension set now is told in another way."""
    node = make_node()
    assert set_value(node, "prior.tension", 500.0).successful
    assert not any("prior.tension" in line for line in said)
    node.trigger_configure()

    assert set_value(node, "limits.greatest_gap", 2).successful
    assert not any("configured anew" in line for line in said)
    assert set_value(node, "prior.tension", 400).successful
    assert sum("prior.tension: counts once" in line for line in said) == 1


def test_limits_that_have_changed_are_used(make_node: MakeNode) -> None:
    node = make_node()
    node.trigger_configure()
    node.trigger_activate()
    hear(node, joint_state(1))

    set_value(node, "limits.greatest_speed", 50)
    hear(node, joint_state(10_000_000))

    assert node.units[0].pipeline.health.rejections[2] == 1


def test_estimation_that_fails_numerically_starts_anew(
    make_node: MakeNode, said: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    node = make_node()
    node.trigger_configure()
    node.trigger_activate()

    def fail(*_: object) -> None:
        raise FloatingPointError("overflow")

    with monkeypatch.context() as patch:
        patch.setattr(pipeline.Pipeline, "take", fail)
        hear(node, joint_state(1))
    hear(node, joint_state(2))

    assert "starting anew at the priors: overflow" in said[-2]
    health = node.units[0].pipeline.health
    assert (health.resets, health.accepted, sum(health.rejections)) == (1, 1, 1)


def test_a_transition_that_raises_is_logged_and_leaves_nothing_behind(
    make_node: MakeNode, said: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    node = make_node()
    before = len(list(node.publishers)), len(list(node.subscriptions)), len(list(node.timers))

    def fail(*_: object) -> None:
        raise MemoryError("no room")

    with monkeypatch.context() as patch:
        patch.setattr("belt_ros.node.drive_unit.Pipeline", fail)
        assert node.trigger_configure() is TransitionCallbackReturn.ERROR

    assert "MemoryError: no room" in said[-1]
    after = len(list(node.publishers)), len(list(node.subscriptions)), len(list(node.timers))
    assert after == before
    assert node.trigger_configure() is CONFIGURED


def test_an_unconfigured_node_reminds_of_it(make_node: MakeNode, said: list[str]) -> None:
    node = make_node(driver__radius=None)
    node.trigger_configure()

    node._remind()

    assert said[-1].startswith("unconfigured, estimating nothing: driver.radius is missing")
