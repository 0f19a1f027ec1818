"""The lifecycle node: entities, transitions and gates around a `Pipeline`."""

import functools
import math
import traceback
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Any

import numpy as np
from belt_msgs.msg import BeltState, SlipAlarm
from belt_msgs.srv import RecordMaintenance
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, JumpThreshold, TimeJump
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter as RosParameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from belt_ros.estimation import Rejection, Severity
from belt_ros.estimation.calibration import CalibrationResult
from belt_ros.node import services
from belt_ros.node.diagnostics import REJECTION_ADVICE, memory_status
from belt_ros.node.memory import Memory
from belt_ros.node.parameters import (
    NodeSettings,
    check_changes,
    declare_parameters,
    foreign_parameters,
    read_drive_settings,
    read_node_settings,
)
from belt_ros.node.pipeline import Pipeline, warm_up
from belt_ros.settings import PARAMETERS, SettingsError

_REMINDER_PERIOD = 10.0  # [s]
_REJECTION_LOG_PERIOD = 10.0  # [s] for each reason
_STATE_DEPTH = 100
_Transition = Callable[["BeltNode", LifecycleState], TransitionCallbackReturn]


def _reported(transition: _Transition) -> _Transition:
    """Log what a transition raises; rclpy takes the exception for an error and says nothing."""

    @functools.wraps(transition)
    def reporting(node: "BeltNode", state: LifecycleState) -> TransitionCallbackReturn:
        try:
            return transition(node, state)
        except Exception:
            node.get_logger().fatal(f"{transition.__name__} failed:\n{traceback.format_exc()}")
            raise

    return reporting


class BeltNode(LifecycleNode):
    """Estimate the state of one belt drive from its joint states.

    Topics, services and parameters are listed in README.md. Keyword arguments are those of
    `rclpy.lifecycle.LifecycleNode`.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(
            "belt_node", automatically_declare_parameters_from_overrides=True, **kwargs
        )
        declare_parameters(self)
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._apply_parameters)
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._pipeline: Pipeline | None = None
        self._memory: Memory | None = None
        self._made_by_configure = ExitStack()
        self._active = False
        self._unconfigured_because = "nobody has configured it"
        self._rejections_logged: dict[Rejection, float] = {}
        self._reminder = self.create_timer(_REMINDER_PERIOD, self._remind, clock=self._steady)
        self._offer_services()
        self._jump_handle = self.get_clock().create_jump_callback(
            JumpThreshold(
                min_forward=None, min_backward=Duration(nanoseconds=-1), on_clock_change=False
            ),
            post_callback=self._on_jump,
        )
        if self.get_parameter("autostart").value is True:
            self._autostart()

    def _offer_services(self) -> None:
        def offer(kind: type, name: str, answer: Callable[[Any], services.Answer]) -> None:
            def respond(request: Any, response: Any) -> Any:
                response.success, response.message = answer(request)
                if response.success:
                    self.get_logger().info(response.message)
                return response

            self.create_service(kind, name, respond)

        offer(Trigger, "~/reset", lambda _: services.reset(self._running, self._memory))
        offer(
            Trigger,
            "~/acknowledge",
            lambda _: services.acknowledge(self._running, self._publish_alarm),
        )
        offer(Trigger, "~/calibrate", lambda _: services.calibrate(self._running))
        offer(
            RecordMaintenance,
            "~/record_maintenance",
            lambda request: services.record_maintenance(self._pipeline, self._memory, request),
        )

    @property
    def _running(self) -> Pipeline | None:
        """The pipeline, while it is to be used."""
        return self._pipeline if self._active else None

    def _autostart(self) -> None:
        if self.trigger_configure() is TransitionCallbackReturn.SUCCESS:
            self.trigger_activate()

    @_reported
    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the parameters and make ready; fail, and say why, if they cannot be used."""
        try:
            foreign = foreign_parameters(self)
            settings = read_drive_settings(self)
            node_settings = read_node_settings(self)
        except SettingsError as error:
            self._unconfigured_because = str(error)
            self.get_logger().error(f"cannot be configured: {error}")
            return TransitionCallbackReturn.FAILURE
        if foreign:
            self.get_logger().warning(f"not parameters of this node: {', '.join(foreign)}")
        seconds = warm_up(settings)  # first: who waits for a subscriber waits for one that listens
        self._make_publishers()
        self._make_inputs(node_settings)
        self._pipeline = Pipeline(self.get_name(), self._subscription.topic_name, settings)
        self._open_memory(self._pipeline, node_settings)
        self.get_logger().info(
            f"{settings.name}: configured, kernels compiled or loaded in {seconds:.2f} s"
        )
        return super().on_configure(state)

    def _make_publishers(self) -> None:
        self._state_publisher = self.create_lifecycle_publisher(
            BeltState, "~/state", QoSProfile(depth=_STATE_DEPTH)
        )
        self._alarm_publisher = self.create_lifecycle_publisher(
            SlipAlarm, "~/alarm", QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        )
        self._diagnostics_publisher = self.create_lifecycle_publisher(
            DiagnosticArray, "/diagnostics", QoSProfile(depth=10)
        )
        for publisher in (
            self._state_publisher,
            self._alarm_publisher,
            self._diagnostics_publisher,
        ):
            self._made_by_configure.callback(self.destroy_lifecycle_publisher, publisher)

    def _make_inputs(self, settings: NodeSettings) -> None:
        quality = QoSProfile(
            depth=settings.input_depth,
            reliability=ReliabilityPolicy[settings.input_reliability.upper()],
        )
        self._subscription = self.create_subscription(
            JointState, "joint_states", self._on_joint_state, quality
        )
        self._made_by_configure.callback(self.destroy_subscription, self._subscription)
        timer = self.create_timer(
            settings.diagnostics_period, self._publish_diagnostics, clock=self._steady
        )
        self._made_by_configure.callback(self.destroy_timer, timer)

    def _open_memory(self, pipeline: Pipeline, settings: NodeSettings) -> None:
        if settings.memory_file is None:
            return
        logger = self.get_logger()
        self._memory = Memory(settings.memory_file, pipeline, logger.warning)
        restored = self._memory.restore()
        if restored:
            logger.info(restored)
        timer = self.create_timer(settings.memory_period, self._memory.save, clock=self._steady)
        self._made_by_configure.callback(self.destroy_timer, timer)

    @_reported
    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to estimate and publish."""
        result = super().on_activate(state)
        if self._pipeline is not None:
            self._pipeline.begin()
            self._active = True
        self.get_logger().info(f"active, listening on {self._subscription.topic_name}")
        return result

    @_reported
    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Estimate and publish nothing; what has been learned is kept."""
        self._active = False
        if self._memory is not None:
            self._memory.finish()
        return super().on_deactivate(state)

    @_reported
    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Return to unconfigured."""
        self._release("it was cleaned up")
        return super().on_cleanup(state)

    @_reported
    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop for good."""
        self._release("it was shut down")
        self._reminder.cancel()
        return super().on_shutdown(state)

    @_reported
    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Return to unconfigured after a transition that raised."""
        self._release("a transition failed")
        return super().on_error(state)

    def destroy_node(self) -> None:
        """Keep what has been learned, and destroy the node."""
        self._close_memory()
        super().destroy_node()

    def _close_memory(self) -> None:
        if self._memory is not None:
            self._memory.close()
            self._memory = None

    def _release(self, why: str) -> None:
        self._active = False
        self._close_memory()
        self._pipeline = None
        self._unconfigured_because = why
        self._made_by_configure.close()

    def _remind(self) -> None:
        if self._pipeline is None:
            self.get_logger().warning(
                f"unconfigured, estimating nothing: {self._unconfigured_because}"
            )

    def _check_parameters(self, changes: Sequence[RosParameter[Any]]) -> SetParametersResult:
        return check_changes(self, changes, configured=self._pipeline is not None)

    def _apply_parameters(self, changes: Sequence[RosParameter[Any]]) -> None:
        if self._pipeline is not None and any(change.name in PARAMETERS for change in changes):
            self._pipeline.retune(read_drive_settings(self))

    def _on_joint_state(self, message: JointState) -> None:
        pipeline = self._running
        if pipeline is None:
            return
        try:
            outcome = pipeline.take(message, self.get_clock().now().nanoseconds)
        except (ArithmeticError, np.linalg.LinAlgError) as error:
            self.get_logger().error(f"estimation failed, starting anew at the priors: {error}")
            pipeline.reset()
            return
        if outcome.state is None:
            self._log_rejection(outcome.reason)
            return
        self._state_publisher.publish(outcome.state)
        if outcome.alarm is not None:
            self._publish_alarm(outcome.alarm)
            self._log_alarm(outcome.alarm)
        if outcome.worsened:
            self._publish_rows(pipeline.drive_status())
        if outcome.calibration is not None:
            self._tell_calibration(pipeline, outcome.calibration)

    def _publish_alarm(self, alarm: SlipAlarm) -> None:
        self._alarm_publisher.publish(alarm)

    def _tell_calibration(self, pipeline: Pipeline, result: CalibrationResult) -> None:
        if result.ratio_bias is None:
            self.get_logger().warning(result.message)
        else:
            self.get_logger().info(result.message)
        self._publish_rows(pipeline.calibration_status())

    def _log_rejection(self, reason: Rejection) -> None:
        now = self._steady.now().nanoseconds * 1e-9
        if now - self._rejections_logged.get(reason, -math.inf) >= _REJECTION_LOG_PERIOD:
            self._rejections_logged[reason] = now
            self.get_logger().warning(
                f"measurement rejected, {reason.name.lower()}: {REJECTION_ADVICE[reason]}"
            )

    def _log_alarm(self, alarm: SlipAlarm) -> None:
        if alarm.severity >= Severity.ALARM:
            self.get_logger().error(alarm.message)
        elif alarm.severity == Severity.WARNING:
            self.get_logger().warning(alarm.message)
        else:
            self.get_logger().info(alarm.message)

    def _publish_diagnostics(self) -> None:
        pipeline = self._running
        if pipeline is None:
            return
        kept = None
        if self._memory is not None:
            kept = memory_status(self.get_name(), pipeline.drive_name, self._memory.report())
        self._publish_rows(
            pipeline.drive_status(), pipeline.input_status(), kept, pipeline.calibration_status()
        )

    def _publish_rows(self, *rows: DiagnosticStatus | None) -> None:
        message = DiagnosticArray(status=[row for row in rows if row is not None])
        message.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics_publisher.publish(message)

    def _on_jump(self, jump: TimeJump) -> None:
        del jump
        now_ns = self.get_clock().now().nanoseconds
        if self._pipeline is not None and self._pipeline.reset_after_jump(now_ns):
            self.get_logger().warning("ROS time went back: starting anew, as this run began")
