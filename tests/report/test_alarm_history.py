import json

import numpy as np

from belt_ros.replay.results import TABLE_NAME
from belt_ros.report.alarm_history import (
    MOST_CHANGES,
    AlarmTally,
    Change,
    Interval,
    Level,
    raised_ns,
    read_changes,
)
from belt_ros.report.table_scan import Batch, scan

LOW, GROSS = 1, 3
S = 1_000_000_000


def history(changes, end=10.0):
    elapsed = np.arange(0.0, end + 0.1, 0.1)
    tally = AlarmTally(changes)
    log_ns = np.round(elapsed * S).astype(np.int64)
    for part in np.array_split(np.arange(len(elapsed)), 3):
        tally.add(Batch(elapsed[part], np.full(len(part), 0.1), log_ns[part], {}))
    return tally.history()


def change(at, **levels):
    names = {"low": LOW, "gross": GROSS}
    told = {names[name]: Level(severity, f"{name} {severity}") for name, severity in levels.items()}
    return Change(round(at * S), told)


def test_an_alarm_lasts_until_it_is_taken_back():
    found = history([change(0.0), change(2.0, low=1), change(3.0, low=2), change(5.0)])
    assert found.intervals == (
        Interval(LOW, 1, 2.0, 3.0, "low 1"),
        Interval(LOW, 2, 3.0, 5.0, "low 2"),
    )
    assert found.spans(LOW) == [(2.0, 5.0, 2)]


def test_conditions_are_apart_and_in_the_order_of_their_first_time():
    found = history([change(1.0, gross=3), change(2.0, gross=3, low=1), change(4.0, low=1)])
    assert found.conditions == [GROSS, LOW]
    assert found.spans(GROSS) == [(1.0, 4.0, 3)]
    assert found.spans(LOW)[0][1] == 10.0


def test_waiting_for_acknowledgement_is_no_alarm():
    found = history([change(1.0, low=2), change(2.0, low=0)])
    assert [interval.severity for interval in found.intervals] == [2, 0]
    assert found.spans(LOW) == [(1.0, 2.0, 2)]


def test_worst_rises_come_first():
    changes = [change(1.0, low=1), change(2.0, gross=3), change(3.0), change(4.0, low=2)]
    assert raised_ns(changes, 2) == [2 * S, 4 * S]


def test_a_flapping_alarm_is_cut_off_and_says_so():
    changes = [change(i * 1e-4, low=i % 2) for i in range(MOST_CHANGES + 1)]
    assert not history(changes).complete


def test_intervals_agree_with_the_times_of_the_summary(results):
    tally = AlarmTally(read_changes(results / "estimates"))
    summary = json.loads((results / "summary.json").read_text())
    scan(results / TABLE_NAME, summary["start_ns"], tally)
    found = tally.history()
    # Times of the worst severity at every moment, by an independent route.
    moments = np.arange(0.0, summary["duration"], 1e-3) + 0.5e-3
    worst = np.zeros(len(moments), dtype=int)
    for interval in found.raised:
        inside = (moments > interval.start) & (moments < interval.end)
        worst[inside] = np.maximum(worst[inside], interval.severity)
    told = summary["time_in_severity"]
    assert told["trip"] + told["alarm"] > 0.1
    for number, name in enumerate(("normal", "warning", "alarm", "trip")):
        assert abs(np.count_nonzero(worst == number) * 1e-3 - told[name]) < 0.012
