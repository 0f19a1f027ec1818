"""The node's topics: overrides of their quality of service, and one subscription for each."""

from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, NamedTuple

from rclpy.exceptions import InvalidTopicNameException
from rclpy.lifecycle import LifecycleNode, LifecyclePublisher
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription

from belt_ros.parameter_table import SettingsError

Listener = Callable[[Any], None]
_OVERRIDES = {"history": HistoryPolicy, "reliability": ReliabilityPolicy}


class _Shared(NamedTuple):
    subscription: "Subscription[Any]"
    listeners: list[Listener]


class TopicHub:
    """Make publishers; subscribe once to each topic and hand its messages to all who listen.

    So a message for many drives, such as a joint state, is received and deserialised once.

    Parameters
    ----------
    node : LifecycleNode
    reliability : str
        Of every subscription: ``"best_effort"`` or ``"reliable"``. Parameters
        `qos_overrides.<topic>.subscription.reliability`, `depth` and `history` go before this and
        `depth`. They are declared at the first subscription to a topic, and stay as they are while
        the node lives.
    depth : int
        Of every subscription's queue.
    made : ExitStack
        Destroys all that is made here when it is closed.
    on_message : callable, optional
        Called as a message comes, before any listener.
    """

    def __init__(
        self,
        node: LifecycleNode,
        reliability: str,
        depth: int,
        made: ExitStack,
        on_message: Callable[[], None] = lambda: None,
    ) -> None:
        self._node = node
        self._on_message = on_message
        self._made = made
        self._reliability = ReliabilityPolicy[reliability.upper()]
        self._depth = depth
        self._shared: dict[tuple[str, type], _Shared] = {}
        self._arrived_ns: int | None = None  # the message that is being handed out
        made.callback(self.close)

    def close(self) -> None:
        """Destroy all subscriptions."""
        while self._shared:
            _, shared = self._shared.popitem()
            shared.listeners.clear()
            self._node.destroy_subscription(shared.subscription)

    def now_ns(self) -> int:
        """Return the node's ROS time [ns]; to all who are handed a message, that of its arrival."""
        if self._arrived_ns is not None:
            return self._arrived_ns
        return int(self._node.get_clock().now().nanoseconds)

    def subscribe(self, message_type: type, topic: str, listener: Listener) -> str:
        """Hand every message on `topic` to `listener`; return the topic's full name.

        Raises
        ------
        SettingsError
            If the name is no topic's, or a `qos_overrides` parameter of it cannot be used.
        """
        try:
            name = self._node.resolve_topic_name(topic)
        except (InvalidTopicNameException, RuntimeError, ValueError) as error:
            raise SettingsError(f"{topic!r} is no name of a topic: {error}") from error
        key = name, message_type
        if key not in self._shared:
            self._check_overrides(name, "subscription")
            listeners: list[Listener] = []
            subscription = self._node.create_subscription(
                message_type,
                topic,
                self._fan_out(listeners),
                QoSProfile(depth=self._depth, reliability=self._reliability),
                qos_overriding_options=QoSOverridingOptions.with_default_policies(),
            )
            self._shared[key] = _Shared(subscription, listeners)
        self._shared[key].listeners.append(listener)
        return name

    def _fan_out(self, listeners: list[Listener]) -> Listener:
        def hand_out(message: Any) -> None:
            self._on_message()
            self._arrived_ns = self.now_ns()
            try:
                for listener in listeners:
                    listener(message)
            finally:
                self._arrived_ns = None

        return hand_out

    def publisher(
        self, message_type: type, topic: str, profile: QoSProfile
    ) -> "LifecyclePublisher[Any]":
        """Return a publisher on `topic`, with a profile of its own: overrides are written into it.

        Raises
        ------
        SettingsError
            If a `qos_overrides` parameter of the topic cannot be used.
        """
        self._check_overrides(self._node.resolve_topic_name(topic), "publisher")
        publisher: LifecyclePublisher[Any] = self._node.create_lifecycle_publisher(
            message_type,
            topic,
            profile,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )
        self._made.callback(self._node.destroy_lifecycle_publisher, publisher)
        return publisher

    def _check_overrides(self, topic: str, entity: str) -> None:
        """Refuse what rclpy would end the transition for, or give to DDS as it is."""
        for policy in ("history", "reliability", "depth"):
            parameter = f"qos_overrides.{topic}.{entity}.{policy}"
            if not self._node.has_parameter(parameter):
                continue
            value: object = self._node.get_parameter(parameter).value
            if policy == "depth":
                usable = isinstance(value, int) and not isinstance(value, bool) and value > 0
                wanted = "a positive whole number"
            else:
                names = [name.lower() for name in _OVERRIDES[policy].__members__]
                names.remove("unknown")
                usable = isinstance(value, str) and value.lower() in names
                wanted = f"one of {', '.join(names)}"
            if not usable:
                raise SettingsError(f"{parameter} is {value!r}; it must be {wanted}")
