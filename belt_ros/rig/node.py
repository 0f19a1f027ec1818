"""The rig as a ROS 2 node that plays a scenario in real time."""

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

from belt_msgs.msg import BeltState
from builtin_interfaces.msg import Time
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.duration import Duration
from rclpy.exceptions import InvalidParameterValueException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from belt_ros.message_fields import state_fields
from belt_ros.rig.running import RunningScenario
from belt_ros.rig.scenario import Scenario, ScenarioError, load_scenario
from belt_ros.rig.simulate import RigSample, simulate
from belt_ros.rig.truth import as_estimate
from belt_ros.settings import DriveSettings, SettingsError, load_settings

# Reliable, so that reliable and best-effort subscribers match alike; deep enough for a hiccup.
_QOS = QoSProfile(depth=200, reliability=ReliabilityPolicy.RELIABLE)
_LONGEST_WAIT = 0.1  # [s] until the node next looks whether it is to stop
_LONGEST_NEGLECT = 0.05  # [s] for which a node that is late leaves its services waiting
_SETTLING = 1.0  # [s] that a subscriber takes to know of the publisher, once this knows of it
_DELIVERY = Duration(seconds=0.5)


class RigNode(Node):
    """Publishes ``joint_states`` and ``~/truth`` of a scenario, paced to real time.

    Header stamps are the node clock's time at the start plus scenario time, so their spacing is
    exact. After a hiccup the node catches up; it leaves no sample out. Setting the parameter
    ``fault`` lets an event or a fault begin, see `running`; ``~/clear_faults`` ends them all.

    Raises
    ------
    SettingsError
        If the drive or the scenario, given as parameters, cannot be used.
    """

    def __init__(self) -> None:
        super().__init__("belt_rig")
        self._executor = SingleThreadedExecutor()
        self.settings: DriveSettings = load_settings(
            self._path("config_file", "YAML that describes the drive")
        )
        self.scenario: Scenario = load_scenario(
            self._path("scenario_file", "YAML that scripts the run"), self.settings
        )
        self._rate_factor = self._number(
            "rate_factor", 1.0, "times faster than real time", 0.01, 1e3
        )
        self._patience = self._number(
            "wait_for_subscriber",
            2.0,
            "longest wait for subscribers to joint_states [s]",
            0.0,
            3600.0,
        )
        self._awaited = self._number("subscribers", 1.0, "how many are waited for", 1.0, 1000.0)
        self._loop = bool(
            self.declare_parameter(
                "loop", value=False, descriptor=_describe("begin again at the end")
            ).value
        )
        self._running = RunningScenario(self.scenario, self.settings)
        self._take_requests()
        self._joint_states = self.create_publisher(JointState, "joint_states", _QOS)
        self._truth = self.create_publisher(BeltState, "~/truth", _QOS)
        self._executor.add_node(self)
        self._last_served = -math.inf

    def _path(self, name: str, meaning: str) -> str:
        value: object = self.declare_parameter(name, "", _describe(meaning)).value
        if not value:
            raise ScenarioError(
                f"parameter {name} is empty; give the {meaning}, e.g. with "
                f"--ros-args -p {name}:=<file>"
            )
        return str(value)

    def _number(self, name: str, default: float, meaning: str, low: float, high: float) -> float:
        descriptor = _describe(meaning)
        descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
        # A YAML's 1 is as good as 1.0, so the type is left open and checked here.
        descriptor.dynamic_typing = True
        value: object = self.declare_parameter(name, default, descriptor).value
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ScenarioError(f"parameter {name} is {value!r}; it must be a number")
        if not low <= value <= high:
            raise ScenarioError(
                f"parameter {name} is {value:g}; it must lie between {low:g} and {high:g}"
            )
        return float(value)

    def _take_requests(self) -> None:
        """Let faults begin and end on request, one maybe from the start."""
        meaning = (
            "what goes wrong now, e.g. 'stuck driven_speed duration=5' or 'tension=200 over=2'"
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
                    self._running.request(str(change.value))
                except SettingsError as error:
                    return SetParametersResult(successful=False, reason=str(error))
                self.get_logger().info(f"begins: {change.value}")
        return SetParametersResult(successful=True)

    def _clear(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        ended = self._running.clear()
        response.success = True
        response.message = f"ended: {', '.join(ended)}" if ended else "there was nothing to end"
        self.get_logger().info(response.message)
        return response

    def play(self, stopped: Callable[[], bool]) -> int:
        """Play the scenario until its end, or until `stopped`; return the samples published."""
        self._wait_for_subscriber(stopped)
        scenario = self.scenario
        start_ns = self.get_clock().now().nanoseconds
        period_ns = scenario.stamp_ns(1)
        self.get_logger().info(
            f"playing scenario {scenario.name}: {scenario.duration:g} s at "
            f"{scenario.sample_rate:g} Hz, {self._rate_factor:g} times real time"
        )
        published = 0
        begin = time.monotonic()
        first_ns = start_ns
        while not stopped():
            for sample in simulate(self.settings, scenario, start_ns, self._running):
                due = begin + (sample.stamp_ns - first_ns) * 1e-9 / self._rate_factor
                self._spin_until(due, stopped)
                if stopped():
                    break
                self._publish(sample)
                published += 1
            if not self._loop:
                break
            start_ns += scenario.stamp_ns(scenario.samples - 1) + period_ns
        if not stopped():
            self._joint_states.wait_for_all_acked(_DELIVERY)
            self._truth.wait_for_all_acked(_DELIVERY)
            self.get_logger().info(f"end of scenario {scenario.name}: {published} samples")
        return published

    def _wait_for_subscriber(self, stopped: Callable[[], bool]) -> None:
        end = time.monotonic() + self._patience
        while not stopped() and time.monotonic() < end:
            if self._joint_states.get_subscription_count() >= self._awaited:
                self._spin_until(time.monotonic() + _SETTLING, stopped)
                return
            self._executor.spin_once(timeout_sec=0.02)
        if self._patience > 0.0 and not stopped():
            self.get_logger().warning(
                f"{self._joint_states.topic_name} has fewer than {self._awaited:g} subscribers "
                f"after {self._patience:g} s; playing all the same"
            )

    def _spin_until(self, due: float, stopped: Callable[[], bool]) -> None:
        """Serve the node until `due` (monotonic clock); when late, only every now and then."""
        while not stopped():
            now = time.monotonic()
            if now >= due and now - self._last_served < _LONGEST_NEGLECT:
                return
            self._executor.spin_once(timeout_sec=min(max(due - now, 0.0), _LONGEST_WAIT))
            self._last_served = now

    def _publish(self, sample: RigSample) -> None:
        for stamp_ns, joints in sample.published:
            message = JointState(
                name=list(joints.names),
                position=list(joints.positions),
                velocity=list(joints.velocities),
                effort=list(joints.efforts),
            )
            message.header.stamp = _stamp(stamp_ns)
            self._joint_states.publish(message)
        truth = BeltState(**state_fields(self.settings.name, as_estimate(sample.truth, 0)))
        truth.header.stamp = _stamp(sample.stamp_ns)
        self._truth.publish(truth)

    def destroy_node(self) -> None:
        """Release the executor, then the node."""
        self._executor.shutdown()
        super().destroy_node()


def _stamp(stamp_ns: int) -> Time:
    seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
    return Time(sec=seconds, nanosec=nanoseconds)


def _describe(meaning: str) -> ParameterDescriptor:
    return ParameterDescriptor(description=meaning, read_only=True)
