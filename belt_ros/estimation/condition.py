"""One alarm: delays, deadband, latch, acknowledgement and counts.

In the terms of ISA-18.2 and OPC UA Part 9: a condition is *active* while it is raised, *latched*
until it has been acknowledged, and both are told apart.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from belt_ros.estimation.alarm_settings import Condition, Severity
from belt_ros.estimation.estimate import Quantity

_SECONDS = 1e-9
_ROUNDING = 1e-9  # [s]


class Evidence(Enum):
    """What the present says of a condition at one severity."""

    GONE = 0
    UNDECIDED = 1  # within the deadband
    MET = 2


def judged(value: float, met_from: float, gone_below: float) -> Evidence:
    """Return whether a condition is met at a value; one that is no number says nothing."""
    if value >= met_from:
        return Evidence.MET
    return Evidence.GONE if value < gone_below else Evidence.UNDECIDED


@dataclass(frozen=True, slots=True)
class Delays:
    """How long a condition must hold to be raised, and be gone to be cleared [s]."""

    on: float
    off: float


@dataclass(frozen=True, slots=True)
class ConditionStatus:
    """One condition that is raised, or was and has not been acknowledged."""

    condition: Condition
    severity: Severity
    latched_severity: Severity  # the worst since the last acknowledgement
    active: bool
    acknowledged: bool
    count: int  # times raised
    first_ns: int  # of the present occurrence
    last_ns: int
    message: str


@dataclass(frozen=True, slots=True)
class AlarmStatus:
    """Present state of the alarms.

    Condition, severity, count, times and message are those of the worst condition; latched severity
    is the worst of all that wait for acknowledgement. Where nothing is raised or latched the
    condition is NONE, with count and times of the last one that was.
    """

    stamp_ns: int
    condition: Condition
    severity: Severity
    latched_severity: Severity
    acknowledged: bool  # all of them
    margin: Quantity
    excess_slip: float
    gross_slip_probability: float
    count: int
    first_ns: int
    last_ns: int
    message: str
    conditions: tuple[ConditionStatus, ...] = ()  # raised or latched, the worst first

    @property
    def active(self) -> bool:
        """Whether a condition holds now."""
        return self.severity > Severity.NORMAL


class _Switch:
    """On- and off-delay of one severity."""

    __slots__ = ("_held", "raised", "waiting")

    def __init__(self) -> None:
        self.raised = False
        self.waiting = False
        self._held = 0.0

    def update(self, evidence: Evidence, dt: float, delays: Delays, *, may_rise: bool) -> bool:
        """Take in the evidence `dt` [s] after the one before; return whether it is raised."""
        if self.raised:
            changing, delay = evidence is Evidence.GONE, delays.off
        else:
            changing, delay = may_rise and evidence is Evidence.MET, delays.on
        self._held = self._held + dt if self.waiting else 0.0
        self.waiting = changing
        if changing and self._held >= delay - _ROUNDING:
            self.raised = not self.raised
            self.waiting = False
        return self.raised


class ConditionAlarm:
    """One condition, at one or more severities.

    Time between updates counts for the delays only if it is no gap: what was not observed has
    neither held nor been gone.

    Parameters
    ----------
    condition : Condition
    severities : sequence of Severity
        The worst first.
    """

    def __init__(self, condition: Condition, severities: Sequence[Severity]) -> None:
        self.condition = condition
        self.severity = Severity.NORMAL
        self.latched = Severity.NORMAL
        self.holds = False
        self.count = 0
        self.first_ns = 0
        self.last_ns = 0
        self._acknowledged = True
        self._severities = tuple(severities)
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget what is raised, or on its way to be; what waits for acknowledgement still does."""
        self.severity = Severity.NORMAL
        self.holds = False
        if self._acknowledged:
            self.latched = Severity.NORMAL
        self._switches = tuple((severity, _Switch()) for severity in self._severities)
        self._stamp_ns: int | None = None
        self._idle = True  # neither raised, nor on its way to be

    @property
    def active(self) -> bool:
        """Whether it is raised."""
        return self.severity is not Severity.NORMAL

    @property
    def acknowledged(self) -> bool:
        """Whether all that it rose to has been acknowledged."""
        return self._acknowledged or self.latched is Severity.NORMAL

    @property
    def told(self) -> bool:
        """Whether there is anything to tell of it: it is raised or latched."""
        return self.latched is not Severity.NORMAL

    def update(
        self,
        stamp_ns: int,
        evidence: Sequence[Evidence],
        delays: Delays,
        *,
        longest: float,
        may_rise: bool = True,
    ) -> bool:
        """Take in what the present says; return whether severity or latch have changed.

        Parameters
        ----------
        stamp_ns : int
            Time [ns].
        evidence : sequence of Evidence
            For each severity, the worst first.
        delays : Delays
        longest : float
            Time between updates [s] beyond which it is a gap.
        may_rise : bool
            Whether it may rise now. What has risen stays until it is gone.
        """
        if self._idle and not (may_rise and Evidence.MET in evidence):
            self._elapsed(stamp_ns, longest)
            return False
        dt = self._elapsed(stamp_ns, longest)
        worst = Severity.NORMAL
        waiting = False
        for (severity, switch), each in zip(self._switches, evidence, strict=True):
            if switch.update(each, dt, delays, may_rise=may_rise) and severity > worst:
                worst = severity
            waiting |= switch.waiting
        self._idle = worst is Severity.NORMAL and not waiting
        if worst is Severity.NORMAL and self.severity is Severity.NORMAL:
            return False
        self.holds = any(each is not Evidence.GONE for each in evidence)
        before = self.severity, self.latched
        self._become(worst, stamp_ns)
        return (self.severity, self.latched) != before

    def _elapsed(self, stamp_ns: int, longest: float) -> float:
        before = self._stamp_ns
        dt = 0.0 if before is None else (stamp_ns - before) * _SECONDS
        if not -longest <= dt < 0.0:  # what was pooled is earlier than what was refused meanwhile
            self._stamp_ns = stamp_ns
        return dt if 0.0 < dt <= longest else 0.0

    def _become(self, severity: Severity, stamp_ns: int) -> None:
        if severity is not Severity.NORMAL:
            if not self.active:
                self.count += 1
                self.first_ns = stamp_ns
            self.last_ns = stamp_ns
        if severity > self.severity:  # a rise wants to be acknowledged, also after another one
            self._acknowledged = False
        self.severity = severity
        self.latched = max(self.latched, severity)
        if severity is Severity.NORMAL and self._acknowledged:
            self.latched = Severity.NORMAL

    def acknowledge(self) -> None:
        """Release the latch; what is still raised stays raised."""
        self._acknowledged = True
        self.latched = self.severity

    def status(self, message: str) -> ConditionStatus:
        """Return its present status with a sentence about it."""
        return ConditionStatus(
            self.condition,
            self.severity,
            self.latched,
            self.active,
            self.acknowledged,
            self.count,
            self.first_ns,
            self.last_ns,
            message,
        )
