"""The one pipeline, live and offline: measurement in; estimate, alarm and health out.

Bad measurements are turned away with a reason and counted; the state before them stays. Stamps that
jump by more than the allowed gap are believed only when several follow each other: backwards the
monitor then starts anew (a looping bag), forwards it resumes with what it knows of the belt.
"""

import math
from dataclasses import dataclass

import numpy as np

from belt_ros.estimation.alarm import AlarmSettings, AlarmStatus, SlipAlarm
from belt_ros.estimation.assumptions import Drift, Prior, SensorLimits, SensorNoise
from belt_ros.estimation.belt_filter import BeltFilter
from belt_ros.estimation.estimate import (
    BeltEstimate,
    Health,
    Knowledge,
    Phase,
    Quantity,
    lognormal_quantity,
)
from belt_ros.estimation.gaussian_sum import Component
from belt_ros.estimation.maintenance import Maintenance, maintained
from belt_ros.estimation.measurement import Measurement, Rejection, check_measurement
from belt_ros.estimation.memory import Learned, learned_from, restore
from belt_ros.estimation.state import Index, Reading
from belt_ros.mechanics.drive import BeltDrive

_SECONDS = 1e-9
_GATE = 1000.0  # normalised innovation squared per degree of freedom no load step explains
_GATED_AT_MOST = 3  # in a row; then it is the filter that is wrong
_JUMPS_TO_BELIEVE = 3
_MISFIT_MEMORY = 0.3  # [s]
_MISFIT_CLIP = 10.0  # a single surprise, such as a load step, is not sustained
_LOST = 6.0  # sustained innovation per degree of freedom at which the filter counts as lost
_GROSS_SLIP_MARGIN = 0.01
_LEARNED = 0.5  # of the prior's standard deviation


@dataclass(frozen=True, slots=True)
class MonitorOutput:
    """What came of one measurement.

    `estimate` is the present one, None before the first accepted measurement; `alarm` is None
    unless the alarm has changed.
    """

    rejection: Rejection
    estimate: BeltEstimate | None
    alarm: AlarmStatus | None


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
    ) -> None:
        self.name = name
        self.limits = limits or SensorLimits()
        self.alarm = SlipAlarm(name, alarm or AlarmSettings())
        self._filter = BeltFilter(drive, prior or Prior(), noise or SensorNoise(), drift or Drift())
        self._drive = drive
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

    @property
    def estimate(self) -> BeltEstimate | None:
        """The present estimate; None before the first accepted measurement."""
        return self._estimate

    @property
    def health(self) -> Health:
        """Counts and fit, also before the first estimate."""
        return Health(
            innovation_squared=self._innovation[0],
            degrees_of_freedom=self._innovation[1],
            accepted=self._accepted,
            resets=self._resets,
            last_rejection=self._last_rejection,
            rejections=tuple(self._rejections),
        )

    def reset(self) -> None:
        """Start anew at the priors, alarm and counters included."""
        self._belief = None
        self._resets += 1
        self._begin()
        self.alarm.reset()

    def retune(
        self, noise: SensorNoise, drift: Drift, limits: SensorLimits, alarm: AlarmSettings
    ) -> None:
        """Go on with other noise, drift, limits and alarm thresholds, keeping all that is known."""
        self._filter.noise = noise
        self._filter.drift = drift
        self.limits = limits
        self.alarm.settings = alarm

    def learned(self, date: float) -> Learned | None:
        """Return what has been learned of the belt, None before the first estimate.

        `date` is that of the last measurement [s], since the Unix epoch, by the caller's clock.
        """
        if self._estimate is None:
            return None
        return learned_from(self._filter.belief(), self.name, self._drive, date)

    def restore(self, learned: Learned, elapsed: float) -> str:
        """Start from what was learned `elapsed` [s] ago; return a note for the log, or "".

        Raises
        ------
        MemoryRefusedError
            If it is of another drive.
        """
        f = self._filter
        restored = restore(learned, self._drive, f.prior_mean, f.prior_stddev, f.drift, elapsed)
        self._belief = restored.components
        if self._estimate is not None:
            f.adopt_belief(restored.components)
        return restored.note

    def maintain(self, maintenance: Maintenance) -> str:
        """Take in what was done to the belt; return a sentence for the log."""
        f = self._filter
        known = self._belief if self._estimate is None else f.belief()
        prior = Component(0.0, f.prior_mean.copy(), np.diag(f.prior_stddev**2))
        done = maintained(known or [prior], maintenance, f.prior_mean, f.prior_stddev)
        self._belief = done.components
        if self._estimate is not None:
            f.adopt_belief(done.components)
        return done.message

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
            self._filter.start(measurement, self._belief)
        else:
            reason = self._advance(measurement)
            if reason is not Rejection.NONE:
                return self.reject(reason)
        self._accepted += 1
        self._estimate = self._describe(measurement.stamp_ns)
        return MonitorOutput(Rejection.NONE, self._estimate, self.alarm.update(self._estimate))

    def _advance(self, measurement: Measurement) -> Rejection:
        """Move the filter to `measurement` and take it in, if its stamp and value allow."""
        assert self._filter.stamp_ns is not None
        dt = (measurement.stamp_ns - self._filter.stamp_ns) * _SECONDS
        if abs(dt) > self.limits.greatest_gap:
            return self._jump(measurement, forward=dt > 0.0)
        self._jump_ns = None
        if dt <= 0.0:
            return Rejection.OUT_OF_ORDER
        innovation = self._filter.predict(measurement)
        if not innovation <= _GATE:
            self._gated += 1
            if self._gated <= _GATED_AT_MOST:
                return Rejection.GATED
            self._filter.resume(measurement)
        else:
            self._innovation = self._filter.update(measurement)
        self._gated = 0
        surprise = min(innovation, _MISFIT_CLIP) - self._misfit
        self._misfit -= math.expm1(-dt / _MISFIT_MEMORY) * surprise
        return Rejection.NONE

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
        self._jump_ns = None
        if forward:
            self._filter.resume(measurement)
        else:
            self.reset()
            self._filter.start(measurement)
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
            health=self.health,
        )

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
