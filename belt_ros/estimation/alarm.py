"""The alarms of one drive: what is judged, and what is told of it.

Each condition is an alarm of its own (see `condition`). Margin, slip and traction are judged by
probability, not by the estimate alone: what the data cannot tell raises nothing. While a sensor is
implausible none of these rises anew, while the estimator is lost none but gross slip. Time is that
of the estimates, or of whoever says that none have come. The alarms advise; they are no safety
function.
"""

import math

from belt_ros.estimation.alarm_settings import AlarmSettings, Condition, Severity
from belt_ros.estimation.assumptions import SensorLimits
from belt_ros.estimation.belt_evidence import (
    RESTING,
    gross_slip_evidence,
    margin_evidence,
    slip_evidence,
    traction_evidence,
)
from belt_ros.estimation.channels import Channels
from belt_ros.estimation.condition import (
    AlarmStatus,
    ConditionAlarm,
    Delays,
    Evidence,
)
from belt_ros.estimation.estimate import BeltEstimate, Phase, Quantity
from belt_ros.estimation.measurement import Measurement, Rejection
from belt_ros.estimation.overload import Capacity
from belt_ros.estimation.sensor_watch import SensorWatch
from belt_ros.estimation.sentences import Tension, over, recovering, sentence, unheard
from belt_ros.estimation.suspicion import Suspicion
from belt_ros.estimation.traction import named_loss
from belt_ros.estimation.wind_up import WindUp

_SECONDS = 1e-9
_UNHEARD = 10.0  # [s] at least before the first measurement: sensors may start after the alarms
_SUSPICION = 2.0  # [s] beyond the on-delay for which belt alarms wait for bad messages
_ANY_MARGIN = Quantity(0.5, math.sqrt(1.0 / 12.0))  # before anything is known


class SlipAlarm:
    """The alarms of one drive. `update` returns their status when that has changed, else None.

    Parameters
    ----------
    name : str
        Of the drive.
    settings : AlarmSettings
    limits : SensorLimits, optional
        When silence is too long.
    installed : float
        Tension as told [N]; it stands in messages.
    slack_held : bool
        Whether this is the slack tension rather than the mean.
    wind_up : WindUp, optional
        What the spans take up; without it, it counts as slip.
    """

    def __init__(
        self,
        name: str,
        settings: AlarmSettings,
        limits: SensorLimits | None = None,
        installed: float = math.nan,
        *,
        slack_held: bool = False,
        wind_up: WindUp | None = None,
    ) -> None:
        self.installed = installed
        self._name = name
        self._slack_held = slack_held
        self._wind_up = wind_up
        self.retune(settings, limits or SensorLimits())
        self._clear()

    def retune(self, settings: AlarmSettings, limits: SensorLimits) -> None:
        """Go on with other thresholds, delays and limits."""
        self._settings = s = settings
        self._gap = limits.greatest_gap
        if self._wind_up is not None:
            self._wind_up.slowest = limits.standstill_speed
        self._limits = limits
        self._slow = Delays(s.on_delay, s.off_delay)
        self._tripping = Delays(s.trip_on_delay, s.trip_off_delay)
        self._losing = Delays(s.traction_on_delay, s.traction_off_delay)
        self._staling = Delays(0.0, s.stale_off_delay)  # the greatest gap is its on-delay
        self._doubting = Delays(s.implausible_on_delay, s.implausible_off_delay)
        self._straying = Delays(s.lost_on_delay, s.lost_off_delay)

    def _clear(self) -> None:
        alarm, warning = Severity.ALARM, Severity.WARNING
        self._stale = ConditionAlarm(Condition.SENSOR_STALE, (alarm, warning))
        self._implausible = ConditionAlarm(Condition.SENSOR_IMPLAUSIBLE, (alarm,))
        self._lost = ConditionAlarm(Condition.ESTIMATOR_LOST, (alarm,))
        self._gross_slip = ConditionAlarm(Condition.GROSS_SLIP, (Severity.TRIP, alarm))
        self._excess_slip = ConditionAlarm(Condition.EXCESS_SLIP, (alarm, warning))
        self._low_margin = ConditionAlarm(Condition.LOW_MARGIN, (alarm, warning))
        self._traction = ConditionAlarm(Condition.TRACTION_LOST, (warning,))
        # Of equal severity, what the others rest on comes first.
        self._all = (
            self._stale,
            self._implausible,
            self._lost,
            self._gross_slip,
            self._excess_slip,
            self._low_margin,
            self._traction,
        )
        self._now_ns = 0
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget what is raised, as where time begins anew; latches and counts stay."""
        self.watch = SensorWatch()
        self._channels = Channels()
        self._suspicion = Suspicion()
        for each in self._all:
            each.begin_anew()
        self._estimate: BeltEstimate | None = None
        self._moving = 0.0  # [s] since motion began
        self._silence = 0.0
        self._naming = (Condition.TRACTION_LOST, 0)  # a name that is on its way, since when [ns]
        self._changed = True  # since it was last told
        self._paused = False

    def reset(self) -> None:
        """Forget everything, latches included."""
        self._clear()

    def update(
        self,
        estimate: BeltEstimate,
        measurement: Measurement | None = None,
        capacity: Capacity | None = None,
        *,
        recovers: bool = False,
    ) -> AlarmStatus | None:
        """Judge an estimate; return the status if anything changed, and the first time.

        Parameters
        ----------
        estimate : BeltEstimate
        measurement : Measurement, optional
            The one that led to it; which quantities are there is judged by it.
        capacity : Capacity, optional
            Distribution of the torque at gross slip. Without it the margin is taken as normal.
        recovers : bool
            Whether an estimator that is lost seems to find its way again; from then on the
            off-delay of that alarm counts.
        """
        dt = self._elapsed(estimate.stamp_ns)
        self._estimate = estimate
        gap = self._gap
        beyond = estimate.excess_slip if self._wind_up is None else self._wind_up.slip(estimate)
        pooled = 1 if measurement is None else measurement.pooled
        self.watch.accept(estimate, beyond, self._settings, pooled)
        if measurement is not None:
            self._channels.take(measurement, gap)
        resting = estimate.phase in RESTING
        self._moving = 0.0 if resting else self._moving + min(max(dt, 0.0), gap)
        self._judge_sensors(estimate.stamp_ns, silent=dt > gap, silence=dt)
        self._judge_estimator(estimate, recovers=recovers)
        self._judge_belt(estimate, beyond, capacity, dt, resting=resting)
        return self._news()

    def turned_away(
        self, reason: Rejection, measurement: Measurement | None = None
    ) -> AlarmStatus | None:
        """Take in that a measurement was not used; return the status if anything changed."""
        stamp_ns = self.watch.refuse(reason, measurement, self._limits, self._settings)
        if stamp_ns is None or self._estimate is None:
            return None
        self._now_ns = max(self._now_ns, stamp_ns)
        self._judge_plausibility(stamp_ns)
        return self._news()

    @property
    def longest_silence(self) -> float:
        """Time [s] without a usable measurement beyond which sensors count as silent.

        Before the first estimate it is ten seconds at least.
        """
        return max(self._gap, _UNHEARD) if self._estimate is None else self._gap

    def silent(self, stamp_ns: int, silence: float) -> AlarmStatus | None:
        """Take in that nothing usable has come; return the status if anything changed.

        Parameters
        ----------
        stamp_ns : int
            Now [ns], on the clock of the measurements.
        silence : float
            Time since the last measurement that was used [s].
        """
        if not silence > self.longest_silence:
            return None
        # Stamps before an estimate are all there is to go by: time may have begun anew.
        self._now_ns = stamp_ns if self._estimate is None else max(self._now_ns, stamp_ns)
        self._judge_sensors(self._now_ns, silent=True, silence=silence)
        return self._news()

    def pause(self) -> None:
        """Hear that nobody listens to the sensors for a while: they are not silent meanwhile."""
        self._paused = True

    @property
    def told(self) -> bool:
        """Whether anything is raised or latched."""
        return any(each.told for each in self._all)

    def acknowledge(
        self, estimate: BeltEstimate | None, condition: Condition | None = None
    ) -> AlarmStatus:
        """Release the latch of a condition, or of all; what still holds stays raised."""
        self._estimate = self._estimate or estimate
        for each in self._all:
            if condition is None or each.condition is condition:
                each.acknowledge()
        self._changed = self._estimate is None  # the first estimate is told in any case
        return self._status()

    def _elapsed(self, stamp_ns: int) -> float:
        """Time since the estimate before [s]."""
        told = None if self._paused else self._estimate
        before = None if told is None else told.stamp_ns
        self._paused = False
        self._now_ns = stamp_ns
        return 0.0 if before is None else (stamp_ns - before) * _SECONDS

    def _judge_sensors(self, stamp_ns: int, *, silent: bool, silence: float) -> None:
        """Judge whether sensors are silent or missing, and whether they can be believed."""
        if silent:
            self._silence = silence
        absent = bool(self._channels.absent(self._gap))
        evidence = _either(met=silent), _either(met=silent or absent)
        self._changed |= self._stale.update(stamp_ns, evidence, self._staling, longest=self._gap)
        if not silent:
            self._judge_plausibility(stamp_ns)

    def _judge_plausibility(self, stamp_ns: int) -> None:
        evidence = (self.watch.evidence(self._settings),)
        self._changed |= self._implausible.update(
            stamp_ns, evidence, self._doubting, longest=self._gap
        )

    def _judge_estimator(self, estimate: BeltEstimate, *, recovers: bool) -> None:
        found = recovers and self._lost.active
        evidence = (_either(met=estimate.phase is Phase.LOST and not found),)
        self._changed |= self._lost.update(
            estimate.stamp_ns, evidence, self._straying, longest=self._gap
        )

    def _judge_belt(
        self,
        estimate: BeltEstimate,
        beyond: Quantity,
        capacity: Capacity | None,
        dt: float,
        *,
        resting: bool,
    ) -> None:
        """Judge margin, slip and traction. None of them rises while the data are in doubt."""
        s, now, gap = self._settings, estimate.stamp_ns, self._gap
        strays = estimate.phase is Phase.LOST
        plausible = not (self._held_back(dt, strays=strays) or self._implausible.active)
        believed = plausible and not (self._lost.active or strays)
        begun = resting or self._moving >= s.start_bypass
        rises = believed and begun
        margins = margin_evidence(estimate, capacity, s)
        trip, *excess = slip_evidence(estimate, beyond, s)
        sliding = gross_slip_evidence(estimate, s)
        self._changed |= self._low_margin.update(
            now, margins, self._slow, longest=gap, may_rise=rises
        )
        self._changed |= self._excess_slip.update(
            now, excess, self._slow, longest=gap, may_rise=rises
        )
        self._changed |= self._gross_slip.update(
            now, (trip, sliding), self._tripping, longest=gap, may_rise=plausible and begun
        )
        self._judge_traction(estimate, may_rise=believed)

    def _held_back(self, dt: float, *, strays: bool) -> bool:
        """Whether the belt's alarms wait for what may turn out to be a sensor's fault.

        Bad messages count for longer where what the others say does not fit either (`strays`).
        """
        s, watch = self._settings, self.watch
        if not 0.0 < dt <= self._gap:
            self._suspicion = Suspicion()
        suspected = watch.evidence(s) is not Evidence.GONE
        waits = self._suspicion.holds_back(
            min(max(dt, 0.0), self._gap),
            s.implausible_on_delay + _SUSPICION,
            s.implausible_off_delay,
            suspected=suspected,
        )
        return waits or (suspected and strays) or watch.misfit_evidence(s) is not Evidence.GONE

    def _judge_traction(self, estimate: BeltEstimate, *, may_rise: bool) -> None:
        s, lost = self._settings, estimate.lost_traction
        evidence = traction_evidence(lost, s)
        self._changed |= self._traction.update(
            estimate.stamp_ns, (evidence,), self._losing, longest=self._gap, may_rise=may_rise
        )
        if evidence is Evidence.MET:
            self._name_loss(Condition(named_loss(lost, s.traction_confidence)), estimate.stamp_ns)
        elif not self._traction.told:
            self._traction.condition = Condition.TRACTION_LOST
            self._naming = Condition.TRACTION_LOST, estimate.stamp_ns

    def _name_loss(self, name: Condition, now_ns: int) -> None:
        """Name the loss once its cause is clear for as long as an alarm takes to be raised."""
        if name is not self._naming[0]:
            self._naming = name, now_ns
        clear = name in (Condition.TENSION_LOST, Condition.FRICTION_LOST)
        held = (now_ns - self._naming[1]) * _SECONDS
        if self._traction.active and clear and held >= self._settings.traction_on_delay:
            self._changed |= self._traction.condition is not name
            self._traction.condition = name

    def _news(self) -> AlarmStatus | None:
        if not self._changed:
            return None
        self._changed = False
        return self._status()

    def _status(self) -> AlarmStatus:
        """Return what is to be told now."""
        estimate = self._estimate
        told = [each for each in self._all if each.told]
        told.sort(key=lambda each: (-each.severity, -each.latched))  # stable: ties as in _all
        worst = told[0] if told else max(self._all, key=lambda each: each.last_ns)
        conditions = tuple(each.status(self._message(each)) for each in told)
        return AlarmStatus(
            stamp_ns=self._now_ns,
            condition=worst.condition if told else Condition.NONE,
            severity=worst.severity,
            latched_severity=max((each.latched for each in told), default=Severity.NORMAL),
            acknowledged=all(each.acknowledged for each in told),
            margin=_ANY_MARGIN if estimate is None else estimate.margin,
            excess_slip=0.0 if estimate is None else estimate.excess_slip.value,
            gross_slip_probability=0.0 if estimate is None else estimate.gross_slip_probability,
            count=worst.count,
            first_ns=worst.first_ns,
            last_ns=worst.last_ns,
            message=conditions[0].message if told else self._nothing(),
            conditions=conditions,
        )

    def _tension(self, estimate: BeltEstimate) -> Tension:
        held = estimate.slack_tension if self._slack_held else estimate.mean_tension
        return Tension(held, self.installed)

    def _nothing(self) -> str:
        estimate = self._estimate
        if estimate is None:
            return unheard(self._name, "no alarm condition")
        return sentence(self._name, Condition.NONE, estimate, self._tension(estimate))

    def _message(self, alarm: ConditionAlarm) -> str:
        estimate = self._estimate
        if not alarm.active:
            return over(self._name, alarm.condition)
        if estimate is None:
            return unheard(self._name, self._what_is_missing())
        if not alarm.holds:
            return recovering(self._name, alarm.condition, estimate)
        detail = ""
        if alarm is self._stale:
            detail = self._what_is_missing()
        elif alarm is self._implausible:
            detail = self.watch.reason(self._settings)
        return sentence(self._name, alarm.condition, estimate, self._tension(estimate), detail)

    def _what_is_missing(self) -> str:
        if self._stale.severity is Severity.ALARM:
            return f"no usable measurement for {self._silence:.1f} s: check sensors and network"
        missing = " and ".join(
            sensor.name.lower().replace("_", " ") for sensor in self._channels.absent(self._gap)
        )
        return f"{missing} no longer measured: check the sensor and its wiring"


def _either(*, met: bool) -> Evidence:
    return Evidence.MET if met else Evidence.GONE
