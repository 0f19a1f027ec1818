"""One configured drive: measurements in; estimate, alarm and diagnostics out.

Knows a steady clock, but neither node nor middleware.
"""

import dataclasses
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticStatus

from belt_ros.estimation import (
    AlarmStatus,
    BeltEstimate,
    Health,
    Learned,
    Maintenance,
    Measurement,
    MonitorOutput,
    Rejection,
)
from belt_ros.estimation.calibration import CalibrationResult
from belt_ros.node.belief_age import BeliefAge
from belt_ros.node.calibration_record import CalibrationRecord
from belt_ros.node.clock_jump import ClockJump, ahead
from belt_ros.node.diagnostics import drive_status, input_status
from belt_ros.node.input_meter import InputMeter, InputReport
from belt_ros.node.source_meter import SKEW_LIMIT
from belt_ros.node.told_alarm import ToldAlarm
from belt_ros.settings import DriveSettings

_SECONDS = 1e-9


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of one measurement: an estimate if it was accepted, an alarm if that has changed.

    `calibration` is there when one has just ended. Estimation has begun anew if stamps `went_back`,
    and at the priors if it has `failed` numerically.
    """

    reason: Rejection
    estimate: BeltEstimate | None = None
    alarm: AlarmStatus | None = None
    worsened: bool = False
    calibration: CalibrationResult | None = None
    went_back: bool = False
    failed: bool = False


class Pipeline:
    """Turn one drive's measurements into what is known of its belt.

    Parameters
    ----------
    node_name : str
        As it stands in diagnostics.
    sources : sequence of str
        Full names of the topics.
    settings : DriveSettings
    skew_limit : float
        Difference between clocks that is told [s].
    steady : callable
        A steady clock [s]: lost input must be noticed also when ROS time stands still.
    """

    def __init__(
        self,
        node_name: str,
        sources: Sequence[str],
        settings: DriveSettings,
        skew_limit: float = SKEW_LIMIT,
        steady: Callable[[], float] = time.monotonic,
    ) -> None:
        self._node_name = node_name
        self._sources = tuple(sources)
        self._settings = settings
        self._skew_limit = skew_limit
        self._steady = steady
        self._monitor = settings.monitor()
        self._pool_period = 0.0
        self._told = ToldAlarm(self._monitor)
        self._taken_in = 0
        self._jump = ClockJump(steady)
        self._age = BeliefAge(steady)
        self._now_ns = 0  # ROS time as it was last told
        self._resets = 0  # that are known
        self._calibrations = CalibrationRecord()
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
        """The present alarm status; None before anything is told."""
        return self._told.status

    @property
    def _gap(self) -> float:
        """The greatest gap [s]."""
        return self._settings.limits.greatest_gap

    @property
    def health(self) -> Health:
        """What became of the measurements so far."""
        return self._monitor.health

    @property
    def waiting(self) -> int:
        """How many measurements are being pooled, neither accepted nor rejected yet."""
        return self._monitor.waiting

    def begin(self) -> None:
        """Listen, and count input and its absence, from now on; pool as the drive asks for."""
        self._monitor.pause()
        if self._pool_period > 0.0:
            self.pool(0.0)
        self._meter = InputMeter(self._steady(), self._sources)
        # ROS time when a measurement was last used, or from when on none has been; None: unknown.
        self._used_ns: int | None = None
        self._fresh = False  # whether there has been an estimate since

    def end(self) -> AlarmStatus | None:
        """Listen no more; return the alarms' status to be told, None if none has been told yet."""
        return self._told.unwatch(self._now_ns)

    def hear(self, source: str, stamp_ns: int | None, now_ns: int) -> None:
        """Count a message as it comes at ROS time `now_ns`; its stamp is None if it is no time."""
        latency = math.nan if stamp_ns is None else (now_ns - stamp_ns) * _SECONDS
        self._meter.heard(source, latency, self._steady(), stamp_ns)

    def take(self, ready: Measurement | Rejection, stamp_ns: int, now_ns: int) -> Outcome:
        """Take in a measurement, or why there is none, stamped `stamp_ns`, at ROS time `now_ns`."""
        self._now_ns = now_ns
        began, before = self._steady(), self._monitor.estimate
        if not isinstance(ready, Measurement):
            output = self._monitor.reject(ready)
        elif self._jump.is_late(stamp_ns, now_ns, self._gap):
            output = self._monitor.reject(Rejection.OUT_OF_ORDER, ready)
        else:
            if self._monitor.estimate is None:
                self._rest()  # what was restored has waited for this
            near = abs(now_ns - stamp_ns) * _SECONDS <= self._gap
            output = self._monitor.step(ready, timely=near)
        outcome = self._outcome(output, before, now_ns)
        latency = (now_ns - stamp_ns) * _SECONDS
        self._meter.count(outcome.reason, latency, began, self._steady())
        return outcome

    def _outcome(self, output: MonitorOutput, before: BeltEstimate | None, now_ns: int) -> Outcome:
        """Return what came of a measurement; `before` is the estimate before it."""
        worsened = self._told.change(output.alarm)
        if output.rejection is not Rejection.NONE:
            return Outcome(output.rejection, None, output.alarm, worsened)
        estimate = output.estimate
        if not output.fresh or estimate is None:
            return Outcome(Rejection.NONE)
        self._taken_in += 1
        self._used_ns, self._fresh = now_ns, True
        self._age.renew()
        anew, self._resets = estimate.health.resets > self._resets, estimate.health.resets
        went_back = anew and before is not None and estimate.stamp_ns < before.stamp_ns
        if anew and not went_back:
            self._calibrations.forget()
        calibration = self._calibrations.ended(output.calibration, self._resets)
        return Outcome(
            Rejection.NONE,
            estimate,
            output.alarm or self._told.again(),
            worsened,
            calibration,
            went_back=went_back,
            failed=anew and not went_back,
        )

    def watch(self, now_ns: int) -> Outcome:
        """Notice silence at ROS time `now_ns` [ns]; the outcome has no estimate.

        Nothing is silent that stands still with ROS time, such as a simulation at a pause.
        """
        self._now_ns = now_ns
        if now_ns > 0 and (self._used_ns is None or now_ns < self._used_ns):
            self._used_ns = now_ns  # simulated time has begun, or goes on from before
        elapsed = 0.0 if self._used_ns is None else (now_ns - self._used_ns) * _SECONDS
        silence = min(self._meter.unused(self._steady()), elapsed)
        status = self._monitor.silent(now_ns, silence)
        if status is None and silence > self._gap:
            status = self._told.again()  # that it was silent before, too, is no news
        return Outcome(Rejection.NONE, alarm=status, worsened=self._told.change(status))

    def give_up(self) -> None:
        """Start anew at the priors after a measurement that could not be computed, and count it."""
        self._monitor.reject(Rejection.GATED)
        self._monitor.start_anew()
        self._resets = self._monitor.health.resets
        self._calibrations.forget()

    def reset(self) -> AlarmStatus | None:
        """Start anew at the priors; return the alarms' status if there has been any to forget."""
        self._monitor.reset()
        self._resets = self._monitor.health.resets
        self._calibrations.forget()
        return self._told.take_back(self._now_ns)

    def reset_after_jump(self, now_ns: int) -> bool:
        """Start anew where the run began if ROS time, `now_ns` [ns], is back behind the estimate.

        By more than the greatest gap: a clock that is corrected by less is no new run. What was on
        its way meanwhile, and is as far ahead of ROS time, is turned away until something fits.

        Returns
        -------
        bool
            Whether that was so; not, if new stamps have already said as much.
        """
        self._jump.happen(self._gap)
        estimate = self._monitor.estimate
        behind = estimate is not None and ahead(estimate.stamp_ns, now_ns, self._gap)
        if behind:
            self._monitor.restart()
            self._resets = self._monitor.health.resets
        return behind

    def acknowledge(self) -> AlarmStatus | None:
        """Release the alarms' latches; return their status, None if there is nothing to tell of."""
        return self._told.acknowledge(self._now_ns)

    def learned(self, now: float) -> Learned | None:
        """Return what has been learned of the belt; None if that is nothing yet.

        `now` is wall time [s] since the Unix epoch. What is learned is as old as the last
        measurement that was accepted, or the last maintenance.

        Raises
        ------
        MemoryRefusedError
            If it is nothing worth remembering.
        """
        return self._monitor.learned(now - self._age.seconds)

    def restore(self, learned: Learned, elapsed: float) -> str:
        """Start from what was learned `elapsed` [s] ago; return a note for the log, or "".

        Raises
        ------
        MemoryRefusedError
            If it is of another drive.
        """
        note = self._monitor.restore(learned, elapsed)
        self._age.renew()
        return note

    def maintain(self, maintenance: Maintenance) -> str:
        """Take in what was done to the belt, now; return a sentence for the log."""
        self._rest()
        message = self._monitor.maintain(maintenance)
        self._age.renew()
        self._taken_in += 1
        return message

    def _rest(self) -> None:
        """Bring what is known to the present, if that is longer ago than any gap between samples.

        Between measurements their stamps tell; before the first of a run, and at maintenance of a
        drive that stands, there are none.
        """
        if self._age.seconds > self._gap:
            self._monitor.rest(self._age.seconds)
            self._age.renew()

    def calibrate(self) -> bool:
        """Begin to calibrate the radius ratio; whether that is possible now."""
        if not self._monitor.calibrate():
            return False
        self._calibrations.begin(self._monitor.health.resets)
        return True

    def retune(self, settings: DriveSettings) -> None:
        """Use other noise, drift, limits and alarm thresholds from now on."""
        self._settings = settings
        limits = settings.limits
        if self._pool_period > limits.pool_period:
            limits = dataclasses.replace(limits, pool_period=self._pool_period)
        self._monitor.retune(settings.noise, settings.drift, limits, settings.alarm)

    def pool(self, period: float) -> None:
        """Average measurements over `period` [s] from now on, or over what the drive asks for."""
        self._pool_period = period
        self.retune(self._settings)

    def drive_status(self) -> DiagnosticStatus:
        """Return the drive's diagnostics."""
        return drive_status(
            self._node_name,
            self._settings.name,
            self._monitor.estimate if self._fresh else None,
            self._told.status,
            self._meter.unused(self._steady()),
            self._gap,
        )

    def input_report(self) -> InputReport:
        """Return what came since the last call."""
        return self._meter.report(self._steady(), self._gap)

    def input_status(self, report: InputReport) -> DiagnosticStatus:
        """Return the input's diagnostics."""
        return input_status(
            self._node_name,
            self._settings.name,
            ", ".join(self._sources),
            report,
            self._monitor.health,
            self._gap,
            self._skew_limit,
        )

    def calibration_status(self) -> DiagnosticStatus | None:
        """Return the diagnostics of the calibration; None if there never was one."""
        return self._calibrations.status(
            self._node_name, self._settings.name, self._monitor.health.resets
        )
