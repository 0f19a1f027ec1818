"""Slip-margin alarm: thresholds with deadband, on- and off-delay, latch and acknowledgement.

Conditions are judged by probability, not by the estimate alone: a margin that the data cannot tell
raises nothing. Time is that of the estimates. The alarm advises; it is no safety function.
"""

from dataclasses import dataclass
from enum import IntEnum

from belt_ros.estimation.assumptions import setting
from belt_ros.estimation.estimate import BeltEstimate, Phase, Quantity, probability_below

_SECONDS = 1e-9


class Condition(IntEnum):
    """What an alarm is about; the numbers are those of belt_msgs/SlipAlarm."""

    NONE = 0
    LOW_MARGIN = 1
    EXCESS_SLIP = 2
    GROSS_SLIP = 3


class Severity(IntEnum):
    """How bad a condition is; the numbers are those of belt_msgs/SlipAlarm."""

    NORMAL = 0
    WARNING = 1
    ALARM = 2
    TRIP = 3


@dataclass(frozen=True)
class AlarmSettings:
    """Thresholds and delays of the alarm."""

    margin_warning: float = setting(0.25, "warn below this margin", "-", 0.0, 1.0)
    margin_alarm: float = setting(0.10, "alarm below this margin", "-", 0.0, 1.0)
    excess_slip_warning: float = setting(
        0.01, "warn above this slip beyond predicted creep", "-", 0.0, 1.0
    )
    excess_slip_alarm: float = setting(
        0.03, "alarm above this slip beyond predicted creep", "-", 0.0, 1.0
    )
    excess_slip_trip: float = setting(
        0.20, "trip above this slip beyond predicted creep", "-", 0.0, 1.0
    )
    confidence: float = setting(
        0.8, "probability at which a condition counts as met", "-", 0.5, 0.9999
    )
    clear_confidence: float = setting(
        0.4, "probability below which a raised condition counts as gone (deadband)", "-", 0.0, 0.5
    )
    on_delay: float = setting(0.2, "a condition must hold this long to be raised", "s", 0.0, 60.0)
    off_delay: float = setting(1.0, "and be gone this long to be cleared", "s", 0.0, 600.0)


@dataclass(frozen=True, slots=True)
class AlarmStatus:
    """Present state of the alarm."""

    stamp_ns: int
    condition: Condition
    severity: Severity
    latched_severity: Severity
    acknowledged: bool
    margin: Quantity
    excess_slip: float
    gross_slip_probability: float
    count: int
    first_ns: int
    last_ns: int
    message: str

    @property
    def active(self) -> bool:
        """Whether a condition holds now."""
        return self.severity > Severity.NORMAL


class _Timer:
    """One condition at one severity: on- and off-delay, and the deadband between them."""

    def __init__(self) -> None:
        self.raised = False
        self._since_ns: int | None = None

    def update(self, probability: float, stamp_ns: int, settings: AlarmSettings) -> bool:
        changing = (
            probability < settings.clear_confidence
            if self.raised
            else probability >= settings.confidence
        )
        if not changing:
            self._since_ns = None
            return self.raised
        if self._since_ns is None or stamp_ns < self._since_ns:
            self._since_ns = stamp_ns
        delay = settings.off_delay if self.raised else settings.on_delay
        if (stamp_ns - self._since_ns) * _SECONDS >= delay:
            self.raised = not self.raised
            self._since_ns = None
        return self.raised


class SlipAlarm:
    """The alarm of one drive. `update` returns its status when that has changed, else None."""

    def __init__(self, name: str, settings: AlarmSettings) -> None:
        self.settings = settings
        self._name = name
        self._clear()

    def _clear(self) -> None:
        self._timers = {
            (condition, severity): _Timer()
            for condition, severity in (
                (Condition.GROSS_SLIP, Severity.TRIP),
                (Condition.EXCESS_SLIP, Severity.ALARM),
                (Condition.LOW_MARGIN, Severity.ALARM),
                (Condition.EXCESS_SLIP, Severity.WARNING),
                (Condition.LOW_MARGIN, Severity.WARNING),
            )
        }
        self._condition = Condition.NONE
        self._severity = Severity.NORMAL
        self._latched = Severity.NORMAL
        self._acknowledged = True
        self._announced = False
        self._count = 0
        self._first_ns = 0
        self._last_ns = 0

    def reset(self) -> None:
        """Forget everything, latch included."""
        self._clear()

    def acknowledge(self, estimate: BeltEstimate) -> AlarmStatus:
        """Release the latch; a condition that still holds stays raised."""
        self._acknowledged = True
        self._latched = self._severity
        return self._status(estimate)

    def update(self, estimate: BeltEstimate) -> AlarmStatus | None:
        """Judge `estimate`; return the status if anything changed, and the first time."""
        before = (self._condition, self._severity, self._latched) if self._announced else None
        was = self._severity
        self._judge(estimate)
        if self._severity > Severity.NORMAL:
            if was is Severity.NORMAL:
                self._count += 1
                self._first_ns = estimate.stamp_ns
            self._last_ns = estimate.stamp_ns
        if self._severity > self._latched:
            self._latched = self._severity
            self._acknowledged = False
        if (self._condition, self._severity, self._latched) == before:
            return None
        self._announced = True
        return self._status(estimate)

    def _judge(self, estimate: BeltEstimate) -> None:
        """Set condition and severity to the worst that is raised, in the timers' order."""
        self._condition, self._severity = Condition.NONE, Severity.NORMAL
        for (condition, severity), timer in self._timers.items():
            probability = self._probability(condition, severity, estimate)
            raised = timer.update(probability, estimate.stamp_ns, self.settings)
            if raised and severity > self._severity:
                self._condition, self._severity = condition, severity

    def _probability(
        self, condition: Condition, severity: Severity, estimate: BeltEstimate
    ) -> float:
        settings = self.settings
        moving = estimate.phase not in (Phase.STANDSTILL, Phase.UNKNOWN)
        if condition is Condition.LOW_MARGIN:
            alarm = severity is Severity.ALARM
            limit = settings.margin_alarm if alarm else settings.margin_warning
            return probability_below(estimate.margin, limit)
        if not moving:
            return 0.0
        limit = {
            Severity.WARNING: settings.excess_slip_warning,
            Severity.ALARM: settings.excess_slip_alarm,
            Severity.TRIP: settings.excess_slip_trip,
        }[severity]
        excess = Quantity(abs(estimate.excess_slip.value), estimate.excess_slip.stddev)
        return 1.0 - probability_below(excess, limit)

    def _holds(self, estimate: BeltEstimate) -> bool:
        """Whether the raised condition is still there, rather than waiting for its off-delay."""
        probability = self._probability(self._condition, self._severity, estimate)
        return probability >= self.settings.clear_confidence

    def _status(self, estimate: BeltEstimate) -> AlarmStatus:
        return AlarmStatus(
            stamp_ns=estimate.stamp_ns,
            condition=self._condition,
            severity=self._severity,
            latched_severity=self._latched,
            acknowledged=self._acknowledged,
            margin=estimate.margin,
            excess_slip=estimate.excess_slip.value,
            gross_slip_probability=estimate.gross_slip_probability,
            count=self._count,
            first_ns=self._first_ns,
            last_ns=self._last_ns,
            message=self._message(estimate),
        )

    def _message(self, estimate: BeltEstimate) -> str:
        tension = estimate.mean_tension
        known = f"mean tension {tension.value:.0f} +/- {tension.stddev:.0f} N"
        if self._condition is not Condition.NONE and not self._holds(estimate):
            return (
                f"{self._name}: recovering, {estimate.margin.value:.0%} margin and "
                f"{estimate.slip.value:.2%} slip now; the alarm clears if it lasts ({known})."
            )
        if self._condition is Condition.GROSS_SLIP:
            return (
                f"{self._name}: gross slip, {estimate.slip.value:.0%} of the driver's travel is "
                f"lost. Stop or unload the drive, then check tension and contamination ({known})."
            )
        if self._condition is Condition.EXCESS_SLIP:
            return (
                f"{self._name}: {estimate.excess_slip.value:.1%} slip beyond the expected creep. "
                f"Reduce load; check tension and pulley surfaces ({known})."
            )
        if self._condition is Condition.LOW_MARGIN:
            return (
                f"{self._name}: {estimate.margin.value:.0%} margin left. "
                f"Reduce load or re-tension ({known})."
            )
        return f"{self._name}: no alarm condition ({known})."
