"""When which alarm was raised, from the alarm topic of a result bag."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from belt_ros.replay.result_bag import ALARM_TYPE
from belt_ros.report.result_messages import LogTimes, result_messages
from belt_ros.report.table_scan import Batch

MOST_CHANGES = 20_000  # of alarms, that a report takes in


class Level(NamedTuple):
    """One condition at one time."""

    severity: int  # 0: it waits to be acknowledged
    message: str


class Change(NamedTuple):
    """All conditions that are raised or latched, from one log time on."""

    log_ns: int
    levels: dict[int, Level]


class Interval(NamedTuple):
    """A time during which a condition had one severity. Times in s, as in the summary."""

    condition: int
    severity: int  # 0: over, not yet acknowledged
    start: float
    end: float
    message: str


@dataclass(frozen=True)
class AlarmHistory:
    """What became of the alarms."""

    intervals: tuple[Interval, ...]
    complete: bool  # whether all changes of the bag are in it

    @property
    def raised(self) -> tuple[Interval, ...]:
        """Intervals in which a condition held."""
        return tuple(interval for interval in self.intervals if interval.severity)

    def spans(self, condition: int) -> list[tuple[float, float, int]]:
        """Return start, end and worst severity of each time that a condition held."""
        spans: list[tuple[float, float, int]] = []
        for interval in self.raised:
            if interval.condition != condition:
                continue
            if spans and spans[-1][1] == interval.start:
                start, _, worst = spans.pop()
                spans.append((start, interval.end, max(worst, interval.severity)))
            else:
                spans.append((interval.start, interval.end, interval.severity))
        return spans

    @property
    def conditions(self) -> list[int]:
        """Conditions that were raised, in the order of their first time."""
        first: dict[int, float] = {}
        for interval in self.raised:
            first[interval.condition] = min(
                interval.start, first.get(interval.condition, interval.start)
            )
        return sorted(first, key=lambda condition: (first[condition], condition))


def read_changes(bag: Path) -> list[Change]:
    """Return the changes of the alarm in a result bag; one more than are taken in, if there are.

    Raises
    ------
    ReportError
        If the bag is damaged.
    """
    messages = islice(result_messages(bag, ALARM_TYPE), MOST_CHANGES + 1)
    return [Change(log_ns, dict(_levels(message))) for log_ns, message in messages]


def _levels(message: Any) -> Iterator[tuple[int, Level]]:
    """Results of older versions tell of the worst condition only."""
    for status in getattr(message, "conditions", [message]):
        if status.condition:
            yield status.condition, Level(status.severity if status.active else 0, status.message)


def raised_ns(changes: Sequence[Change], most: int) -> list[int]:
    """Return log times [ns] at which severity rose, the worst first, `most` of them."""
    rises = []
    before = 0
    for change in changes:
        severity = max((level.severity for level in change.levels.values()), default=0)
        if severity > before:
            rises.append((-severity, change.log_ns))
        before = severity
    return [log_ns for _, log_ns in sorted(rises)[:most]]


class AlarmTally:
    """Puts changes of the alarm on the time of the table.

    Parameters
    ----------
    changes : sequence of Change
        In the order of their log time.
    """

    columns: Sequence[str] = ()

    def __init__(self, changes: Sequence[Change]) -> None:
        self._changes = changes[:MOST_CHANGES]
        self._complete = len(changes) <= MOST_CHANGES
        self._times = LogTimes([change.log_ns for change in self._changes])
        self._end = 0.0

    def add(self, batch: Batch) -> None:
        """Take in the next rows."""
        self._times.add(batch)
        self._end = float(batch.elapsed[-1])

    def history(self) -> AlarmHistory:
        """Return what became of the alarms up to the table's end."""
        open_since: dict[int, tuple[float, Level]] = {}
        intervals: list[Interval] = []
        for change, time in zip(self._changes, self._times.seconds, strict=True):
            for condition in [*open_since]:
                start, level = open_since[condition]
                now = change.levels.get(condition)
                if now is None or now.severity != level.severity:
                    intervals.append(_interval(condition, level, start, time))
                    del open_since[condition]
            for condition, level in change.levels.items():
                open_since.setdefault(condition, (time, level))
        for condition, (start, level) in open_since.items():
            intervals.append(_interval(condition, level, start, self._end))
        intervals.sort(key=lambda interval: (interval.start, interval.condition))
        return AlarmHistory(tuple(intervals), self._complete)


def _interval(condition: int, level: Level, start: float, end: float) -> Interval:
    return Interval(condition, level.severity, start, max(end, start), level.message)
