"""Low margin and gross slip, as heard, against what truly was: raised, held, and false.

Modelled on the bag test of nav2's collision monitor: an alarm is to be there so soon after the
truth has crossed its threshold, to be held while the truth is beyond it, and not to be there else.
"""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation import Condition, Phase, Severity
from belt_ros.estimation.alarm_settings import AlarmSettings
from belt_ros.settings import load_settings
from benchmarks.estimation.judged import SOURCES
from benchmarks.faults.cases import Case
from benchmarks.faults.timeline import Timeline

ALLOWED = 0.5  # [s] beyond the on-delay
_CLEARING = 1.0  # [s] beyond the off-delay
HELD, FALSE = 0.95, 0.01  # of the time: held at the least, false at the most
_Flags = NDArray[np.bool_]


class Level(NamedTuple):
    """One threshold of the truth, and the alarm that tells of it."""

    name: str
    condition: Condition
    severity: Severity


LEVELS = (
    Level("margin below warning", Condition.LOW_MARGIN, Severity.WARNING),
    Level("margin below alarm", Condition.LOW_MARGIN, Severity.ALARM),
    Level("gross slip", Condition.GROSS_SLIP, Severity.ALARM),
)


class Crossing(NamedTuple):
    """What one alarm did in one run; times [s]."""

    case: str
    level: str
    sources: str
    crossings: int  # of the truth, that lasted so long that the alarm was due
    in_time: int
    slowest: float  # from crossing to alarm; NaN: no crossing
    due: float  # time in which the alarm was to be there
    held: float  # and was
    free: float  # time in which it was not to be there
    false: float  # and was


def crossings(case: Case, heard: Timeline) -> list[Crossing]:
    """Compare a run with its truth, at each level."""
    settings = load_settings(case.config).alarm
    return [_crossing(case, heard, level, settings) for level in LEVELS]


def _crossing(case: Case, heard: Timeline, level: Level, settings: AlarmSettings) -> Crossing:
    times = heard.truth_times
    step = float(np.median(np.diff(times)))
    raised = heard.raised_at(times, level.condition, level.severity)
    truly = _truly(heard, level, settings)
    on, off = _delays(level, settings)
    due, free = np.zeros_like(raised), ~truly
    delays = []
    for first, last in _stretches(truly):
        within = (times >= times[first]) & (times <= times[last])
        free &= ~((times > times[last]) & (times <= times[last] + off + _CLEARING))
        if times[last] - times[first] > on + ALLOWED:
            due |= within & (times > times[first] + on + ALLOWED)
            there = np.flatnonzero(raised & within)
            delays.append(times[there[0]] - times[first] if there.size else math.inf)
    return Crossing(
        case.name,
        level.name,
        SOURCES,
        len(delays),
        sum(delay <= on + ALLOWED for delay in delays),
        max(delays, default=math.nan),
        step * float(due.sum()),
        step * float((due & raised).sum()),
        step * float(free.sum()),
        step * float((free & raised).sum()),
    )


def _truly(heard: Timeline, level: Level, settings: AlarmSettings) -> _Flags:
    """Whether the truth is beyond a threshold."""
    if level.condition is Condition.GROSS_SLIP:
        return np.array([truth.phase == Phase.GROSS_SLIP for truth in heard.truths], dtype=np.bool_)
    warning = level.severity is Severity.WARNING
    limit = settings.margin_warning if warning else settings.margin_alarm
    return np.array([truth.margin < limit for truth in heard.truths], dtype=np.bool_)


def _delays(level: Level, settings: AlarmSettings) -> tuple[float, float]:
    if level.condition is Condition.GROSS_SLIP:
        return settings.trip_on_delay, settings.trip_off_delay
    return settings.on_delay, settings.off_delay


def _stretches(flags: _Flags) -> Iterator[tuple[int, int]]:
    """First and last place of each run of those that are set."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flags, [False])).astype(np.int8)))
    for first, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        yield first, end - 1


def totals(rows: Sequence[Crossing]) -> Crossing:
    """Return the sum over runs, of one level or of all."""
    return Crossing(
        "all",
        rows[0].level,
        SOURCES,
        sum(row.crossings for row in rows),
        sum(row.in_time for row in rows),
        max((row.slowest for row in rows if not math.isnan(row.slowest)), default=math.nan),
        sum(row.due for row in rows),
        sum(row.held for row in rows),
        sum(row.free for row in rows),
        sum(row.false for row in rows),
    )
