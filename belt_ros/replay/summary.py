"""What a replay amounts to, counted on the way through it."""

import dataclasses
import importlib.metadata
import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, IntEnum
from functools import cache
from typing import Any, TypeVar

import belt_ros
from belt_ros.estimation import (
    AlarmStatus,
    BeltEstimate,
    Knowledge,
    MonitorOutput,
    Phase,
    Quantity,
    Rejection,
    Severity,
)
from belt_ros.message_fields import state_fields
from belt_ros.replay.alarm_events import AlarmEvent, AlarmLog, time_in_alarms
from belt_ros.replay.quantities import Extreme, FinalQuantity, with_interval
from belt_ros.replay.smoothed_summary import SmoothedSummary
from belt_ros.replay.tables import state_units
from belt_ros.settings import DriveSettings

_Kind = TypeVar("_Kind", bound=IntEnum)
_SECONDS = 1e-9
_WELL_MOVING = 10.0  # times the standstill speed; a start from rest has any slip up to 100 %
_COMPUTED_WITH = ("numpy", "scipy", "numba", "filterpy", "rosbags")

__all__ = ["Extreme", "FinalQuantity", "Summary", "Tally", "final_quantities"]


@dataclass(frozen=True)
class Summary:
    """What a replay amounts to. Times in s, stamps in ns, slips as fractions."""

    drive: str
    bag: str
    topic: str
    note: str  # what of the bag is lost
    messages: int
    accepted: int
    rejected: dict[str, int]
    resets: int
    start_ns: int
    end_ns: int
    duration: float
    unobserved: float  # within the duration, in gaps too long to be bridged
    worst_margin: Extreme | None
    greatest_slip: Extreme | None  # while well moving, as is the next
    greatest_excess_slip: Extreme | None
    time_in_phase: dict[str, float]
    time_in_severity: dict[str, float]
    alarms_raised: int  # each of them, also while others are
    worst_severity: str
    alarms: tuple[AlarmEvent, ...]
    time_in_alarm: dict[str, float]
    final: dict[str, FinalQuantity]
    smoothed: SmoothedSummary | None
    knowledge: dict[str, str]
    versions: dict[str, str]
    config: dict[str, Any]

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON values; what is not known (NaN) or unbounded becomes null."""
        plain: dict[str, Any] = _jsonable(dataclasses.asdict(self))
        return plain


def _jsonable(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _jsonable(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_jsonable(item) for item in value]
    if isinstance(value, Enum):
        return _jsonable(value.value)
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def final_quantities(estimate: BeltEstimate) -> dict[str, FinalQuantity]:
    """Return every quantity of an estimate that has a standard deviation."""
    units = state_units()
    names = state_fields("", estimate)
    found = {}
    for name in names:
        if f"{name}_stddev" in names:
            quantity: Quantity = getattr(estimate, name)
            found[name] = with_interval(name, quantity, units.get(name, ""))
    return found


class Tally:
    """Counts, times and extremes of a replay while it runs.

    Parameters
    ----------
    settings : DriveSettings
        Its limits say which gaps count as observed, and at which speed slip has a meaning.
    """

    def __init__(self, settings: DriveSettings) -> None:
        self._settings = settings
        self.rejected = dict.fromkeys(
            (reason for reason in Rejection if reason is not Rejection.NONE), 0
        )
        self.messages = 0
        self.accepted = 0
        self._first_ns: int | None = None
        self._last: BeltEstimate | None = None
        self._end_ns = 0  # of the bag, if it is far from the last measurement's
        self._elapsed_ns = 0
        self._unobserved_ns = 0
        self._severity = Severity.NORMAL
        self._worst_severity = Severity.NORMAL
        self._alarms = AlarmLog()
        self._phase_ns = dict.fromkeys(Phase, 0)
        self._severity_ns = dict.fromkeys(Severity, 0)
        self._extremes: dict[str, Extreme] = {}

    def add(self, output: MonitorOutput, alarm: AlarmStatus | None) -> None:
        """Take in what the monitor made of one message; `alarm`: its status where that is news."""
        self.messages += 1
        if output.rejection is not Rejection.NONE:
            self.rejected[output.rejection] += 1
            self._note_alarm(alarm)
            return
        self.accepted += 1
        if not output.fresh:
            return
        assert output.estimate is not None
        self._spend_time(output.estimate)
        self._note_alarm(alarm)
        self._note_extremes(output.estimate)
        self._last = output.estimate

    def add_alarm(self, alarm: AlarmStatus) -> None:
        """Take in the alarms' status where no message has changed it."""
        self._note_alarm(alarm)

    def outlast(self, stamp_ns: int) -> None:
        """Hear that the bag ends at a time [ns] long after the last measurement."""
        self._end_ns = stamp_ns

    def _spend_time(self, estimate: BeltEstimate) -> None:
        """Time since the last measurement counts for the state in which it left the drive."""
        if self._first_ns is None:
            self._first_ns = estimate.stamp_ns
        if self._last is None:
            return
        step_ns = estimate.stamp_ns - self._last.stamp_ns
        if step_ns <= 0:  # the time line begins anew
            return
        self._elapsed_ns += step_ns
        if step_ns * _SECONDS > self._settings.limits.greatest_gap:
            self._unobserved_ns += step_ns
            return
        self._phase_ns[self._last.phase] += step_ns
        self._severity_ns[self._severity] += step_ns

    def _note_alarm(self, alarm: AlarmStatus | None) -> None:
        if alarm is None:
            return
        self._alarms.add(alarm)
        self._severity = alarm.severity
        self._worst_severity = max(self._worst_severity, alarm.severity)

    def _note_extremes(self, estimate: BeltEstimate) -> None:
        self._note("margin", -estimate.margin.value, estimate.margin, estimate)
        rim_speed = abs(estimate.driver_speed.value) * self._settings.drive.driver.radius
        if rim_speed > _WELL_MOVING * self._settings.limits.standstill_speed:
            self._note("slip", abs(estimate.slip.value), estimate.slip, estimate)
            excess = estimate.excess_slip
            self._note("excess_slip", abs(excess.value), excess, estimate)

    def _note(self, name: str, rank: float, quantity: Quantity, estimate: BeltEstimate) -> None:
        best = self._extremes.get(name)
        before = (
            -math.inf if best is None else (-best.value if name == "margin" else abs(best.value))
        )
        if rank > before:  # false for NaN
            self._extremes[name] = Extreme(
                quantity.value, quantity.stddev, estimate.stamp_ns, self._elapsed_ns * _SECONDS
            )

    def summary(
        self, bag: str, topic: str, note: str, smoothed: SmoothedSummary | None = None
    ) -> Summary:
        """Return the summary. At least one measurement has been accepted by now."""
        last, first_ns = self._last, self._first_ns
        assert last is not None
        assert first_ns is not None
        alarms = self._alarms.events(max(last.stamp_ns, self._end_ns))
        return Summary(
            drive=self._settings.name,
            bag=bag,
            topic=topic,
            note=note,
            messages=self.messages,
            accepted=self.accepted,
            rejected={reason.name.lower(): count for reason, count in self.rejected.items()},
            resets=last.health.resets,
            start_ns=first_ns,
            end_ns=last.stamp_ns,
            duration=self._elapsed_ns * _SECONDS,
            unobserved=self._unobserved_ns * _SECONDS,
            worst_margin=self._extremes.get("margin"),
            greatest_slip=self._extremes.get("slip"),
            greatest_excess_slip=self._extremes.get("excess_slip"),
            time_in_phase=_seconds(self._phase_ns),
            time_in_severity=_seconds(self._severity_ns),
            alarms_raised=len(alarms),
            worst_severity=self._worst_severity.name.lower(),
            alarms=alarms,
            time_in_alarm=time_in_alarms(alarms),
            final=final_quantities(last),
            smoothed=smoothed,
            knowledge=_knowledge(last),
            versions=_versions(),
            config=_jsonable(dataclasses.asdict(self._settings)),
        )


def _seconds(times_ns: Mapping[_Kind, int]) -> dict[str, float]:
    return {kind.name.lower(): time_ns * _SECONDS for kind, time_ns in times_ns.items()}


def _knowledge(estimate: BeltEstimate) -> dict[str, str]:
    kinds: dict[str, Knowledge] = {
        "tension": estimate.tension_knowledge,
        "friction_stiffness": estimate.friction_stiffness_knowledge,
        "friction_coefficient": estimate.friction_coefficient_knowledge,
    }
    return {name: kind.name.lower() for name, kind in kinds.items()}


@cache
def _versions() -> dict[str, str]:
    found = {"belt_ros": belt_ros.__version__}
    return found | {name: importlib.metadata.version(name) for name in _COMPUTED_WITH}
