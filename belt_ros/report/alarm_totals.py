"""How often each alarm was raised, and for how long."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from belt_ros.estimation import Severity
from belt_ros.estimation.alarm_settings import Condition
from belt_ros.report.alarm_history import AlarmHistory
from belt_ros.report.labels import condition_name, severity_name
from belt_ros.report.result_directory import SummaryValues


class AlarmTotal(NamedTuple):
    """What one condition amounts to."""

    condition: str
    severity: str  # the worst
    times: int
    seconds: float  # in all
    longest: float  # [s]
    first: float | None  # in the run [s], where the result bag tells


class _Event(NamedTuple):
    """One occurrence."""

    start: float  # [s], of any time line
    condition: str
    severity: str
    seconds: float


def alarm_totals(summary: SummaryValues, history: AlarmHistory) -> tuple[AlarmTotal, ...]:
    """Return what each condition that was raised amounts to, in the order of their first time.

    The summary tells of all alarms, and takes one whose cause became clear later for one; results
    of versions in which it did not are added up from their bag.

    Raises
    ------
    ReportError
        If the summary is damaged.
    """
    told = "alarms" in summary.raw()
    events = sorted(_told(summary) if told else _seen(history), key=lambda event: event.start)
    first = {condition_name(number): history.spans(number)[0][0] for number in history.conditions}
    names = dict.fromkeys(event.condition for event in events)
    return tuple(
        _total([event for event in events if event.condition == name], first.get(name))
        for name in names
    )


def _told(summary: SummaryValues) -> Iterator[_Event]:
    for event in summary.groups("alarms"):
        name, severity = event.text("condition"), event.text("severity")
        known = Condition.__members__.get(name.upper())
        shown = name.replace("_", " ") if known is None else condition_name(known)
        start, seconds = event.number("raised_ns") * 1e-9, event.number("duration")
        yield _Event(start, shown, severity.replace("_", " "), seconds)


def _seen(history: AlarmHistory) -> Iterator[_Event]:
    for number in history.conditions:
        for start, end, worst in history.spans(number):
            yield _Event(start, condition_name(number), severity_name(worst), end - start)


def _total(events: list[_Event], first: float | None) -> AlarmTotal:
    lengths = [event.seconds for event in events]
    worst = _worst(event.severity for event in events)
    return AlarmTotal(events[0].condition, worst, len(events), sum(lengths), max(lengths), first)


def _worst(severities: Iterable[str]) -> str:
    """Return the worst; what is newer than this program may be worse than all it knows."""
    known = [severity.name.lower() for severity in Severity]
    return max(severities, key=lambda name: known.index(name) if name in known else len(known))
