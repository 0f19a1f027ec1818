"""Alarms as events: what was raised, how bad it became, when it was over."""

from collections.abc import Iterator
from dataclasses import dataclass

from belt_ros.estimation import AlarmStatus, ConditionStatus, Severity
from belt_ros.estimation.alarm_settings import Condition

_SECONDS = 1e-9
_ONE_ALARM = (Condition.TRACTION_LOST, Condition.TENSION_LOST, Condition.FRICTION_LOST)


@dataclass(frozen=True)
class AlarmEvent:
    """One occurrence of an alarm. Stamps in ns, times in s.

    Attributes
    ----------
    condition : str
        What it was about; the last name it had, where a cause became clear later.
    severity : str
        The worst.
    raised_ns, cleared_ns : int
        `cleared_ns` is None if it had not ended when the bag did, or time jumped back.
    duration : float
        Until it was over, else until the last that was seen of it.
    acknowledged : bool
    count : int
        How often this condition had been raised by then.
    message : str
        What was said when it was worst.
    """

    condition: str
    severity: str
    raised_ns: int
    cleared_ns: int | None
    duration: float
    acknowledged: bool
    count: int
    message: str


@dataclass
class _Open:
    status: ConditionStatus  # the latest
    severity: Severity
    message: str


class AlarmLog:
    """Makes events of changes of the alarm, given in their order."""

    def __init__(self) -> None:
        self._open: dict[Condition, _Open] = {}
        self._events: list[AlarmEvent] = []

    def add(self, status: AlarmStatus) -> None:
        """Take in the alarms' new status."""
        raised = {_family(each.condition): each for each in status.conditions if each.active}
        for family, before in list(self._open.items()):
            now = raised.get(family)
            if now is None or now.first_ns != before.status.first_ns:
                self._close(family, status.stamp_ns)
        for family, now in raised.items():
            known = self._open.get(family)
            if known is None:
                self._open[family] = _Open(now, now.severity, now.message)
                continue
            known.status = now
            if now.severity > known.severity:
                known.severity, known.message = now.severity, now.message

    def _close(self, family: Condition, stamp_ns: int) -> None:
        ended = self._open.pop(family)
        back = stamp_ns < ended.status.first_ns
        self._events.append(_event(ended, None if back else stamp_ns, ended.status.last_ns))

    def events(self, end_ns: int) -> tuple[AlarmEvent, ...]:
        """Return all events, in the order they ended; what is still raised lasts to `end_ns`."""
        return (*self._events, *(_event(each, None, end_ns) for each in self._open.values()))


def _family(condition: Condition) -> Condition:
    return Condition.TRACTION_LOST if condition in _ONE_ALARM else condition


def _event(alarm: _Open, cleared_ns: int | None, seen_ns: int) -> AlarmEvent:
    first_ns = alarm.status.first_ns
    until_ns = seen_ns if cleared_ns is None else cleared_ns
    return AlarmEvent(
        condition=alarm.status.condition.name.lower(),
        severity=alarm.severity.name.lower(),
        raised_ns=first_ns,
        cleared_ns=cleared_ns,
        duration=max(until_ns - first_ns, 0) * _SECONDS,
        acknowledged=alarm.status.acknowledged,
        count=alarm.status.count,
        message=alarm.message,
    )


def time_in_alarms(events: tuple[AlarmEvent, ...]) -> dict[str, float]:
    """Return the time [s] that each condition was raised, for those that were."""
    return dict(_sums(events))


def _sums(events: tuple[AlarmEvent, ...]) -> Iterator[tuple[str, float]]:
    for name in sorted({event.condition for event in events}):
        yield name, sum(event.duration for event in events if event.condition == name)
