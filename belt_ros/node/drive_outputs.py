"""What one drive of a node publishes and logs of what it has come to know."""

import math

from belt_msgs.msg import BeltState, SlipAlarm
from rclpy.clock import Clock
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.qos import DurabilityPolicy, QoSProfile

from belt_ros.diagnostic_rows import REJECTION_ADVICE
from belt_ros.estimation import AlarmStatus, BeltEstimate, Rejection, Severity
from belt_ros.estimation.calibration import CalibrationResult
from belt_ros.node.conversions import alarm_message
from belt_ros.node.topic_hub import TopicHub
from belt_ros.state_bytes import StateBytes

_REJECTION_LOG_PERIOD = 10.0  # [s] for each reason
_STATE_DEPTH = 100
_SECOND_NS = 1_000_000_000


class DriveOutputs:
    """Publishers of one drive, and its part of the log.

    Parameters
    ----------
    hub : TopicHub
    logger : RcutilsLogger
    steady : Clock
    prefix : str
        What stands before the names of the topics, e.g. ``drive_name/``.
    drive_name : str
    state_period : float
        Shortest time between two states that nothing makes due [s].
    """

    def __init__(
        self,
        hub: TopicHub,
        logger: RcutilsLogger,
        steady: Clock,
        prefix: str,
        drive_name: str,
        state_period: float,
    ) -> None:
        self._logger = logger
        self._steady = steady
        self._name = drive_name
        self._states = hub.publisher(BeltState, f"~/{prefix}state", QoSProfile(depth=_STATE_DEPTH))
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._alarms = hub.publisher(SlipAlarm, f"~/{prefix}alarm", latched)
        self._state_bytes = StateBytes(drive_name, BeltState.get_fields_and_field_types())
        self._state_period_ns = round(state_period * _SECOND_NS)
        self._published_ns = -math.inf
        self._rejections_logged: dict[Rejection, float] = {}

    def state(self, estimate: BeltEstimate, *, due: bool) -> None:
        """Publish an estimate, unless it is not `due` and comes soon after the one before."""
        since = estimate.stamp_ns - self._published_ns
        if not due and 0 <= since < self._state_period_ns:
            return
        self._published_ns = estimate.stamp_ns
        if self._states.get_subscription_count() > 0:
            self._states.publish(self._state_bytes.write(estimate))

    def alarm(self, status: AlarmStatus) -> None:
        """Publish an alarm's status."""
        self._alarms.publish(alarm_message(self._name, status))

    def changed_alarm(self, status: AlarmStatus) -> None:
        """Publish and log an alarm that measurements, or their absence, have changed."""
        self.alarm(status)
        if status.severity >= Severity.ALARM:
            self._logger.error(status.message)
        elif status.severity == Severity.WARNING:
            self._logger.warning(status.message)
        else:
            self._logger.info(status.message)

    def calibration(self, result: CalibrationResult) -> None:
        """Log what has come of a calibration."""
        if result.ratio_bias is None:
            self._logger.warning(f"{self._name}: {result.message}")
        else:
            self._logger.info(f"{self._name}: {result.message}")

    def rejection(self, reason: Rejection, source: str) -> None:
        """Log, now and then, that a measurement of a topic was turned away."""
        now = self._steady.now().nanoseconds * 1e-9
        if now - self._rejections_logged.get(reason, -math.inf) >= _REJECTION_LOG_PERIOD:
            self._rejections_logged[reason] = now
            self._logger.warning(
                f"{self._name}: measurement rejected from {source}, "
                f"{reason.name.lower().replace('_', ' ')}: {REJECTION_ADVICE[reason]}"
            )
