"""The lifecycle node: parameters, transitions and time around its drives."""

import functools
import itertools
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Any

from belt_msgs.srv import RecordMaintenance
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, JumpThreshold, TimeJump
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter as RosParameter
from rclpy.qos import QoSProfile

from belt_ros.node import services
from belt_ros.node.drive_unit import DriveUnit
from belt_ros.node.keeping_up import KeepingUp
from belt_ros.node.node_status import node_status
from belt_ros.node.parameters import (
    changed_priors,
    check_changes,
    declare_parameters,
    foreign_parameters,
    given_names,
    read_descriptions,
    read_node_settings,
)
from belt_ros.node.topic_hub import TopicHub
from belt_ros.node.warming_up import warm_up
from belt_ros.parameter_table import SettingsError

_REMINDER_PERIOD = 10.0  # [s]
_WATCH_PERIOD = 0.1  # [s]
# Drives are pooled over different times, by up to this share: or all would step by one message.
_APART = 0.25
_Transition = Callable[["BeltNode", LifecycleState], TransitionCallbackReturn]


def _reported(transition: _Transition) -> _Transition:
    """Log what a transition raises; rclpy takes the exception for an error and says nothing."""

    @functools.wraps(transition)
    def reporting(node: "BeltNode", state: LifecycleState) -> TransitionCallbackReturn:
        try:
            return transition(node, state)
        except Exception as error:
            node.failed_because = f"{transition.__name__} failed: {error}"
            node.get_logger().fatal(f"{transition.__name__} failed:\n{traceback.format_exc()}")
            raise

    return reporting


class BeltNode(LifecycleNode):
    """Estimate the states of belt drives from their speeds and torques.

    Topics, services and parameters are listed in README.md. Keyword arguments are those of
    `rclpy.lifecycle.LifecycleNode`.

    Attributes
    ----------
    units : list of DriveUnit
        One for each drive.
    failed_because : str
        What the last transition that failed has raised.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(
            "belt_node", automatically_declare_parameters_from_overrides=True, **kwargs
        )
        declare_parameters(self)
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._apply_parameters)
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._made_by_configure = ExitStack()
        self._configured = self._active = False
        self._unconfigured_because = "nobody has configured it"
        self.failed_because = "a transition failed"
        self._reminder = self.create_timer(_REMINDER_PERIOD, self._remind, clock=self._steady)
        self.units = [
            DriveUnit(self, name, self._steady, self._publish_rows) for name in self._names()
        ]
        if self._names() != ("",):
            self.create_service(
                RecordMaintenance, "~/record_maintenance", self._on_record_maintenance
            )
        self._jump_handle = self.get_clock().create_jump_callback(
            JumpThreshold(
                min_forward=None, min_backward=Duration(nanoseconds=-1), on_clock_change=False
            ),
            post_callback=self._on_jump,
        )
        # What is no truth value fails, with the reason, when the node is configured.
        if self.get_parameter("autostart").value is not False:
            self._autostart()

    def _names(self) -> tuple[str, ...]:
        try:
            return given_names(self) or ("",)
        except SettingsError:
            return ()  # which fails, with the reason, when the node is configured

    def _autostart(self) -> None:
        if self.trigger_configure() is TransitionCallbackReturn.SUCCESS:
            self.trigger_activate()

    @_reported
    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the parameters and make ready; fail, and say why, if they cannot be used."""
        try:
            seconds = self._configure()
        except SettingsError as error:
            self._release(str(error))
            self.get_logger().error(f"cannot be configured: {error}")
            return TransitionCallbackReturn.FAILURE
        self._configured = True
        names = ", ".join(unit.drive_name for unit in self.units)
        self.get_logger().info(
            f"{names}: configured, kernels compiled or loaded in {seconds:.2f} s"
        )
        return super().on_configure(state)

    def _configure(self) -> float:
        """Make ready; return the seconds that compiling took."""
        given_names(self)
        foreign = foreign_parameters(self)
        descriptions = read_descriptions(self)
        settings = read_node_settings(self)
        if foreign:
            self.get_logger().warning(f"not parameters of this node: {', '.join(foreign)}")
        # First: who waits for a subscriber waits for one that listens.
        seconds = warm_up(descriptions[0].drive)
        hub = TopicHub(
            self,
            settings.input_reliability,
            settings.input_depth,
            self._made_by_configure,
            self._on_message,
        )
        for unit, description in zip(self.units, descriptions, strict=True):
            unit.configure(description, hub, use_memory=settings.use_memory)
        self._keeping_up = KeepingUp(_WATCH_PERIOD, settings.longest_pool)
        self._diagnostics_publisher = hub.publisher(
            DiagnosticArray, "/diagnostics", QoSProfile(depth=10)
        )
        keeping = [unit for unit in self.units if unit.has_memory]
        if keeping:
            # One drive after the other: the memories of all at once would hold up input.
            turns = itertools.cycle(keeping)
            self._make_timer(settings.memory_period / len(keeping), lambda: next(turns).save())
        self._make_timer(settings.diagnostics_period, self._publish_diagnostics)
        self._make_timer(_WATCH_PERIOD, self._watch)
        return seconds

    def _make_timer(self, period: float, act: Callable[[], None]) -> None:
        timer = self.create_timer(period, act, clock=self._steady)
        self._made_by_configure.callback(self.destroy_timer, timer)

    @_reported
    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to estimate and publish."""
        result = super().on_activate(state)
        listening = dict.fromkeys(unit.activate() for unit in self.units)
        self._keeping_up.begin()
        self._active = True
        self.get_logger().info(f"active, listening on {', '.join(listening)}")
        return result

    @_reported
    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Estimate and publish nothing; what has been learned is kept."""
        self._active = False
        for unit in self.units:
            unit.deactivate()
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
        self._release(self.failed_because)
        return super().on_error(state)

    def destroy_node(self) -> None:
        """Keep what has been learned, and destroy the node."""
        for unit in self.units:
            unit.release()
        super().destroy_node()

    def _release(self, why: str) -> None:
        self._configured = self._active = False
        for unit in self.units:
            unit.release()
        self._unconfigured_because = why
        self._made_by_configure.close()

    def _remind(self) -> None:
        if not self._configured:
            self.get_logger().warning(
                f"unconfigured, estimating nothing: {self._unconfigured_because}"
            )

    def _check_parameters(self, changes: Sequence[RosParameter[Any]]) -> SetParametersResult:
        return check_changes(self, changes, configured=self._configured)

    def _apply_parameters(self, changes: Sequence[RosParameter[Any]]) -> None:
        if not self._configured:
            return
        for unit, description in zip(self.units, read_descriptions(self), strict=True):
            unit.retune(description.drive)
        priors = changed_priors(self, changes)
        if priors:
            self.get_logger().info(
                f"{', '.join(priors)}: counts once the node is configured anew; a tension that was "
                "set or measured is told at once by record_maintenance"
            )

    def _watch(self) -> None:
        for unit in self.units:
            unit.watch(_WATCH_PERIOD)
        if self._active:
            self._pool(self._keeping_up.timer)

    def _on_message(self) -> None:
        if self._active:
            self._pool(self._keeping_up.message)

    def _pool(self, changes: Callable[[float], bool]) -> None:
        """Let the drives pool what cannot be followed, if what has come `changes` that."""
        before = self._keeping_up.pool_period
        if not changes(time.monotonic()):
            return
        period = self._keeping_up.pool_period
        for place, unit in enumerate(self.units):
            unit.pool(period * (1.0 - _APART * place / len(self.units)))
        if before == 0.0:
            self.get_logger().warning(
                "the node falls behind its input: it averages measurements until it keeps up, see "
                "/diagnostics. Lower the input's rate, or divide the drives between several nodes"
            )
        elif period == 0.0:
            self.get_logger().info("the node keeps up with every measurement again")

    def _publish_diagnostics(self) -> None:
        if not self._active:
            return
        rows: list[DiagnosticStatus | None] = []
        reports = []
        for unit in self.units:
            unit_rows, report = unit.diagnostics()
            rows += unit_rows
            if report is not None:
                reports.append(report)
        pooled = self._keeping_up.pool_period
        self._publish_rows(node_status(self.get_name(), reports, pooled), *rows)

    def _publish_rows(self, *rows: DiagnosticStatus | None) -> None:
        message = DiagnosticArray(status=[row for row in rows if row is not None])
        message.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics_publisher.publish(message)

    def _on_record_maintenance(
        self, request: RecordMaintenance.Request, response: RecordMaintenance.Response
    ) -> RecordMaintenance.Response:
        response.success, response.message = services.record_for_one(self.units, request)
        return response

    def _on_jump(self, jump: TimeJump) -> None:
        del jump
        now_ns = self.get_clock().now().nanoseconds
        reset = [
            f"{unit.drive_name}{unit.keep_copy()}"
            for unit in self.units
            if unit.reset_after_jump(now_ns)
        ]
        if reset:
            self.get_logger().warning(
                f"ROS time went back: starting anew, as this run began, {', '.join(reset)}"
            )
