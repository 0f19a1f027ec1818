"""A graph in one process, to try inputs without a node around them."""

import math
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import rclpy
from belt_msgs.msg import PulleyState
from node_harness import NAMES, stamp
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from belt_ros.estimation import Joint, Measurement, Rejection, measurement_from_joints
from belt_ros.node.inputs import DriveInputs, TopicHub
from belt_ros.node_tables import InputKind

NAN = math.nan
DRIVER = Joint(NAMES[0], gear_ratio=2.0, torque_scale=0.5)
DRIVEN = Joint(NAMES[1], sign=-1.0, drag_torque=0.3, drag_damping=0.01)


class Graph:
    """A sender and a node that listens, both spun by one executor."""

    def __init__(self, domain: int) -> None:
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self._executor = SingleThreadedExecutor(context=self._context)
        self.sender = self.node("sender")
        self._publishers: dict[str, Any] = {}

    def node(self, name: str, **options: Any) -> Node:
        options = {"automatically_declare_parameters_from_overrides": True} | options
        node = rclpy.create_node(name, context=self._context, **options)
        self._executor.add_node(node)
        return node

    def close(self) -> None:
        for node in self._executor.get_nodes():
            node.destroy_node()
        self._executor.shutdown()
        rclpy.shutdown(context=self._context)

    def spin(self, seconds: float) -> None:
        self.until(lambda: False, seconds, fail=False)

    def until(
        self, condition: Callable[[], bool], timeout: float = 20.0, *, fail: bool = True
    ) -> None:
        end = time.monotonic() + timeout
        while not condition():
            left = end - time.monotonic()
            assert left > 0.0 or not fail, "timed out"
            if left <= 0.0:
                return
            self._executor.spin_once(timeout_sec=min(left, 0.05))

    def send(self, topic: str, message: Any) -> None:
        """Publish, the first time not before somebody listens."""
        if topic not in self._publishers:
            publisher = self.sender.create_publisher(type(message), topic, 1000)
            self._publishers[topic] = publisher
            self.until(lambda: publisher.get_subscription_count() > 0)
            self.spin(0.1)  # the listener may be known before it knows the sender
        self._publishers[topic].publish(message)


class Listener:
    """One drive's inputs, and what they have given."""

    def __init__(
        self,
        node: Node,
        kind: InputKind,
        made: ExitStack,
        hub: TopicHub | None = None,
        **options: Any,
    ) -> None:
        self.taken: list[tuple[Measurement | Rejection, str, int]] = []
        self.heard: list[tuple[str, int | None]] = []
        self.on_heard: Callable[[str, int | None], None] | None = None
        arguments = {"prefix": "", "window": 0.5, "slop": 0.0} | options
        self.inputs = DriveInputs(
            hub or TopicHub(node, "reliable", 1000, made),
            kind,
            joints=(DRIVER, DRIVEN),
            take=lambda *taken: self.taken.append(taken),
            heard=self._hear,
            **arguments,
        )

    def _hear(self, topic: str, stamp_ns: int | None) -> None:
        self.heard.append((topic, stamp_ns))
        if self.on_heard is not None:
            self.on_heard(topic, stamp_ns)

    @property
    def measurements(self) -> list[Measurement]:
        return [item for item, _, _ in self.taken if isinstance(item, Measurement)]

    @property
    def rejections(self) -> list[tuple[Rejection, str]]:
        return [(item, topic) for item, topic, _ in self.taken if isinstance(item, Rejection)]


def pulley_state(stamp_ns: int, speed: float = NAN, torque: float = NAN, **more: float) -> Any:
    fields = {"position": NAN, "hub_load": NAN, "span_tension": NAN} | more
    message = PulleyState(speed=speed, torque=torque, **fields)
    message.header.stamp = stamp(stamp_ns)
    return message


def expected(stamp_ns: int, *values: tuple[float, float]) -> Measurement | Rejection:
    """What a joint state with these speeds, torques and positions gives."""
    return measurement_from_joints(DRIVER, DRIVEN, stamp_ns, list(NAMES), *values)


def said(measurement: object) -> str:
    """All fields, in which a NaN equals a NaN."""
    return repr(measurement)
