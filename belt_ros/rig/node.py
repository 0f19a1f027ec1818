"""The rig as a ROS 2 node that plays a scenario in real time."""

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

from belt_msgs.msg import BeltState
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.duration import Duration
from rclpy.exceptions import InvalidParameterValueException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger

from belt_ros.message_fields import state_fields
from belt_ros.parameter_table import SettingsError
from belt_ros.rig.fleet import Instant, load_fleet, warm_up
from belt_ros.rig.node_parameters import read_rig_parameters
from belt_ros.rig.outputs import make_output, prefixes, time_message
from belt_ros.rig.readings import is_due
from belt_ros.rig.scenario import ScenarioError
from belt_ros.rig.truth import as_estimate

# Reliable, so that reliable and best-effort subscribers match alike; deep enough for a hiccup.
_QOS = QoSProfile(depth=200, reliability=ReliabilityPolicy.RELIABLE)
_LONGEST_WAIT = 0.1  # [s] until the node next looks whether it is to stop
_LONGEST_NEGLECT = 0.05  # [s] for which a node that is late leaves its services waiting
_SETTLING = 1.0  # [s] that a subscriber takes to know of the publisher, once this knows of it
_DELIVERY = Duration(seconds=0.5)


class RigNode(Node):
    """Publishes what the sensors of a scenario say, and ``~/truth``, paced to real time.

    Header stamps are the node clock's time at the start plus scenario time, so their spacing is
    exact. After a hiccup the node catches up; it leaves no sample out. Setting the parameter
    ``fault`` lets an event or a fault begin, see `running` and `fleet`; ``~/clear_faults`` ends
    them all. Several drives share ``joint_states``; all other topics of each begin with its name,
    also ``~/<drive>/truth``.

    Raises
    ------
    SettingsError
        If drive, scenario or a parameter cannot be used.
    """

    def __init__(self) -> None:
        super().__init__("belt_rig")
        self._executor = SingleThreadedExecutor()
        self._told = read_rig_parameters(self)
        self._fleet = load_fleet(
            self._told.config_file,
            self._told.scenario_file,
            self._told.drives,
            loads=self._told.loads,
        )
        self.scenario = self._fleet.scenario
        self._rates, self._truth_rate = self._told.rates_of(self.scenario.sample_rate)
        self._take_requests()
        self._output = make_output(
            self._told.output,
            self._create,
            self._fleet.joints,
            loads=self._told.loads,
        )
        self._truths = {
            drive: self._create(BeltState, f"~/{prefix}truth")
            for drive, prefix in prefixes(self._fleet.names).items()
        }
        self._executor.add_node(self)
        self._last_served = -math.inf

    def _create(self, kind: type, topic: str) -> "Publisher[Any]":
        return self.create_publisher(kind, topic, _QOS)

    def _take_requests(self) -> None:
        """Let faults begin and end on request, one maybe from the start."""
        meaning = (
            "what goes wrong now, e.g. 'stuck driven_speed duration=5' or 'tension=200 over=2'; "
            "with drive=<name>, of that drive only"
        )
        # What is no text is refused with the reason, as a fault of an unknown kind.
        descriptor = ParameterDescriptor(description=meaning, dynamic_typing=True)
        self.add_on_set_parameters_callback(self._request)
        try:
            self.declare_parameter("fault", "", descriptor)
        except InvalidParameterValueException as error:
            raise ScenarioError(f"parameter fault: {error}") from error
        self.create_service(Trigger, "~/clear_faults", self._clear)

    def _request(self, changes: Sequence[RosParameter[Any]]) -> SetParametersResult:
        for change in changes:
            if change.name == "fault" and change.value != "":
                try:
                    self._fleet.request(str(change.value))
                except SettingsError as error:
                    return SetParametersResult(successful=False, reason=str(error))
                self.get_logger().info(f"begins: {change.value}")
        return SetParametersResult(successful=True)

    def _clear(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        ended = self._fleet.clear()
        response.success = True
        response.message = f"ended: {', '.join(ended)}" if ended else "there was nothing to end"
        self.get_logger().info(response.message)
        return response

    def play(self, stopped: Callable[[], bool]) -> int:
        """Play the scenario until its end, or until `stopped`; return the samples published."""
        warm_up(self._fleet)
        self._wait_for_subscriber(stopped)
        scenario = self.scenario
        start_ns, begin = self.get_clock().now().nanoseconds, time.monotonic()
        period_ns = scenario.stamp_ns(1)
        self.get_logger().info(
            f"playing scenario {scenario.name}: {scenario.duration:g} s at "
            f"{scenario.sample_rate:g} Hz, {self._told.rate_factor:g} times real time"
        )
        published = 0
        first_ns = start_ns
        while not stopped():
            for instants in self._fleet.play(start_ns, self._rates):
                stamp_ns = instants[0].stamp_ns
                due = begin + (stamp_ns - first_ns) * 1e-9 / self._told.rate_factor
                self._spin_until(due, stopped)
                if stopped():
                    break
                self._output.publish([one for instant in instants for one in instant.readings])
                if is_due(stamp_ns - start_ns, period_ns, self._truth_rate):
                    self._publish_truth(instants)
                published += 1
            if not self._told.loop:
                break
            start_ns += scenario.stamp_ns(scenario.samples - 1) + period_ns
        if not stopped():
            for publisher in (*self._output.publishers, *self._truths.values()):
                publisher.wait_for_all_acked(_DELIVERY)
            self.get_logger().info(f"end of scenario {scenario.name}: {published} samples")
        return published

    def _wait_for_subscriber(self, stopped: Callable[[], bool]) -> None:
        end = time.monotonic() + self._told.patience
        while not stopped() and time.monotonic() < end:
            if not self._lonely():
                self._spin_until(time.monotonic() + _SETTLING, stopped)
                return
            self._executor.spin_once(timeout_sec=0.02)
        if self._told.patience > 0.0 and not stopped():
            lonely = self._lonely()
            others = f" and {len(lonely) - 1} others" if len(lonely) > 1 else ""
            self.get_logger().warning(
                f"{lonely[0]}{others} have fewer than {self._told.subscribers:g} subscribers after "
                f"{self._told.patience:g} s; playing all the same"
            )

    def _lonely(self) -> list[str]:
        """Topics on which subscribers are still waited for."""
        return [
            publisher.topic_name
            for publisher in self._output.awaited
            if publisher.get_subscription_count() < self._told.subscribers
        ]

    def _spin_until(self, due: float, stopped: Callable[[], bool]) -> None:
        """Serve the node until `due` (monotonic clock); when late, only every now and then."""
        while not stopped():
            now = time.monotonic()
            if now >= due and now - self._last_served < _LONGEST_NEGLECT:
                return
            self._executor.spin_once(timeout_sec=min(max(due - now, 0.0), _LONGEST_WAIT))
            self._last_served = now

    def _publish_truth(self, instants: Sequence[Instant]) -> None:
        for plant, instant in zip(self._fleet.plants, instants, strict=True):
            estimate = as_estimate(instant.truth, 0)
            for name in plant.names:
                truth = BeltState(**state_fields(name, estimate))
                truth.header.stamp = time_message(instant.stamp_ns)
                self._truths[name].publish(truth)

    def destroy_node(self) -> None:
        """Release the executor, then the node."""
        self._executor.shutdown()
        super().destroy_node()
