"""One drive within the node: its publishers, services, inputs and memory around a `Pipeline`."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from belt_msgs.srv import RecordMaintenance
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.clock import Clock
from rclpy.lifecycle import LifecycleNode
from std_srvs.srv import Trigger

from belt_ros.estimation import AlarmStatus, Measurement, Rejection
from belt_ros.node import services
from belt_ros.node.descriptions import DriveDescription
from belt_ros.node.diagnostics import memory_status
from belt_ros.node.drive_outputs import DriveOutputs
from belt_ros.node.input_meter import InputReport
from belt_ros.node.inputs import DriveInputs
from belt_ros.node.memory import BEFORE_FAILURE, Memory
from belt_ros.node.pipeline import Outcome, Pipeline
from belt_ros.node.topic_hub import TopicHub
from belt_ros.node.unwatched import unwatched_row
from belt_ros.settings import DriveSettings

_Rows = Callable[..., None]


class DriveUnit:
    """One drive of a node.

    Parameters
    ----------
    node : LifecycleNode
    name : str
        Which its topics and services are named by; "" in a node of one drive.
    steady : Clock
    publish_rows : callable
        Publishes rows of diagnostics.
    """

    def __init__(self, node: LifecycleNode, name: str, steady: Clock, publish_rows: _Rows) -> None:
        self._node = node
        self._prefix = f"{name}/" if name else ""
        self._steady = steady
        self._publish_rows = publish_rows
        self._pipeline: Pipeline | None = None
        self._memory: Memory | None = None
        self._active = False
        self._offer_services()

    def _offer_services(self) -> None:
        def offer(kind: type, name: str, answer: Callable[[Any], services.Answer]) -> None:
            def respond(request: Any, response: Any) -> Any:
                response.success, response.message = answer(request)
                if response.success:
                    told, name = response.message, f"{self.drive_name}: "
                    self._node.get_logger().info(told if told.startswith(name) else name + told)
                return response

            self._node.create_service(kind, f"~/{self._prefix}{name}", respond)

        offer(
            Trigger,
            "reset",
            lambda _: services.reset(self._running, self._memory, self._tell_alarm),
        )
        offer(
            Trigger,
            "acknowledge",
            lambda _: services.acknowledge(self._running, self._tell_alarm),
        )
        offer(Trigger, "calibrate", lambda _: services.calibrate(self._running))
        offer(RecordMaintenance, "record_maintenance", self.record_maintenance)

    def _tell_alarm(self, status: AlarmStatus) -> None:
        self._outputs.alarm(status)

    @property
    def drive_name(self) -> str:
        """Name of the drive in messages; "" while it is not configured."""
        return "" if self._pipeline is None else self._pipeline.drive_name

    @property
    def pipeline(self) -> Pipeline | None:
        """What its measurements go through; None while it is not configured."""
        return self._pipeline

    @property
    def _running(self) -> Pipeline | None:
        """The pipeline, while it is to be used."""
        return self._pipeline if self._active else None

    def record_maintenance(self, request: RecordMaintenance.Request) -> services.Answer:
        """Take in what was done to the belt."""
        return services.record_maintenance(self._pipeline, self._memory, request)

    def configure(
        self,
        description: DriveDescription,
        hub: TopicHub,
        *,
        use_memory: bool,
    ) -> None:
        """Make ready; without `use_memory` with no memory, whatever the description says."""
        settings, unit = description.drive, description.unit
        self._outputs = DriveOutputs(
            hub,
            self._node.get_logger(),
            self._steady,
            self._prefix,
            settings.name,
            unit.state_period,
        )
        self._now_ns = hub.now_ns
        self._inputs = DriveInputs(
            hub,
            unit.input,
            self._prefix,
            (settings.driver, settings.driven),
            unit.input_reorder_window,
            unit.input_slop,
            self._take,
            disorder=unit.input_disorder,
            gap=settings.limits.greatest_gap,
            loads=unit.input_loads,
            heard=self._hear,
        )
        self._pipeline = Pipeline(
            self._node.get_name(), self._inputs.sources, settings, unit.input_skew
        )
        if use_memory and unit.memory_file is not None:
            self._open_memory(self._pipeline, unit.memory_file)

    def _open_memory(self, pipeline: Pipeline, path: Path) -> None:
        logger = self._node.get_logger()
        self._memory = Memory(path, pipeline, logger.warning)
        restored = self._memory.restore()
        if restored:
            logger.info(restored)

    @property
    def has_memory(self) -> bool:
        """Whether what is learned is kept in a file."""
        return self._memory is not None

    def save(self) -> None:
        """Begin to write what has been learned, where there is a memory."""
        if self._memory is not None:
            self._memory.save()

    def activate(self) -> str:
        """Begin to estimate and publish; return what is listened on."""
        if self._pipeline is None:
            return "nothing"
        self._pipeline.begin()
        self._inputs.begin()
        self._active = True
        return ", ".join(self._inputs.sources)

    def deactivate(self) -> None:
        """Tell that nobody watches; estimate and publish nothing. What has been learned is kept."""
        pipeline, self._active = self._running, False
        if pipeline is not None:
            alarm = pipeline.end()
            if alarm is not None:
                self._outputs.alarm(alarm)
            self._publish_rows(unwatched_row(self._node.get_name(), self.drive_name))
        if self._memory is not None:
            self._memory.finish()

    def release(self) -> None:
        """Keep what has been learned, and return to unconfigured."""
        self._active = False
        if self._memory is not None:
            self._memory.close()
            self._memory = None
        self._pipeline = None

    def retune(self, settings: DriveSettings) -> None:
        """Use other noise, drift, limits and alarm thresholds from now on."""
        if self._pipeline is not None:
            self._pipeline.retune(settings)
            self._inputs.retune(settings.limits.greatest_gap)

    def pool(self, period: float) -> None:
        """Average measurements over `period` [s] from now on, or over what the drive asks for."""
        if self._pipeline is not None:
            self._pipeline.pool(period)

    def reset_after_jump(self, now_ns: int) -> bool:
        """Start anew if ROS time is back behind the estimate; whether that was so."""
        if self._pipeline is None:
            return False
        self._inputs.begin()
        return self._pipeline.reset_after_jump(now_ns)

    def keep_copy(self) -> str:
        """Keep a copy of what was learned until time went back; return a clause for the log."""
        kept = "" if self._memory is None else self._memory.copy()
        return kept and f"; {kept}"

    def _hear(self, source: str, stamp_ns: int | None) -> None:
        """Count a message as it comes, whatever becomes of it."""
        pipeline = self._running
        if pipeline is not None:
            pipeline.hear(source, stamp_ns, self._now_ns())

    def _take(self, ready: Measurement | Rejection, source: str, stamp_ns: int) -> None:
        """Take in what an input has ready."""
        pipeline = self._running
        if pipeline is None:
            return
        try:
            outcome = pipeline.take(ready, stamp_ns, self._now_ns())
        except (ArithmeticError, np.linalg.LinAlgError) as error:
            self._note_failure(f": {error}")
            pipeline.give_up()
            return
        if outcome.failed:
            self._note_failure()
        if outcome.reason is not Rejection.NONE:
            self._outputs.rejection(outcome.reason, source)
        elif outcome.estimate is not None:
            if outcome.went_back:
                self._node.get_logger().warning(
                    f"{self.drive_name}: the stamps went back: starting anew, as this run began"
                    f"{self.keep_copy()}"
                )
            self._outputs.state(outcome.estimate, due=outcome.alarm is not None)
        self._tell_changes(pipeline, outcome)

    def _note_failure(self, why: str = "") -> None:
        """Log that estimation failed, and keep what was learned before from being overwritten."""
        kept = "" if self._memory is None else self._memory.forget(BEFORE_FAILURE)
        self._node.get_logger().error(
            f"{self.drive_name}: estimation failed, starting anew at the priors{why}. Compare the "
            f"drive's parameters with the machine{kept and f'; {kept}'}"
        )

    def watch(self, period: float) -> None:
        """Take in what has waited too long, and notice silence.

        To be called on steady time, every `period` [s].
        """
        pipeline = self._running
        if pipeline is None:
            return
        self._inputs.flush(period)
        self._tell_changes(pipeline, pipeline.watch(self._now_ns()))

    def _tell_changes(self, pipeline: Pipeline, outcome: Outcome) -> None:
        """Tell of an alarm that has changed, and of a calibration that has ended."""
        if outcome.alarm is not None:
            self._outputs.changed_alarm(outcome.alarm)
        if outcome.worsened:
            self._publish_rows(pipeline.drive_status())
        if outcome.calibration is not None:
            self._outputs.calibration(outcome.calibration)
            self._publish_rows(pipeline.calibration_status())

    def diagnostics(self) -> tuple[list[DiagnosticStatus | None], InputReport | None]:
        """Return the drive's rows, and what came in the period that ends now."""
        pipeline = self._running
        if pipeline is None:
            return [], None
        kept = None
        if self._memory is not None:
            kept = memory_status(self._node.get_name(), pipeline.drive_name, self._memory.report())
        report = pipeline.input_report()
        rows = [
            pipeline.drive_status(),
            pipeline.input_status(report),
            kept,
            pipeline.calibration_status(),
        ]
        return rows, report
