"""A drive that falls silent raises its alarm while it is silent, also when it stays so."""

import dataclasses
import math
from itertools import pairwise

import pytest
from bags import START_NS, Sample, steady_run, write_bag
from recordings import float64, record
from test_drive_bag import _joint_state as joint_state
from test_run import ALARM, messages, stamp_ns

from belt_ros.diagnostic_rows import Level
from belt_ros.estimation import Condition
from belt_ros.replay import replay

GAP_NS = 1_000_000_000  # limits.greatest_gap of the paper's drive


def later(samples: list[Sample], delay_ns: int) -> list[Sample]:
    return [
        each._replace(log_ns=each.log_ns + delay_ns, stamp_ns=each.stamp_ns + delay_ns)
        for each in samples
    ]


def interrupted() -> list[Sample]:
    """4 s with two outages, of 2.5 s and of 5 s."""
    run = steady_run(400)
    return [*run[:100], *later(run[100:300], 2_500_000_000), *later(run[300:], 7_500_000_000)]


def with_tail(path, samples, seconds: float):
    """A bag in which something else goes on being recorded after the drive."""
    logged = [(each.log_ns, "/joint_states", joint_state(each)) for each in samples]
    end_ns = samples[-1].log_ns
    others = [
        (end_ns + k * 100_000_000, "/temperature", float64(20.0))
        for k in range(1, round(10 * seconds) + 1)
    ]
    return record(path, [*logged, *others])


def raised(out):
    """Log times and stamps at which SENSOR_STALE was first told to be raised."""
    found, before = [], False
    for log_ns, message in messages(out, ALARM):
        now = any(
            each.condition == Condition.SENSOR_STALE and each.active for each in message.conditions
        )
        if now and not before:
            found.append((log_ns, stamp_ns(message)))
        before = now
    return found


def test_an_outage_raises_its_alarm_while_it_lasts(make_bag, settings, tmp_path):
    samples = interrupted()
    summary = replay(make_bag(samples), settings, tmp_path / "out", smooth=False)
    last = [a for a, b in pairwise(samples) if b.stamp_ns - a.stamp_ns > GAP_NS]
    assert len(last) == 2
    told = raised(tmp_path / "out")
    after = GAP_NS + 1
    assert told == [(each.log_ns + after, each.stamp_ns + after) for each in last]
    stale = [event for event in summary.alarms if event.condition == "sensor_stale"]
    assert [event.raised_ns for event in stale] == [stamp for _, stamp in told]


def test_a_drive_that_stays_silent_raises_its_alarm_until_the_bag_ends(settings, tmp_path):
    samples = steady_run(100)
    bag = with_tail(tmp_path / "bag", samples, 8.0)
    summary = replay(bag, settings, tmp_path / "out", smooth=False)
    (stale,) = summary.alarms
    assert (stale.condition, stale.cleared_ns) == ("sensor_stale", None)
    assert stale.raised_ns == samples[-1].stamp_ns + GAP_NS + 1
    assert stale.duration == pytest.approx(7.0)
    assert summary.worst_severity == "alarm"
    (log_ns, _) = raised(tmp_path / "out")[0]
    *_, (at_ns, message) = messages(tmp_path / "out", "/diagnostics")
    assert at_ns == log_ns
    assert {Level(row.level) for row in message.status} == {Level.STALE}


def test_a_bag_that_ends_with_its_drive_or_soon_after_raises_nothing(settings, tmp_path):
    samples = steady_run(100)
    bag = with_tail(tmp_path / "bag", samples, 0.9)
    summary = replay(bag, settings, tmp_path / "out", smooth=False)
    alone = write_bag(tmp_path / "alone", {"/joint_states": samples})
    same = replay(alone, settings, tmp_path / "same", smooth=False)
    assert summary.alarms == same.alarms == ()
    assert dataclasses.replace(summary, bag="") == dataclasses.replace(same, bag="")


def test_what_comes_but_cannot_be_used_is_silence_too(make_bag, settings, tmp_path):
    samples = steady_run(400)
    nothing = {"velocity": (math.nan, math.nan), "effort": ()}
    samples[100:350] = [each._replace(**nothing) for each in samples[100:350]]
    replay(make_bag(samples), settings, tmp_path / "out", smooth=False)
    ((log_ns, _),) = raised(tmp_path / "out")
    assert log_ns == samples[99].log_ns + GAP_NS + 1


def test_silence_is_told_on_the_clock_of_the_stamps(make_bag, settings, tmp_path):
    """A simulation's stamps begin at zero, whenever the bag was recorded."""
    shift = START_NS - 5_000_000_000
    samples = [each._replace(stamp_ns=each.stamp_ns - shift) for each in interrupted()]
    replay(make_bag(samples), settings, tmp_path / "out", smooth=False)
    told = raised(tmp_path / "out")
    assert len(told) == 2
    assert all(log_ns - stamp == shift + 1_000_000 for log_ns, stamp in told)
