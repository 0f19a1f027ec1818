"""A node that knows only the messages: it listens, records, and plays a bag if there is one."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import rclpy
from belt_msgs.msg import BeltState, SlipAlarm
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from belt_ros.demo.recorder import Recorder

_DEEP = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
_LATCHED = QoSProfile(
    depth=10,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
JOINTS = "/joint_states"
STATE = "/belt_node/state"
ALARM = "/belt_node/alarm"
TRUTH = "/belt_rig/truth"
DIAGNOSTICS = "/diagnostics"
_TOPICS: dict[str, tuple[type, str, QoSProfile]] = {
    JOINTS: (JointState, "sensor_msgs/msg/JointState", _DEEP),
    STATE: (BeltState, "belt_msgs/msg/BeltState", _DEEP),
    ALARM: (SlipAlarm, "belt_msgs/msg/SlipAlarm", _LATCHED),
    TRUTH: (BeltState, "belt_msgs/msg/BeltState", _DEEP),
    DIAGNOSTICS: (DiagnosticArray, "diagnostic_msgs/msg/DiagnosticArray", _DEEP),
}
_KEPT = (STATE, TRUTH, ALARM)


class Client(Node):
    """Hears all topics of the demonstration; keeps states, truths and alarms in order.

    Attributes
    ----------
    heard : dict of list
        Messages of `STATE`, `TRUTH` and `ALARM` so far.
    """

    def __init__(self, bag: Path) -> None:
        super().__init__("belt_demo")
        self.heard: dict[str, list[Any]] = {topic: [] for topic in _KEPT}
        self.recorder = Recorder(bag, {topic: kind for topic, (_, kind, _) in _TOPICS.items()})
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self)
        self._joints = self.create_publisher(JointState, JOINTS, _DEEP)

    def listen(self) -> None:
        """Subscribe to all topics."""
        for topic, (kind, _, quality) in _TOPICS.items():
            self.create_subscription(kind, topic, self._hears(topic, kind), quality, raw=True)

    def _hears(self, topic: str, kind: type) -> Callable[[bytes], None]:
        def hear(content: bytes) -> None:
            self.recorder.write(topic, self.get_clock().now().nanoseconds, content)
            if topic in self.heard:
                self.heard[topic].append(deserialize_message(content, kind))

        return hear

    def work(self, seconds: float) -> None:
        """Serve one message, or wait for it."""
        self._executor.spin_once(timeout_sec=seconds)

    def node_listens(self) -> bool:
        """Whether anyone subscribes to joint states yet."""
        return self.count_subscribers(JOINTS) > 0

    def publish_joints(self, content: bytes) -> None:
        """Publish a serialised joint state."""
        self._joints.publish(content)

    def close(self) -> None:
        """Leave the graph and finish the bag."""
        self.recorder.__exit__(None, None, None)
        self._executor.shutdown()
        self.destroy_node()
        rclpy.try_shutdown()
