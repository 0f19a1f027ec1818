"""What is told of alarms by what no measurement has changed: a reset, a node that is inactive."""

import math

import pytest
from node_harness import PAPER_DRIVE
from pipeline_harness import Waiting, calibrated, sliding, take_one

from belt_ros.estimation import AlarmStatus, Condition, Severity
from belt_ros.node import services
from belt_ros.node.pipeline import Pipeline
from belt_ros.settings import load_settings


def test_after_a_reset_no_alarm_stands_that_no_measurement_has_raised_since() -> None:
    """Also where the drive stands, and nothing more comes."""
    pipeline = sliding()
    published: list[AlarmStatus] = []
    answer = services.reset(pipeline, None, published.append)
    assert answer.success
    (status,) = published
    assert pipeline.alarm is status
    assert (status.condition, status.severity) == (Condition.NONE, Severity.NORMAL)
    assert (status.latched_severity, status.acknowledged) == (Severity.NORMAL, True)
    assert status.conditions == ()
    assert status.count == 0
    assert all(map(math.isfinite, status.margin))
    assert "no alarm condition" in status.message


def test_the_alarm_that_a_reset_takes_back_has_no_numbers_of_before_but_the_time_of_now() -> None:
    pipeline = sliding()
    before = pipeline.alarm
    assert before is not None
    assert before.gross_slip_probability > 0.5
    now_ns = 50 * 10**9
    pipeline.watch(now_ns)

    status = pipeline.reset()
    assert status is not None
    assert status.stamp_ns == now_ns
    assert status.margin == (0.5, pytest.approx(1.0 / math.sqrt(12.0)))
    assert (status.excess_slip, status.gross_slip_probability) == (0.0, 0.0)


def test_a_reset_before_anything_came_has_no_alarm_to_take_back() -> None:
    published: list[AlarmStatus] = []
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    assert services.reset(pipeline, None, published.append).success
    assert published == []


def test_where_nobody_watches_no_alarm_but_that_is_told_to_be_there() -> None:
    pipeline = sliding()
    assert pipeline.alarm is not None
    raised = pipeline.alarm
    told = pipeline.end()
    assert told is not None
    assert (told.condition, told.severity) == (Condition.SENSOR_STALE, Severity.ALARM)
    assert told.active
    assert "nobody watches the belt" in told.message
    assert [each.condition for each in told.conditions if each.active] == [Condition.SENSOR_STALE]
    latched = {each.condition: each.latched_severity for each in told.conditions}
    for each in raised.conditions:
        assert latched[each.condition] == each.latched_severity
    assert told.latched_severity == raised.latched_severity
    assert not told.acknowledged


def test_where_nobody_watches_a_belt_without_alarms_is_not_told_to_be_well() -> None:
    pipeline = calibrated()
    told = pipeline.end()
    assert told is not None
    assert (told.severity, told.acknowledged) == (Severity.ALARM, True)
    assert len(told.conditions) == 1


def test_before_anything_was_told_there_is_nothing_to_take_back() -> None:
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    assert pipeline.end() is None
    pipeline.begin()
    told = take_one(pipeline, 10.0)
    assert told is not None
    assert told.severity is Severity.NORMAL


def test_the_first_estimate_of_a_belt_that_is_watched_again_tells_the_alarms_as_they_are() -> None:
    pipeline = sliding()
    raised = pipeline.alarm
    assert raised is not None
    pipeline.end()
    pipeline.begin()
    told = take_one(pipeline, 30.0, driven=60.0)
    assert told is not None
    assert told == pipeline.alarm
    assert told.stamp_ns == 30 * 10**9
    assert told.severity == raised.severity
    assert told.acknowledged == raised.acknowledged
    assert take_one(pipeline, 30.01, driven=60.0) is None


def test_until_the_first_estimate_an_acknowledgement_does_not_tell_what_was_as_if_it_were() -> None:
    pipeline = sliding()
    pipeline.end()
    pipeline.begin()
    told = pipeline.acknowledge()
    assert told is not None
    assert told.acknowledged
    assert [each.condition for each in told.conditions if each.active] == [Condition.SENSOR_STALE]
    again = take_one(pipeline, 30.0, driven=60.0)
    assert again is not None
    assert again.acknowledged


def test_a_belt_that_is_watched_again_but_not_heard_of_is_told_to_be_silent() -> None:
    drive = Waiting()
    take_one(drive.pipeline, 1000.0)
    drive.pipeline.end()
    drive.pipeline.begin()
    told = drive.wait(2.0, 1001.0)
    assert told is not None
    assert told.condition is Condition.SENSOR_STALE
    assert "no usable measurement" in told.message


def test_a_belt_that_was_silent_before_nobody_watched_it_is_told_of_once() -> None:
    drive = Waiting()
    take_one(drive.pipeline, 1000.0)
    silent = drive.wait(2.0, 1001.0)
    assert silent is not None
    told = drive.pipeline.end()
    assert told is not None
    (stale,) = told.conditions
    assert stale.condition is Condition.SENSOR_STALE
    assert (stale.count, stale.acknowledged) == (1, False)
    assert "nobody watches the belt" in stale.message


def test_an_active_node_that_hears_nothing_does_not_say_that_it_is_inactive() -> None:
    """Also where the sensors were silent before, which is no news."""
    drive = Waiting()
    for sample in range(50):
        take_one(drive.pipeline, 1000.0 + 0.01 * sample)
    assert drive.wait(5.0, 1001.0) is not None
    assert drive.pipeline.end() is not None
    drive.pipeline.begin()
    told = drive.wait(60.0, 1010.0)
    assert told is not None
    assert told.condition is Condition.SENSOR_STALE
    assert "no usable measurement" in told.message
