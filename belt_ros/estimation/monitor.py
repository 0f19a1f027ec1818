"""The one pipeline, live and offline: measurement in; estimate, alarm and health out.

Bad measurements are turned away with a reason and counted; the state before them stays (`intake`).
Where stamps jump back the monitor starts anew (a looping bag), with what was restored or set by
maintenance, if anything was; forwards it resumes with what it knows of the belt. While sensors do
not fit, what was believed of the belt before counts as much as what they make of it (`credence`).
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from belt_ros.estimation.account import Account
from belt_ros.estimation.alarm import SlipAlarm
from belt_ros.estimation.alarm_settings import AlarmSettings, Condition
from belt_ros.estimation.assumptions import Drift, Prior, SensorLimits, SensorNoise
from belt_ros.estimation.belt_filter import BeltFilter
from belt_ros.estimation.calibration import Calibration, CalibrationResult, with_ratio_bias
from belt_ros.estimation.condition import AlarmStatus
from belt_ros.estimation.credence import Credence
from belt_ros.estimation.estimate import BeltEstimate, Health
from belt_ros.estimation.gaussian_sum import Component
from belt_ros.estimation.health_record import HealthRecord
from belt_ros.estimation.installed import installed_as
from belt_ros.estimation.intake import Anew, Intake
from belt_ros.estimation.keeper import Keeper
from belt_ros.estimation.maintenance import Maintenance
from belt_ros.estimation.measurement import Measurement, Rejection, check_measurement
from belt_ros.estimation.memory import Learned
from belt_ros.estimation.pooling import Pool
from belt_ros.estimation.smoother import Smoother
from belt_ros.estimation.state import Index
from belt_ros.estimation.upkeep import MERGE_AXES
from belt_ros.estimation.wind_up import WindUp
from belt_ros.mechanics.drive import BeltDrive, Tensioning

_TURN = 2.0 * math.pi


@dataclass(frozen=True, slots=True)
class MonitorOutput:
    """What came of one measurement.

    `estimate` is the present one, None before the first accepted measurement, and `fresh` if this
    measurement has made it: a rejected one has not, nor one that is still being pooled. `alarm` is
    None unless the alarm has changed, `calibration` unless one has just ended.
    """

    rejection: Rejection
    estimate: BeltEstimate | None
    alarm: AlarmStatus | None
    calibration: CalibrationResult | None = None
    fresh: bool = False


class BeltMonitor:
    """Estimate one drive's state from its measurements, in the order of their stamps."""

    def __init__(
        self,
        name: str,
        drive: BeltDrive,
        prior: Prior | None = None,
        noise: SensorNoise | None = None,
        drift: Drift | None = None,
        limits: SensorLimits | None = None,
        alarm: AlarmSettings | None = None,
        turns: tuple[float, float] = (_TURN, _TURN),
    ) -> None:
        self.name = name
        self.limits = limits or SensorLimits()
        noise, prior = noise or SensorNoise(), prior or Prior()
        self._filter = BeltFilter(drive, prior, noise, drift or Drift(), turns)
        c = self._filter.constants
        self.alarm = SlipAlarm(
            name,
            alarm or AlarmSettings(),
            self.limits,
            prior.tension,
            slack_held=drive.tensioning is Tensioning.CONSTANT_SLACK,
            wind_up=WindUp(
                c.span_compliance, c.driver_radius, c.driven_radius, self.limits.standstill_speed
            ),
        )
        self._drive = drive
        self._turns = turns
        self._noise = noise
        whole = Component(0.0, self._filter.prior_mean, np.diag(self._filter.prior_stddev**2))
        told = installed_as([whole], prior.tension)
        self._credence = Credence(self._filter, drive, told)
        self._keeper = Keeper(name, drive, self._filter, self._credence, told)
        self._calibration = Calibration(drive, noise)
        self._record = HealthRecord()
        self._intake = Intake(
            self._filter, self._credence, self._record, lambda: self.alarm.watch, turns
        )
        self._account = Account(self._filter, self._credence, self._record, drive)
        self._begin()

    def _begin(self) -> None:
        self._intake.begin(self._noise, self.limits)
        self._pool = Pool(self.limits.pooled_over, self._turns)
        self._credence.begin()
        self._record.begin()
        self._account.begin()

    @property
    def estimate(self) -> BeltEstimate | None:
        """The present estimate; None before the first accepted measurement."""
        return self._account.estimate

    @property
    def health(self) -> Health:
        """Counts and fit, also before the first estimate; here with the fit of every sensor."""
        return self._record.health

    @property
    def waiting(self) -> int:
        """How many measurements are being pooled, neither accepted nor rejected yet."""
        return self._pool.waiting

    def gross_slip_probability_at(self, torque: float) -> float:
        """Probability [-] that the belt slips at a torque [N m] on the driven pulley.

        Of the present belief; 0 before the first estimate.
        """
        capacity = self._account.capacity
        return 0.0 if capacity is None else capacity.gross_slip_probability_at(torque)

    def load_at_probability(self, probability: float) -> float:
        """Torque [N m] at which the belt slips with a probability; NaN before the first estimate.

        Raises
        ------
        ValueError
            Unless 0 < `probability` < 1.
        """
        capacity = self._account.capacity
        if capacity is None:
            return math.nan
        return capacity.load_at_probability(probability)

    def reset(self) -> None:
        """Start anew at the priors, alarm and counters included."""
        self._keeper.forget()
        self.restart()
        self._record.reset()
        self.alarm.reset()
        self.alarm.installed = self._keeper.installed.tension

    def start_anew(self) -> None:
        """Start anew at the priors, after what could not be computed; measurements stay counted."""
        self._credence.initial = None
        self.restart()

    def restart(self) -> None:
        """Start anew at what was restored or set by maintenance or calibration, else at the priors.

        A calibration that is under way is given up, and what is raised is judged anew; latches stay
        until acknowledged, and measurements go on being counted.
        """
        self._record.count_reset()
        self._calibration = Calibration(self._drive, self._noise)
        self._begin()
        self.alarm.begin_anew()

    def retune(
        self, noise: SensorNoise, drift: Drift, limits: SensorLimits, alarm: AlarmSettings
    ) -> None:
        """Go on with other noise, drift, limits and alarm thresholds, keeping all that is known."""
        self._filter.retune(noise, drift)
        self._noise = noise
        self._pool.retune(limits.pooled_over)
        self._intake.retune(noise, limits)
        self.limits = limits
        self.alarm.retune(alarm, limits)

    def learned(self, date: float) -> Learned | None:
        """Return what has been learned of the belt, None if that is nothing yet.

        `date` is that of the last measurement [s], since the Unix epoch, by the caller's clock.
        """
        return self._keeper.learned(date)

    def restore(self, learned: Learned, elapsed: float) -> str:
        """Start from what was learned `elapsed` [s] ago; return a note for the log, or "".

        Raises
        ------
        MemoryRefusedError
            If it is of another drive.
        """
        self._end_lull()
        note = self._keeper.restore(learned, elapsed)
        self._believe_anew()
        return note

    def rest(self, elapsed: float) -> None:
        """Let what is known age by `elapsed` [s] of standstill in which nothing was measured.

        It is as if the drive had been switched off, and what it had learned restored.
        """
        self._end_lull()
        self._keeper.rest(elapsed)
        self._believe_anew()

    def maintain(self, maintenance: Maintenance) -> str:
        """Take in what was done to the belt, now; return a sentence for the log.

        What was not measured for a while has to `rest` before, so that it is known as of now.
        """
        self._end_lull()
        message = self._keeper.maintain(maintenance)
        self._believe_anew()
        return message

    def _believe_anew(self) -> None:
        """Tell who speaks of the belt that something else is believed of it."""
        self._account.forget()
        self.alarm.installed = self._keeper.installed.tension

    def calibrate(self) -> bool:
        """Begin to calibrate the radius ratio, at no load; whether that is possible now.

        The result comes with the output of a later measurement.
        """
        if self.estimate is None:
            return False
        self._calibration = Calibration(self._drive, self._noise)
        self._calibration.begin(self.estimate.stamp_ns)
        return True

    def smoother(self) -> Smoother:
        """Return a smoother that hears of all measurements to come; call `finish` at the end."""
        smoother = Smoother(self._filter.prior_mean, Index.LOG_TENSION, MERGE_AXES)
        self._filter.record(smoother)
        return smoother

    def finish(self) -> None:
        """Take in what waits, and tell the smoother that no more measurements come."""
        for pooled in self._pool.flush():
            self._step(pooled, timely=True)
        estimate = self.estimate
        if self._intake.waits and estimate is not None:
            self._end_lull()
            self._account.tell(estimate.stamp_ns, self.limits, waits=False)
        self._filter.finish()

    def acknowledge(self, condition: Condition | None = None) -> AlarmStatus | None:
        """Release the latch of one alarm, or of all; None if there is nothing to tell of."""
        if self.estimate is None and not self.alarm.told:
            return None
        return self.alarm.acknowledge(self.estimate, condition)

    @property
    def longest_silence(self) -> float:
        """Time [s] without a usable measurement after which `silent` has something to tell."""
        return self.alarm.longest_silence

    def silent(self, stamp_ns: int, silence: float) -> AlarmStatus | None:
        """Hear that nothing usable has come for `silence` [s]; return the alarm if it has changed.

        `stamp_ns` is now [ns] on the clock of the measurements, by whoever owns one.
        """
        return self.alarm.silent(stamp_ns, silence)

    def pause(self) -> None:
        """Expect a pause: nobody listens for a while, and no sensor is to blame for it."""
        for pooled in self._pool.flush():  # of before the pause
            self._step(pooled, timely=True)
        if self.estimate is not None:
            self._intake.pause()
        self.alarm.pause()

    def reject(self, reason: Rejection, measurement: Measurement | None = None) -> MonitorOutput:
        """Count a measurement that cannot be used."""
        self._record.reject(reason, 1 if measurement is None else measurement.pooled)
        return MonitorOutput(reason, self.estimate, self.alarm.turned_away(reason, measurement))

    def step(self, measurement: Measurement, *, timely: bool = True) -> MonitorOutput:
        """Take in one measurement, or turn it away; what comes fast is pooled first.

        After a `pause`, a stamp that is far ahead is believed at once if it is `timely`, near the
        present as the caller's clock has it.
        """
        reason = check_measurement(measurement, self.limits)
        if reason is Rejection.NONE and self._pool.overtaken(measurement.stamp_ns):
            reason = Rejection.OUT_OF_ORDER
        if reason is not Rejection.NONE:
            return self.reject(reason, measurement)
        output = MonitorOutput(Rejection.NONE, self.estimate, None)
        for pooled in self._pool.take(measurement):
            before, output = output, self._step(pooled, timely=timely)
            if before.alarm or before.calibration:
                output = replace(
                    output,
                    alarm=output.alarm or before.alarm,
                    calibration=output.calibration or before.calibration,
                )
        return output

    def _step(self, measurement: Measurement, *, timely: bool) -> MonitorOutput:
        if self.estimate is None:
            if not self._filter.start(measurement, self._credence.initial):
                return self.reject(Rejection.INCOMPLETE, measurement)
        else:
            reason = self._intake.take(measurement, self.estimate, timely=timely)
            self._begin_anew_if_due()
            if reason is not Rejection.NONE:
                return self.reject(reason, measurement)
        self._record.accept(measurement.pooled)
        self._credence.see(measurement)
        stamp_ns = measurement.stamp_ns
        estimate = self._account.tell(stamp_ns, self.limits, waits=self._intake.waits)
        self._credence.keep(stamp_ns, estimate.lost_traction)
        calibrated = self._calibration.take(measurement, estimate)
        if calibrated is not None and calibrated.ratio_bias is not None:
            self._end_lull()
            self._credence.adopt(with_ratio_bias(self._credence.known or [], calibrated.ratio_bias))
            self._account.forget()
        alarm = self.alarm.update(
            estimate, measurement, self._account.capacity, recovers=self._credence.recovers
        )
        if self.alarm.watch.contradicts(doubted=self._credence.doubted):
            self._credence.contradict()
        return MonitorOutput(Rejection.NONE, estimate, alarm, calibrated, fresh=True)

    def _end_lull(self) -> None:
        """Take in what waits."""
        self._intake.end_lull(self.estimate)
        self._begin_anew_if_due()

    def _begin_anew_if_due(self) -> None:
        """Start all else anew where the filter has been."""
        if self._intake.anew is Anew.WENT_BACK:
            self.restart()
        elif self._intake.anew is Anew.FAILED:
            self.start_anew()
