"""One configured drive: joint states in; state, alarm and diagnostics out, as messages.

Knows messages and a steady clock, but neither node nor middleware.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

from belt_msgs.msg import BeltState, SlipAlarm
from diagnostic_msgs.msg import DiagnosticStatus
from sensor_msgs.msg import JointState

from belt_ros.estimation import (
    AlarmStatus,
    Health,
    Learned,
    Maintenance,
    Measurement,
    MonitorOutput,
    Rejection,
    Severity,
)
from belt_ros.estimation.calibration import CalibrationResult
from belt_ros.node.conversions import (
    alarm_message,
    measurement_from_joint_state,
    nanoseconds,
    state_message,
)
from belt_ros.node.diagnostics import calibration_status, drive_status, input_status
from belt_ros.node.input_meter import InputMeter
from belt_ros.settings import DriveSettings

_SECONDS = 1e-9
_CALIBRATION_LOST = CalibrationResult("ratio not calibrated: the estimate was started anew")


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of one message: a state if it was accepted, an alarm if that has changed.

    `calibration` is there when one has just ended.
    """

    reason: Rejection
    state: BeltState | None = None
    alarm: SlipAlarm | None = None
    worsened: bool = False
    calibration: CalibrationResult | None = None


class Pipeline:
    """Turn one drive's joint states into messages about its belt.

    Parameters
    ----------
    node_name : str
        As it stands in diagnostics.
    topic : str
        Full name of the joint states' topic, for messages to the user.
    settings : DriveSettings
    steady : callable
        A steady clock [s]: lost input must be noticed also when ROS time stands still.
    """

    def __init__(
        self,
        node_name: str,
        topic: str,
        settings: DriveSettings,
        steady: Callable[[], float] = time.monotonic,
    ) -> None:
        self._node_name = node_name
        self._topic = topic
        self._settings = settings
        self._steady = steady
        self._monitor = settings.monitor()
        self._alarm: AlarmStatus | None = None
        self._taken_in = 0
        self._calibrating: int | None = None  # the number of resets when it began
        self._calibrated: CalibrationResult | None = None
        self.begin()

    @property
    def drive_name(self) -> str:
        """Name of the drive."""
        return self._settings.name

    @property
    def taken_in(self) -> int:
        """Measurements accepted and maintenance recorded so far, whatever was reset."""
        return self._taken_in

    @property
    def alarm(self) -> AlarmStatus | None:
        """The present alarm status; None before the first estimate."""
        return self._alarm

    @property
    def health(self) -> Health:
        """What became of the measurements so far."""
        return self._monitor.health

    def begin(self) -> None:
        """Count input, and its absence, from now on."""
        self._meter = InputMeter(self._steady())

    def take(self, message: JointState, now_ns: int) -> Outcome:
        """Take in a joint state that arrived at `now_ns` on ROS time [ns]."""
        began = self._steady()
        measurement = measurement_from_joint_state(
            self._settings.driver, self._settings.driven, message
        )
        if isinstance(measurement, Measurement):
            output = self._monitor.step(measurement)
        else:
            output = self._monitor.reject(measurement)
        outcome = self._outcome(output)
        latency = (now_ns - nanoseconds(message.header.stamp)) * _SECONDS
        self._meter.count(outcome.reason, latency, began, self._steady())
        return outcome

    def _outcome(self, output: MonitorOutput) -> Outcome:
        if output.rejection is not Rejection.NONE or output.estimate is None:
            return Outcome(output.rejection)
        self._taken_in += 1
        calibration = self._calibration_ended(output)
        status = output.alarm
        name = self._settings.name
        state = state_message(name, output.estimate)
        if status is None:
            return Outcome(Rejection.NONE, state, calibration=calibration)
        before = Severity.NORMAL if self._alarm is None else self._alarm.severity
        self._alarm = status
        return Outcome(
            Rejection.NONE,
            state,
            alarm_message(name, status),
            worsened=status.severity > before,
            calibration=calibration,
        )

    def _calibration_ended(self, output: MonitorOutput) -> CalibrationResult | None:
        """Return the result of a calibration that ended with this measurement."""
        if self._calibrating is None or output.estimate is None:
            return None
        lost = output.estimate.health.resets != self._calibrating
        result = _CALIBRATION_LOST if lost else output.calibration
        if result is not None:
            self._calibrating, self._calibrated = None, result
        return result

    def reset(self) -> None:
        """Start anew at the priors."""
        self._monitor.reset()

    def reset_after_jump(self, now_ns: int) -> bool:
        """Start anew where the run began if ROS time, `now_ns` [ns], is back behind the estimate.

        Returns
        -------
        bool
            Whether that was so; not, if new stamps have already said as much.
        """
        estimate = self._monitor.estimate
        behind = estimate is not None and estimate.stamp_ns > now_ns
        if behind:
            self._monitor.restart()
        return behind

    def acknowledge(self) -> SlipAlarm | None:
        """Release the alarm's latch; return the alarm, None before the first estimate."""
        status = self._monitor.acknowledge()
        if status is None:
            return None
        self._alarm = status
        return alarm_message(self._settings.name, status)

    def learned(self, now: float) -> Learned | None:
        """Return what has been learned of the belt; None if that is nothing yet.

        `now` is wall time [s] since the Unix epoch. What is learned is as old as the last
        measurement that was accepted.

        Raises
        ------
        MemoryRefusedError
            If it is nothing worth remembering.
        """
        return self._monitor.learned(now - self._meter.unused(self._steady()))

    def restore(self, learned: Learned, elapsed: float) -> str:
        """Start from what was learned `elapsed` [s] ago; return a note for the log, or "".

        Raises
        ------
        MemoryRefusedError
            If it is of another drive.
        """
        return self._monitor.restore(learned, elapsed)

    def maintain(self, maintenance: Maintenance) -> str:
        """Take in what was done to the belt; return a sentence for the log."""
        message = self._monitor.maintain(maintenance)
        self._taken_in += 1
        return message

    def calibrate(self) -> bool:
        """Begin to calibrate the radius ratio; whether that is possible now."""
        if not self._monitor.calibrate():
            return False
        self._calibrating = self._monitor.health.resets
        return True

    def retune(self, settings: DriveSettings) -> None:
        """Use other noise, drift, limits and alarm thresholds from now on."""
        self._settings = settings
        self._monitor.retune(settings.noise, settings.drift, settings.limits, settings.alarm)

    def drive_status(self) -> DiagnosticStatus:
        """Return the drive's diagnostics."""
        return drive_status(
            self._node_name,
            self._settings.name,
            self._monitor.estimate,
            self._alarm,
            self._meter.unused(self._steady()),
            self._settings.limits.greatest_gap,
        )

    def input_status(self) -> DiagnosticStatus:
        """Return the input's diagnostics since the last call."""
        return input_status(
            self._node_name,
            self._settings.name,
            self._topic,
            self._meter.report(self._steady()),
            self._monitor.health,
            self._settings.limits.greatest_gap,
        )

    def calibration_status(self) -> DiagnosticStatus | None:
        """Return the diagnostics of the calibration; None if there never was one."""
        running = self._calibrating is not None
        if not running and self._calibrated is None:
            return None
        return calibration_status(
            self._node_name, self._settings.name, None if running else self._calibrated
        )


def warm_up(settings: DriveSettings) -> float:
    """Compile what the first measurement would otherwise wait for; return the seconds it took."""
    began = time.monotonic()
    monitor = settings.monitor()
    for sample in range(3):
        monitor.step(Measurement(sample * 1_000_000, 1.0, 1.0, 0.0, 0.0))
    return time.monotonic() - began
