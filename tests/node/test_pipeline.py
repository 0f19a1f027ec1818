"""One drive behind the node, without a graph."""

from collections.abc import Callable

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from node_harness import PAPER_DRIVE
from pipeline_harness import STEP_NS, Waiting, calibrated, sliding, states_of

from belt_ros.estimation import Condition, Measurement, Rejection
from belt_ros.node.pipeline import Outcome, Pipeline
from belt_ros.settings import load_settings


def test_sensors_that_never_say_anything_are_told_of_after_ten_seconds() -> None:
    drive = Waiting()
    assert drive.wait(9.5, 1.7e9) is None
    told = drive.wait(2.0, 1.7e9 + 9.5)
    assert told is not None
    assert told.condition is Condition.SENSOR_STALE
    row = drive.pipeline.drive_status()
    assert "alarm severity" in {value.key for value in row.values}


def test_nothing_is_missing_while_simulated_time_has_not_begun_or_stands_still() -> None:
    drive = Waiting()
    assert drive.wait(30.0, 0.0, stands=True) is None
    assert drive.wait(30.0, 1.7e9, stands=True) is None
    assert drive.wait(9.0, 1.7e9) is None
    assert drive.wait(3.0, 1.7e9 + 9.0) is not None


def test_silence_counts_from_where_ros_time_goes_on_from() -> None:
    drive = Waiting()
    for step in range(1, 50):
        stamp_ns = 1000 * 10**9 + step * STEP_NS
        drive.pipeline.take(Measurement(stamp_ns, 120.0, 119.4, 30.0, -30.0), stamp_ns, stamp_ns)
    assert drive.pipeline.reset_after_jump(5 * 10**9)
    told = drive.wait(12.0, 5.0)
    assert told is not None
    assert told.condition is Condition.SENSOR_STALE
    assert told.stamp_ns < 20 * 10**9


def test_a_drive_pools_as_the_node_asks_until_it_no_longer_does() -> None:
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    assert states_of(pipeline, range(1, 41)) == 40
    pipeline.pool(0.1)
    assert states_of(pipeline, range(41, 81)) == 4
    pipeline.retune(load_settings(PAPER_DRIVE, {"alarm.margin_warning": 0.4}))
    assert states_of(pipeline, range(81, 121)) == 4
    pipeline.pool(0.0)
    assert states_of(pipeline, range(121, 161)) == 40
    assert pipeline.health.accepted == 160


def test_a_drive_that_asks_for_more_is_pooled_as_it_asks() -> None:
    settings = load_settings(PAPER_DRIVE, {"limits.pool_period": 0.2})
    pipeline = Pipeline("node", ("/joint_states",), settings)
    pipeline.pool(0.05)
    assert states_of(pipeline, range(1, 102)) == 6


def test_a_run_that_begins_pools_as_the_drive_asks() -> None:
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    pipeline.pool(0.1)
    pipeline.begin()
    assert states_of(pipeline, range(1, 41)) == 40


def test_a_drive_pools_over_no_more_than_half_its_greatest_gap() -> None:
    """Means farther apart than that gap would be taken for jumps of time, and be rejected."""
    settings = load_settings(PAPER_DRIVE, {"limits.greatest_gap": 0.1})
    pipeline = Pipeline("node", ("/joint_states",), settings)
    pipeline.pool(0.2)
    assert states_of(pipeline, range(1, 200)) >= 39


@pytest.mark.parametrize("pause", [0.3, 5.0, 3600.0])
def test_a_pause_in_which_nobody_listened_is_nobodys_fault(pause: float) -> None:
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))

    def run(begin: float) -> list[Outcome]:
        stamps = [round(begin * 1e9) + step * STEP_NS for step in range(100)]
        return [pipeline.take(Measurement(s, 120.0, 119.4, 30.0, -30.0), s, s) for s in stamps]

    run(10.0)
    pipeline.begin()  # it was inactive, and is active again
    after = run(11.0 + pause)
    assert [outcome.reason for outcome in after] == [Rejection.NONE] * 100
    assert not any(outcome.worsened for outcome in after)
    assert pipeline.alarm is not None
    assert pipeline.alarm.conditions == ()


@pytest.mark.parametrize("make", [sliding, calibrated])
def test_a_drives_row_is_stale_until_there_is_an_estimate_since_it_is_active(
    make: Callable[[], Pipeline],
) -> None:
    pipeline = make()
    assert pipeline.drive_status().level != DiagnosticStatus.STALE
    pipeline.begin()  # it was inactive, and is active again
    row = pipeline.drive_status()
    assert row.level == DiagnosticStatus.STALE
    assert "no usable measurement" in row.message
    assert "margin [-]" not in {value.key for value in row.values}

    stamp_ns = 1000 * STEP_NS
    pipeline.take(Measurement(stamp_ns, 120.0, 119.4, 30.0, -30.0), stamp_ns, stamp_ns)
    assert pipeline.drive_status().level != DiagnosticStatus.STALE


def test_a_pause_that_was_announced_excuses_no_later_silence() -> None:
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    pipeline.begin()
    for stamp_ns in (*range(STEP_NS, 50 * STEP_NS, STEP_NS), 10_000_000_000):
        outcome = pipeline.take(
            Measurement(stamp_ns, 120.0, 119.4, 30.0, -30.0), stamp_ns, stamp_ns
        )
    assert outcome.reason is Rejection.OUT_OF_ORDER


def went_back(pipeline: Pipeline, begin: float) -> list[bool]:
    """Whether each of some measurements from a time [s] on has made estimation begin anew."""
    stamps = [round(begin * 1e9) + step * STEP_NS for step in range(10)]
    rows = [Measurement(each, 120.0, 119.4, 30.0, -30.0) for each in stamps]
    return [pipeline.take(row, row.stamp_ns, row.stamp_ns).went_back for row in rows]


def test_stamps_that_go_back_are_told_of_once() -> None:
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    assert not any(went_back(pipeline, 100.0))
    assert went_back(pipeline, 50.0).count(True) == 1
    assert not any(went_back(pipeline, 50.1))


def test_stamps_that_go_back_are_told_of_also_where_nobody_listened_meanwhile() -> None:
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    went_back(pipeline, 100.0)
    pipeline.begin()  # it was inactive, and is active again
    assert went_back(pipeline, 50.0).count(True) == 1


def test_stamps_that_go_back_are_told_of_also_after_a_clock_that_was_corrected_a_little() -> None:
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    went_back(pipeline, 100.0)
    assert not pipeline.reset_after_jump(round(99.9e9))
    assert went_back(pipeline, 50.0).count(True) == 1


@pytest.mark.parametrize(
    "start_anew", [Pipeline.reset, Pipeline.give_up, lambda pipeline: pipeline.reset_after_jump(0)]
)
def test_what_else_starts_anew_is_not_told_to_be_stamps_that_went_back(
    start_anew: Callable[[Pipeline], object],
) -> None:
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    went_back(pipeline, 100.0)
    start_anew(pipeline)
    assert not any(went_back(pipeline, 1.0))
    assert pipeline.health.resets == 1
