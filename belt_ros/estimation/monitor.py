"""The one pipeline, live and offline: measurement in; estimate, alarm and health out.

Bad measurements are turned away with a reason and counted; the state before them stays. Stamps that
jump by more than the allowed gap are believed only when several follow each other: backwards the
monitor then starts anew (a looping bag), with what was restored or set by maintenance, if anything
was; forwards it resumes with what it knows of the belt.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from belt_ros.estimation.alarm import AlarmSettings, AlarmStatus, SlipAlarm
from belt_ros.estimation.assumptions import Drift, Prior, SensorLimits, SensorNoise
from belt_ros.estimation.belt_filter import MERGE_AXES, BeltFilter
from belt_ros.estimation.calibration import Calibration, CalibrationResult, with_ratio_bias
from belt_ros.estimation.condensing import renewed
from belt_ros.estimation.estimate import (
    BeltEstimate,
    Health,
    Knowledge,
    Phase,
    Quantity,
    Reserve,
    lognormal_quantity,
)
from belt_ros.estimation.fit import InnovationFit, SensorFits
from belt_ros.estimation.gaussian_sum import Component, normalised
from belt_ros.estimation.maintenance import Maintenance, maintained
from belt_ros.estimation.measurement import Measurement, Rejection, check_measurement
from belt_ros.estimation.memory import Learned, learned_from, restore
from belt_ros.estimation.overload import Capacity
from belt_ros.estimation.readings import Readings
from belt_ros.estimation.smoother import Smoother
from belt_ros.estimation.state import STATES, Index, Reading
from belt_ros.estimation.traction import Reference, traction_reference
from belt_ros.mechanics.drive import BeltDrive

_SECONDS = 1e-9
_GATE = 1000.0  # normalised innovation squared per degree of freedom no load step explains
_GATED_AT_MOST = 3  # in a row; then it is the filter that is wrong
_JUMPS_TO_BELIEVE = 3
_MISFIT_MEMORY = 0.3  # [s]
_MISFIT_STEP = 0.1  # [s]
_MISFIT_CLIP = 10.0  # a single surprise, such as a load step, is not sustained
_LOST = 6.0  # sustained innovation per degree of freedom at which the filter counts as lost
_GROSS_SLIP_MARGIN = 0.01
_LEARNED = 0.5  # of the prior's standard deviation
_SENSORS = ("driver speed", "driven speed", "driver torque", "driven torque", "positions")
_SENSOR_OF = np.zeros(STATES, dtype=np.int64)  # by the state that it reads
_SENSOR_OF[[Index.DRIVER_SPEED, Index.DRIVEN_SPEED]] = 0, 1
_SENSOR_OF[[Index.DRIVER_TORQUE, Index.DRIVEN_TORQUE, Index.TRAVEL]] = 2, 3, 4
_MOTION = [place for place in Index if not Index.LOG_TENSION <= place <= Index.CREEP_ERROR]
_TURN = 2.0 * math.pi


@dataclass(frozen=True, slots=True)
class MonitorOutput:
    """What came of one measurement.

    `estimate` is the present one, None before the first accepted measurement; `alarm` is None
    unless the alarm has changed, `calibration` unless one has just ended.
    """

    rejection: Rejection
    estimate: BeltEstimate | None
    alarm: AlarmStatus | None
    calibration: CalibrationResult | None = None


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
        self.alarm = SlipAlarm(name, alarm or AlarmSettings())
        noise = noise or SensorNoise()
        self._filter = BeltFilter(drive, prior or Prior(), noise, drift or Drift(), turns)
        self._drive = drive
        self._noise = noise
        self._calibration = Calibration(drive, noise)
        self._belief: list[Component] | None = None  # to start from
        self._driver_radius = drive.driver.radius
        self._driven_radius = drive.driven.radius
        self._resets = 0
        self._begin()

    def _begin(self) -> None:
        self._estimate: BeltEstimate | None = None
        self._accepted = 0
        self._rejections = [0] * len(Rejection)
        self._last_rejection = Rejection.NONE
        self._innovation = (0.0, 0)
        self._misfit = 1.0
        self._gated = 0
        self._jump_ns: int | None = None
        self._jumps = 0
        self._travel_lost = 0.0
        self._travel_deviation = 0.0
        self._fit = InnovationFit()
        self._sensor_fits = SensorFits(_SENSORS)
        self._capacity: Capacity | None = None
        self._reference = self._traction_reference(self._belief)

    @property
    def estimate(self) -> BeltEstimate | None:
        """The present estimate; None before the first accepted measurement."""
        return self._estimate

    @property
    def health(self) -> Health:
        """Counts and fit, also before the first estimate; here with the fit of every sensor."""
        return replace(self._brief_health(), sensor_fits=self._sensor_fits.fits)

    def _brief_health(self) -> Health:
        return Health(
            innovation_squared=self._innovation[0],
            degrees_of_freedom=self._innovation[1],
            accepted=self._accepted,
            resets=self._resets,
            last_rejection=self._last_rejection,
            rejections=tuple(self._rejections),
            fit=self._fit.fit,
        )

    def gross_slip_probability_at(self, torque: float) -> float:
        """Probability [-] that the belt slips at a torque [N m] on the driven pulley.

        Of the present belief; 0 before the first estimate.
        """
        return 0.0 if self._capacity is None else self._capacity.gross_slip_probability_at(torque)

    def load_at_probability(self, probability: float) -> float:
        """Torque [N m] at which the belt slips with a probability; NaN before the first estimate.

        Raises
        ------
        ValueError
            Unless 0 < `probability` < 1.
        """
        if self._capacity is None:
            return math.nan
        return self._capacity.load_at_probability(probability)

    def reset(self) -> None:
        """Start anew at the priors, alarm and counters included."""
        self._belief = None
        self.restart()

    def restart(self) -> None:
        """Start anew at what was restored or set by maintenance or calibration, else at the priors.

        Alarm and counters start anew as well; a calibration that is under way is given up.
        """
        self._resets += 1
        self._calibration = Calibration(self._drive, self._noise)
        self._begin()
        self.alarm.reset()

    def retune(
        self, noise: SensorNoise, drift: Drift, limits: SensorLimits, alarm: AlarmSettings
    ) -> None:
        """Go on with other noise, drift, limits and alarm thresholds, keeping all that is known."""
        self._filter.retune(noise, drift)
        self._noise = noise
        if not self._calibration.running:
            self._calibration = Calibration(self._drive, noise)
        self.limits = limits
        self.alarm.settings = alarm

    def learned(self, date: float) -> Learned | None:
        """Return what has been learned of the belt, None if that is nothing yet.

        `date` is that of the last measurement [s], since the Unix epoch, by the caller's clock.
        """
        known = self._belief if self._estimate is None else self._filter.belief()
        return None if known is None else learned_from(known, self.name, self._drive, date)

    def restore(self, learned: Learned, elapsed: float) -> str:
        """Start from what was learned `elapsed` [s] ago; return a note for the log, or "".

        Raises
        ------
        MemoryRefusedError
            If it is of another drive.
        """
        f = self._filter
        restored = restore(learned, self._drive, f.prior_mean, f.prior_stddev, f.drift, elapsed)
        self._adopt(restored.components)
        return restored.note

    def maintain(self, maintenance: Maintenance) -> str:
        """Take in what was done to the belt; return a sentence for the log."""
        f = self._filter
        known = self._belief if self._estimate is None else f.belief()
        prior = Component(0.0, f.prior_mean.copy(), np.diag(f.prior_stddev**2))
        done = maintained(known or [prior], maintenance, f.prior_mean, f.prior_stddev)
        self._adopt(done.components)
        return done.message

    def _adopt(self, belief: list[Component]) -> None:
        """Start, or go on, from another belief, with which traction is compared from now on."""
        mean, variance = self._filter.prior_mean[_MOTION], self._filter.prior_stddev[_MOTION] ** 2
        self._belief = [renewed(member, _MOTION, mean, variance) for member in belief]
        self._reference = self._traction_reference(belief)
        if self._estimate is not None:
            self._filter.adopt_belief(belief)

    def _traction_reference(self, belief: list[Component] | None) -> Reference:
        f = self._filter
        mean = f.prior_mean
        if belief:
            weights = normalised(np.array([c.log_weight for c in belief]))
            mean = weights @ np.stack([c.mean for c in belief])
        return traction_reference(
            f.constants,
            float(mean[Index.LOG_TENSION]),
            float(mean[Index.LOG_FRICTION]),
            float(f.prior_stddev[Index.LOG_FRICTION]),
        )

    def calibrate(self) -> bool:
        """Begin to calibrate the radius ratio, at no load; whether that is possible now.

        The result comes with the output of a later measurement.
        """
        if self._estimate is None:
            return False
        self._calibration.begin(self._estimate.stamp_ns)
        return True

    def smoother(self) -> Smoother:
        """Return a smoother that hears of all measurements to come; call `finish` at the end."""
        smoother = Smoother(self._filter.prior_mean, Index.LOG_TENSION, MERGE_AXES)
        self._filter.record(smoother)
        return smoother

    def finish(self) -> None:
        """Tell the smoother that no more measurements come."""
        self._filter.finish()

    def acknowledge(self) -> AlarmStatus | None:
        """Release the alarm's latch; return its status, None before the first estimate."""
        return None if self._estimate is None else self.alarm.acknowledge(self._estimate)

    def reject(self, reason: Rejection) -> MonitorOutput:
        """Count a measurement that cannot be used."""
        self._rejections[reason] += 1
        self._last_rejection = reason
        return MonitorOutput(reason, self._estimate, None)

    def step(self, measurement: Measurement) -> MonitorOutput:
        """Take in one measurement, or turn it away."""
        reason = check_measurement(measurement, self.limits)
        if reason is not Rejection.NONE:
            return self.reject(reason)
        if self._estimate is None:
            if any(map(math.isnan, measurement.speeds)):
                return self.reject(Rejection.INCOMPLETE)
            self._filter.start(measurement, self._belief)
        else:
            reason = self._advance(measurement)
            if reason is not Rejection.NONE:
                return self.reject(reason)
        self._accepted += 1
        self._estimate = self._describe(measurement.stamp_ns)
        calibrated = self._calibration.take(measurement, self._estimate)
        if calibrated is not None and calibrated.ratio_bias is not None:
            self._adopt(with_ratio_bias(self._filter.belief(), calibrated.ratio_bias))
        alarm = self.alarm.update(self._estimate)
        return MonitorOutput(Rejection.NONE, self._estimate, alarm, calibrated)

    def _advance(self, measurement: Measurement) -> Rejection:
        """Move the filter to `measurement` and take it in, if its stamp and value allow."""
        assert self._filter.stamp_ns is not None
        dt = (measurement.stamp_ns - self._filter.stamp_ns) * _SECONDS
        if abs(dt) > self.limits.greatest_gap:
            return self._jump(measurement, forward=dt > 0.0)
        self._jump_ns = None
        if dt <= 0.0:
            return Rejection.OUT_OF_ORDER
        try:
            return self._take_in(measurement, dt)
        except FloatingPointError:  # beyond all reason; better to know nothing than to say NaN
            self.reset()
            if any(map(math.isnan, measurement.speeds)):
                return Rejection.INCOMPLETE
            self._filter.start(measurement)
            return Rejection.NONE

    def _take_in(self, measurement: Measurement, dt: float) -> Rejection:
        """Move the filter by `dt` [s] and take the measurement in, unless it is impossible."""
        innovation = self._filter.predict(measurement)
        if not innovation <= _GATE:
            self._gated += 1
            incomplete = any(map(math.isnan, measurement.speeds))
            if self._gated <= _GATED_AT_MOST or incomplete:
                return Rejection.GATED
            self._filter.resume(measurement)
        else:
            self._innovation = self._filter.update()
            self._judge_fit(dt)
        self._gated = 0
        surprise = min(innovation, _MISFIT_CLIP) - self._misfit
        # One surprise alone, after a gap, is not sustained.
        self._misfit -= math.expm1(-min(dt, _MISFIT_STEP) / _MISFIT_MEMORY) * surprise
        return Rejection.NONE

    def _judge_fit(self, dt: float) -> None:
        """Compare innovations with what they should be; at standstill they say nothing."""
        standing = self._estimate is not None and self._estimate.phase is Phase.STANDSTILL
        self._fit.update(*((0.0, 0) if standing else self._innovation), dt)
        f = self._filter
        seen = _SENSOR_OF[f.seen[:0] if standing else f.seen]
        self._sensor_fits.update(seen, f.surprises, dt)

    def _jump(self, measurement: Measurement, *, forward: bool) -> Rejection:
        """Believe a jump in time once several stamps follow it."""
        stamp = measurement.stamp_ns
        gap = self.limits.greatest_gap
        since = None if self._jump_ns is None else (stamp - self._jump_ns) * _SECONDS
        follows = since is not None and since > 0.0 and (forward or since <= gap)
        self._jumps = self._jumps + 1 if follows else 1
        self._jump_ns = stamp
        if self._jumps < _JUMPS_TO_BELIEVE:
            return Rejection.OUT_OF_ORDER
        if any(map(math.isnan, measurement.speeds)):
            return Rejection.INCOMPLETE
        self._jump_ns = None
        if forward:
            self._filter.resume(measurement)
        else:
            self.restart()
            self._filter.start(measurement, self._belief)
        return Rejection.NONE

    def _describe(self, stamp_ns: int) -> BeltEstimate:
        """Read the estimate off the filter."""
        f = self._filter
        readings = f.readings(self.limits.standstill_speed)
        read = readings.quantity

        def state(place: Index) -> Quantity:
            return Quantity(float(f.x[place]), math.sqrt(float(f.covariance[place, place])))

        def positive(place: Index) -> Quantity:
            return lognormal_quantity(*state(place))

        sliding = readings.probability_below(Reading.MARGIN, _GROSS_SLIP_MARGIN)
        log_stiffness = state(Index.LOG_STIFFNESS)
        return BeltEstimate(
            stamp_ns=stamp_ns,
            phase=self._phase(read(Reading.SLIP).value, sliding),
            driver_speed=state(Index.DRIVER_SPEED),
            driven_speed=state(Index.DRIVEN_SPEED),
            transmitted_torque=read(Reading.TRANSMITTED_TORQUE),
            slip=read(Reading.SLIP),
            predicted_creep=read(Reading.PREDICTED_CREEP),
            excess_slip=read(Reading.EXCESS_SLIP),
            accumulated_slip=self._accumulate(stamp_ns, read(Reading.SLIP_SPEED)),
            tight_tension=read(Reading.TIGHT_TENSION),
            slack_tension=read(Reading.SLACK_TENSION),
            mean_tension=read(Reading.MEAN_TENSION),
            friction_stiffness=positive(Index.LOG_STIFFNESS),
            friction_stiffness_log_stddev=log_stiffness.stddev,
            friction_coefficient=positive(Index.LOG_FRICTION),
            ratio_bias=state(Index.RATIO_BIAS),
            creep_model_error=state(Index.CREEP_ERROR),
            driven_transition_angle=read(Reading.DRIVEN_TRANSITION),
            driver_transition_angle=read(Reading.DRIVER_TRANSITION),
            margin=read(Reading.MARGIN),
            gross_slip_probability=sliding,
            tension_knowledge=self._knowledge(Index.LOG_TENSION),
            friction_stiffness_knowledge=self._knowledge(Index.LOG_STIFFNESS),
            friction_coefficient_knowledge=self._knowledge(Index.LOG_FRICTION),
            health=self._brief_health(),
            reserve=self._reserve(readings),
            lost_traction=f.lost_traction(self._reference),
        )

    def _reserve(self, readings: Readings) -> Reserve:
        capacity = self._capacity = readings.capacity(Reading.CAPACITY)
        peak = self.limits.peak_load
        at_peak = capacity.gross_slip_probability_at(peak) if peak > 0.0 else 0.0
        return Reserve(capacity.torque, at_peak)

    def _accumulate(self, stamp_ns: int, slip_speed: Quantity) -> Quantity:
        """Integrate the slip speed [m/s] to rim travel lost [m]."""
        if self._estimate is not None:
            dt = (stamp_ns - self._estimate.stamp_ns) * _SECONDS
            if 0.0 < dt <= self.limits.greatest_gap:
                self._travel_lost += slip_speed.value * dt
                # Most of it is the ratio bias, which is the same all along.
                self._travel_deviation += slip_speed.stddev * dt
        return Quantity(self._travel_lost, self._travel_deviation)

    def _phase(self, slip: float, sliding: float) -> Phase:
        x = self._filter.x
        driver_rim = x[Index.DRIVER_SPEED] * self._driver_radius
        driven_rim = x[Index.DRIVEN_SPEED] * self._driven_radius
        if self._misfit > _LOST:
            return Phase.LOST
        if max(abs(driver_rim), abs(driven_rim)) < self.limits.standstill_speed:
            return Phase.STANDSTILL
        if sliding > 0.5:
            return Phase.GROSS_SLIP
        if driver_rim * x[Index.PULL] < 0.0 and slip < 0.0:
            return Phase.REGENERATING
        return Phase.REVERSE if driver_rim < 0.0 else Phase.RUNNING

    def _knowledge(self, place: Index) -> Knowledge:
        f = self._filter
        spread = math.sqrt(float(f.covariance[place, place]))
        learned = spread < _LEARNED * float(f.prior_stddev[place])
        return Knowledge.LEARNED if learned else Knowledge.AT_PRIOR
