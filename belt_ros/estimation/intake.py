"""The way of a measurement into the filter: at once, with others that wait, or not at all.

Stamps that jump by more than the allowed gap are believed only when several follow each other
(`time_jumps`); what says nothing new waits (`lull`); what is impossible is turned away (`gate`).
"""

from collections.abc import Callable
from enum import Enum

import numpy as np

from belt_ros.estimation.assumptions import SensorLimits, SensorNoise
from belt_ros.estimation.belt_filter import BeltFilter
from belt_ros.estimation.credence import Credence
from belt_ros.estimation.estimate import BeltEstimate, Phase
from belt_ros.estimation.gate import Gate
from belt_ros.estimation.health_record import HealthRecord
from belt_ros.estimation.lull import Lull
from belt_ros.estimation.measurement import Measurement, Rejection
from belt_ros.estimation.sensor_watch import SensorWatch
from belt_ros.estimation.time_jumps import TimeJumps

_SECONDS = 1e-9


class Anew(Enum):
    """Why the filter has begun anew."""

    NO = 0
    WENT_BACK = 1  # the stamps did: where the run began
    FAILED = 2  # numbers beyond all reason: at the priors


class Intake:
    """Moves a filter that has been started from one measurement to the next.

    Parameters
    ----------
    belt_filter : BeltFilter
    credence : Credence
        Is told how the measurements fit, and has what to start from where time goes back.
    record : HealthRecord
        Is told how they fit, too.
    watch : callable
        Returns who watches the sensors at present.
    turns : tuple of float
        One turn of either joint, seen at its pulley [rad].

    Attributes
    ----------
    anew : Anew
        Why the filter has begun anew since `begin`, which is to be called then.
    """

    def __init__(
        self,
        belt_filter: BeltFilter,
        credence: Credence,
        record: HealthRecord,
        watch: Callable[[], SensorWatch],
        turns: tuple[float, float],
    ) -> None:
        self._filter = belt_filter
        self._credence = credence
        self._record = record
        self._watch = watch
        self._turns = turns

    def begin(self, noise: SensorNoise, limits: SensorLimits) -> None:
        """Wait for nothing, blame nothing, and take the next jump for the first."""
        self.anew = Anew.NO
        self._gap = limits.greatest_gap
        self._gate = Gate()
        self._lull = Lull(self._turns, noise.noise_rows())
        self._jumps = TimeJumps()
        self._paused = False

    def retune(self, noise: SensorNoise, limits: SensorLimits) -> None:
        """Go on with other noise and limits."""
        self._gap = limits.greatest_gap
        self._lull.retune(noise.noise_rows())

    @property
    def waits(self) -> bool:
        """Whether measurements wait to be taken in."""
        return self._lull.waits

    def pause(self) -> None:
        """Expect that stamps jump ahead, for nobody listens for a while."""
        self._paused = True

    def take(self, measurement: Measurement, estimate: BeltEstimate, *, timely: bool) -> Rejection:
        """Take `measurement` in, or let it wait for others, if its stamp and value allow.

        Parameters
        ----------
        measurement : Measurement
        estimate : BeltEstimate
            The present one.
        timely : bool
            Whether the stamp is near the present as the caller's clock has it: after a pause, only
            then is a jump ahead believed at once.
        """
        assert self._filter.stamp_ns is not None, "the filter has been started"
        # What waits is later than the filter; what was gated is later than the estimate.
        last_ns = max(estimate.stamp_ns, self._filter.stamp_ns)
        dt = (measurement.stamp_ns - last_ns) * _SECONDS
        if abs(dt) > self._gap:
            self.end_lull(estimate)
            return self._jump(measurement, dt, timely=timely)
        if dt <= 0.0:
            return Rejection.OUT_OF_ORDER
        self._jumps.forget(dt)
        self._paused = False
        return self._move(self._lull.take(measurement), estimate)

    def end_lull(self, estimate: BeltEstimate | None) -> None:
        """Take in what waits; `estimate` is the present one."""
        self._move(self._lull.end(), estimate)

    def _move(
        self, measurements: tuple[Measurement, ...], estimate: BeltEstimate | None
    ) -> Rejection:
        """Move the filter from one to the next; return what became of the last."""
        standing = estimate is not None and estimate.phase is Phase.STANDSTILL
        reason = Rejection.NONE
        for each in measurements:
            reason = self._move_to(each, standing=standing)
        return reason

    def _move_to(self, measurement: Measurement, *, standing: bool) -> Rejection:
        """Move the filter to `measurement` and take it in, if its values allow."""
        f = self._filter
        assert f.stamp_ns is not None
        dt = (measurement.stamp_ns - f.stamp_ns) * _SECONDS
        try:
            with np.errstate(over="raise", invalid="raise"):
                reason = self._take_in(measurement, dt, standing=standing)
        except FloatingPointError:  # beyond all reason; better to know nothing than to say NaN
            self.anew = Anew.FAILED
            return Rejection.NONE if f.start(measurement) else Rejection.INCOMPLETE
        fits = reason is Rejection.NONE and not self._credence.doubted
        self._lull.expect(f.expected if fits and f.calm else None, dt)
        return reason

    def _take_in(self, measurement: Measurement, dt: float, *, standing: bool) -> Rejection:
        """Move the filter by `dt` [s] and take the measurement in, unless it is impossible."""
        f, gate = self._filter, self._gate
        innovation = f.predict(measurement)
        if not gate.passes(innovation):
            f.disregard()
            often = gate.turn_away(f.seen, measurement.stamp_ns, self._gap)
            if not (often and f.resume(measurement)):
                return Rejection.GATED
            gate.open()
            self._credence.contradict()
        else:
            self._record.judge(f.update(), f.seen, f.surprises, dt, standing=standing)
            if not standing:
                self._watch().see(f.seen, f.surprises, dt)
            if gate.blames:
                gate.let_pass(f.seen)
                f.keep_reading(measurement)
        self._credence.judge(innovation, dt)
        self._credence.reconsider(measurement.stamp_ns)
        return Rejection.NONE

    def _jump(self, measurement: Measurement, dt: float, *, timely: bool) -> Rejection:
        """Believe a jump in time, by `dt` [s], once several stamps follow it."""
        forward = dt > 0.0
        believed = self._jumps.believed(measurement.stamp_ns, self._gap, dt)
        if not (believed or (self._paused and timely and forward)):
            return Rejection.OUT_OF_ORDER
        f = self._filter
        begun = f.resume(measurement) if forward else f.start(measurement, self._credence.initial)
        if not begun:
            return Rejection.INCOMPLETE
        self._jumps.forget()
        self._paused = False
        if not forward:
            self.anew = Anew.WENT_BACK
        return Rejection.NONE
