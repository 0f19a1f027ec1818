"""Alarms as events, and diagnostics on the time line of the bag."""

from itertools import pairwise
from pathlib import Path

import pytest
from test_run import ALARM, messages, stamp_ns

from belt_ros import diagnostic_rows
from belt_ros.estimation import Measurement
from belt_ros.replay import replay

BAG = Path(__file__).parents[1] / "data" / "rig_bag"
DIAGNOSTICS = "/diagnostics"


@pytest.fixture(scope="module")
def replayed(settings, tmp_path_factory):
    out = tmp_path_factory.mktemp("rig") / "out"
    return replay(BAG, settings, out, smooth=False), out


def test_events_are_what_the_alarm_topic_tells(replayed):
    summary, out = replayed
    alarms = [message for _, message in messages(out, ALARM)]
    raised = {
        (each.first_time.sec * 1_000_000_000 + each.first_time.nanosec)
        for message in alarms
        for each in message.conditions
        if each.active
    }
    assert {event.raised_ns for event in summary.alarms} == raised
    assert len(summary.alarms) == len(raised) >= 1
    stamps = {stamp_ns(message) for message in alarms}
    for event in summary.alarms:
        assert event.cleared_ns is None or event.cleared_ns in stamps
        assert 0.0 < event.duration <= summary.duration
        assert event.message
    assert sum(summary.time_in_alarm.values()) == pytest.approx(
        sum(event.duration for event in summary.alarms)
    )


def test_every_alarm_that_was_raised_counts_also_while_others_are(replayed):
    summary, out = replayed
    raised, before = 0, set()
    for _, message in messages(out, ALARM):
        now = {each.condition for each in message.conditions if each.active}
        raised += len(now - before)
        before = now
    assert summary.alarms_raised == len(summary.alarms) == raised > 1


def test_diagnostics_come_every_second_and_when_an_alarm_gets_worse(replayed):
    summary, out = replayed
    told = messages(out, DIAGNOSTICS)
    regular = [log_ns for log_ns, message in told if len(message.status) == 2]
    steps = [after - before for before, after in pairwise(regular)]
    assert set(steps[:-1]) == {1_000_000_000}
    assert len(regular) == 8  # 7 s, and what is left at the end
    assert all(stamp_ns(message) == log_ns for log_ns, message in told)
    severities = [0, *(message.severity for _, message in messages(out, ALARM))]
    rises = sum(after > before for before, after in pairwise(severities))
    assert sum(len(message.status) == 1 for _, message in told) == rises >= 1
    drive, source = told[3][1].status
    assert (drive.name, source.name) == ("belt_node: paper_drive", "belt_node: paper_drive input")
    assert {"margin [-]", "mean tension [N]"} <= {value.key for value in drive.values}
    assert summary.alarms


def test_rows_are_those_of_the_live_node(settings):
    pytest.importorskip("diagnostic_msgs")
    diagnostics = pytest.importorskip("belt_ros.node.diagnostics")
    monitor = settings.monitor()
    cases = [(None, None, 5.0)]
    for k in range(30):
        output = monitor.step(Measurement(k * 10_000_000, 120.0, 119.7, 15.0, -15.0))
        cases.append((output.estimate, output.alarm, 0.0))
    for estimate, alarm, unused in cases:
        live = diagnostics.drive_status("n", "d", estimate, alarm, unused, 1.0)
        row = diagnostic_rows.drive_row("n", "d", estimate, alarm, unused, 1.0)
        assert (live.level[0], live.name, live.hardware_id, live.message) == (
            row.level,
            row.name,
            row.hardware_id,
            row.message,
        )
        ours = {key: diagnostic_rows.number_text(value) for key, value in row.values.items()}
        assert {value.key: value.value for value in live.values} == ours
    assert diagnostics.REJECTION_ADVICE == diagnostic_rows.REJECTION_ADVICE
