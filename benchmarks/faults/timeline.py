"""What was heard of one run, in the scenario's time."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from belt_msgs.msg import BeltState, SlipAlarm
from numpy.typing import NDArray

from belt_ros.estimation import Condition, Severity
from benchmarks.faults.cases import Case
from benchmarks.faults.recorder import Heard
from benchmarks.faults.run import Record

_SECONDS = 1e-9
_ROUNDING = 1e-6  # [s]
_Floats = NDArray[np.float64]


class Status(NamedTuple):
    """The alarms as heard at one time: those that are raised, and those that are latched only."""

    time: float  # [s]
    raised: dict[Condition, Severity]
    latched: frozenset[Condition]  # not acknowledged, raised or not


class Timeline(NamedTuple):
    """Times count from the beginning of the scenario [s].

    They are those of the stamps, which are the estimator's time, with what a fault has added to
    them taken off; where it is the joint states that are late, those of arrival.
    """

    states: list[BeltState]
    state_times: _Floats
    statuses: list[Status]
    truths: list[BeltState]
    truth_times: _Floats
    latency: float  # by which an alarm was heard after its time, at most [s]

    def raised_at(self, times: _Floats, condition: Condition, least: Severity) -> NDArray[np.bool_]:
        """Whether a condition was raised, `least` as severe, at each of `times`."""
        begins = [status.time for status in self.statuses]
        places = np.searchsorted(begins, times, side="right") - 1
        raised = [
            status.raised.get(condition, Severity.NORMAL) >= least for status in self.statuses
        ]
        return np.array([place >= 0 and raised[place] for place in places], dtype=np.bool_)


def _stamp_ns(message: Any) -> int:
    stamp = message.header.stamp
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def timeline(case: Case, record: Record) -> Timeline:
    """Put what was heard in order."""
    begin = _stamp_ns(record.truths[0].message)
    # The rig's stamps are behind its own pace by what it took to begin.
    pace = min(heard.arrival_ns - _stamp_ns(heard.message) for heard in record.truths)
    truths = np.array([(_stamp_ns(heard.message) - begin) * _SECONDS for heard in record.truths])
    clock = _Clock(case, begin, pace)
    times = [clock.time(heard) for heard in record.alarms]
    alarms = [
        (time, heard)
        for time, heard in zip(times, record.alarms, strict=True)
        if time < truths[-1] - _ROUNDING  # then silence begins
    ]
    return Timeline(
        [heard.message for heard in record.states],
        np.array([clock.time(heard) for heard in record.states]),
        [_status(time, heard.message) for time, heard in alarms],
        [heard.message for heard in record.truths],
        truths,
        max((clock.arrival(heard) - time for time, heard in alarms), default=0.0),
    )


class _Clock:
    """Tells the scenario's time of what was heard."""

    def __init__(self, case: Case, begin_ns: int, pace_ns: int) -> None:
        self._begin_ns = begin_ns
        self._pace_ns = pace_ns
        faults = case.script["faults"]
        self._by_arrival = any(
            fault["kind"] == "delayed" and fault["sensor"] == "all" for fault in faults
        )
        self._jumps = (0.0, *(f["value"] for f in faults if f["kind"] == "time_jump"))

    def arrival(self, heard: Heard) -> float:
        """When it came [s]."""
        return float(heard.arrival_ns - self._pace_ns - self._begin_ns) * _SECONDS

    def time(self, heard: Heard) -> float:
        """When it was [s]."""
        arrival = self.arrival(heard)
        if self._by_arrival:
            return arrival
        stamped = (_stamp_ns(heard.message) - self._begin_ns) * _SECONDS
        return float(
            min((stamped - jump for jump in self._jumps), key=lambda time: abs(arrival - time))
        )


def _status(time: float, alarm: SlipAlarm) -> Status:
    return Status(
        time,
        {Condition(c.condition): Severity(c.severity) for c in alarm.conditions if c.active},
        frozenset(Condition(c.condition) for c in alarm.conditions if not c.acknowledged),
    )


def not_finite(record: Record) -> set[str]:
    """Return the numbers that were none: NaN or infinite, in state, alarm or diagnostics."""
    fields = {
        f"{type(heard.message).__name__}.{name}"
        for heard in (*record.states, *record.alarms)
        for name, value in _numbers(heard.message)
        if not math.isfinite(value)
    }
    return fields | {
        f"{row.name}: {pair.key}"
        for heard in record.diagnostics
        for row in heard.message.status
        for pair in row.values
        if pair.value.lower().lstrip("+-") in ("nan", "inf", "infinity")
    }


def _numbers(message: Any) -> Iterator[tuple[str, float]]:
    for name, kind in message.get_fields_and_field_types().items():
        if kind == "double":
            yield name, getattr(message, name)
