"""The verdict on one fault: detected in time, the right alarm, cleared, latched, sound, alive."""

import itertools
import math
from collections.abc import Collection
from typing import NamedTuple

from belt_msgs.msg import BeltState

from belt_ros.estimation import Condition, Rejection
from belt_ros.estimation.alarm_settings import AlarmSettings
from belt_ros.settings import load_settings
from benchmarks.estimation.judged import SOURCES
from benchmarks.faults.cases import TRACTION, Case
from benchmarks.faults.run import Record
from benchmarks.faults.timeline import Timeline, not_finite

_CLEARING = 1.0  # [s] beyond the off-delay in which a condition is to be cleared
_LOSSES = TRACTION - {Condition.LOW_MARGIN}


class Verdict(NamedTuple):
    """What came of a fault. Each of `detected` to `alive` is 1 if it was as it should be."""

    case: str
    drive: str
    sources: str
    detected: int  # in time; where silence is right: counted where that is right
    right: int  # no alarm but those that are right, and none before the fault
    cleared: int  # all of them in time
    latched: int  # until acknowledged, and released by that
    finite: int
    alive: int  # and saying states at the end
    raised: str  # conditions, in order, with the delay after the fault [s]
    delay: float  # of the right alarm [s]; NaN: none
    clearing: float  # when the last one was cleared, after the end of the cause [s]; NaN: none
    rejected: int  # measurements
    resets: int
    states: float  # heard, of the samples
    latency: float  # by which an alarm was heard after its time, at most [s]

    @property
    def good(self) -> bool:
        """Whether all was as it should be."""
        return all(self[3:9])


def judged(case: Case, record: Record, heard: Timeline) -> Verdict:
    """Judge a run."""
    raised = _first_raised(heard)
    delays = {condition: time - case.begin for condition, time in raised.items()}
    of_right = [delays[each] for each in case.right.accepted if each in delays]
    delay = min(of_right, default=math.nan)
    last = heard.states[-1] if heard.states else BeltState()
    clearings = _clearings(heard, raised)
    clearing = max(clearings.values(), default=math.nan) - case.end
    return Verdict(
        case.name,
        case.drive,
        SOURCES,
        int(_detected(case, delay) and _counted(case, last)),
        int(_right(case, delays)),
        int(_cleared(case, clearings)),
        int(_latched(case, heard, raised)),
        int(not not_finite(record)),
        int(record.alive and _flowing(case, heard)),
        " ".join(f"{each.name.lower()}:{delays[each]:.2f}" for each in raised),
        float(delay),
        float(clearing),
        int(sum(last.rejection_counts)),
        int(last.reset_count),
        len(heard.states) / len(heard.truths),
        heard.latency,
    )


def _first_raised(heard: Timeline) -> dict[Condition, float]:
    """Return when each condition was raised for the first time [s], in that order."""
    raised: dict[Condition, float] = {}
    for status in heard.statuses:
        for condition in status.raised:
            raised.setdefault(condition, status.time)
    return raised


def _detected(case: Case, delay: float) -> bool:
    return not case.right.accepted or 0.0 <= delay <= case.right.within


def _counted(case: Case, last: BeltState) -> bool:
    """Whether what is to be turned away was, and the estimate began anew as often as is right."""
    reason = case.right.counted
    turned_away = reason is Rejection.NONE or last.rejection_counts[reason] > 0
    return bool(turned_away and last.reset_count == case.right.resets)


def _right(case: Case, delays: dict[Condition, float]) -> bool:
    allowed = case.right.accepted | case.right.also
    return all(each in allowed and delay >= 0.0 for each, delay in delays.items())


def _clearings(heard: Timeline, raised: Collection[Condition]) -> dict[Condition, float]:
    """Return when each condition was cleared for good [s]; infinite: never."""
    cleared = dict.fromkeys(raised, math.inf)
    for before, after in itertools.pairwise(heard.statuses):
        for condition in before.raised.keys() - after.raised.keys():
            cleared[condition] = after.time
        for condition in after.raised:
            cleared[condition] = math.inf
    return cleared


def _cleared(case: Case, clearings: dict[Condition, float]) -> bool:
    settings = load_settings(case.config).alarm
    return all(
        time <= case.end + off_delay(settings, condition) + _CLEARING
        for condition, time in clearings.items()
    )


def off_delay(settings: AlarmSettings, condition: Condition) -> float:
    """Return how long a condition must be gone to be cleared [s]."""
    names = {
        Condition.LOW_MARGIN: "off_delay",
        Condition.EXCESS_SLIP: "off_delay",
        Condition.GROSS_SLIP: "trip_off_delay",
        Condition.SENSOR_STALE: "stale_off_delay",
        Condition.SENSOR_IMPLAUSIBLE: "implausible_off_delay",
        Condition.ESTIMATOR_LOST: "lost_off_delay",
    }
    return float(getattr(settings, names.get(condition, "traction_off_delay")))


def _latched(case: Case, heard: Timeline, raised: Collection[Condition]) -> bool:
    """Whether all that was raised stayed latched until it was acknowledged, and no longer."""
    if not raised:
        return True
    before = [status for status in heard.statuses if status.time < case.acknowledged]
    after = [status for status in heard.statuses if status.time >= case.acknowledged]
    if not before or not after or after[-1].latched:
        return False
    return _alarms(before[-1].latched) == _alarms(raised)


def _alarms(conditions: Collection[Condition]) -> set[Condition]:
    """Return conditions with all names of lost traction as one: they are one alarm."""
    return {Condition.TRACTION_LOST if each in _LOSSES else each for each in conditions}


def _flowing(case: Case, heard: Timeline) -> bool:
    """Whether states came in the last second, nearly as many as there were samples."""
    rate = float(case.script["sample_rate"])
    return int((heard.state_times > case.duration - 1.0).sum()) >= 0.9 * rate
