"""One drive behind the node, without a graph."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from node_harness import PAPER_DRIVE

from belt_ros.estimation import AlarmStatus, Condition, Measurement, Rejection, Severity
from belt_ros.node import services
from belt_ros.node.pipeline import Outcome, Pipeline
from belt_ros.settings import load_settings

STEP_NS = 10_000_000


def sliding() -> Pipeline:
    """A drive whose belt has let go, which is told."""
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    for step in range(1, 200):
        driven = 119.4 if step < 100 else 60.0
        stamp_ns = step * STEP_NS
        pipeline.take(Measurement(stamp_ns, 120.0, driven, 30.0, -30.0), stamp_ns, stamp_ns)
    assert pipeline.alarm is not None
    assert pipeline.alarm.severity >= Severity.ALARM
    return pipeline


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


def test_a_calibration_is_told_to_be_lost_as_soon_as_estimation_starts_anew() -> None:
    """Also where the drive stands, and nothing more comes; with what comes, once to the log."""
    pipeline = sliding()
    assert services.calibrate(pipeline).success
    running = pipeline.calibration_status()
    assert running is not None
    assert (running.level, running.values[0].value) == (DiagnosticStatus.OK, "1")

    pipeline.reset()
    lost = pipeline.calibration_status()
    assert lost is not None
    assert (lost.level, lost.values[0].value) == (DiagnosticStatus.WARN, "0")
    assert lost.message == "ratio not calibrated: the estimate was started anew"

    told = []
    for step in range(300, 303):
        stamp_ns = step * STEP_NS
        measurement = Measurement(stamp_ns, 120.0, 119.4, 30.0, -30.0)
        told.append(pipeline.take(measurement, stamp_ns, stamp_ns).calibration)
    assert [result.message for result in told if result is not None] == [lost.message]
    assert pipeline.calibration_status() == lost


def calibrated() -> Pipeline:
    """A drive whose ratio has been calibrated, at no load."""
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    rng = np.random.default_rng(8)
    for step in range(1, 901):
        if step == 101:
            assert services.calibrate(pipeline).success
        noise = rng.normal(size=4) * (0.013, 0.013, 0.3, 0.3)
        stamp_ns = step * STEP_NS
        measurement = Measurement(stamp_ns, *(np.array([120.036, 120.0, 0.0, 0.0]) + noise))
        pipeline.take(measurement, stamp_ns, stamp_ns)
    row = pipeline.calibration_status()
    assert row is not None
    assert (row.level, row.values[0].value) == (DiagnosticStatus.OK, "0")
    return pipeline


@pytest.mark.parametrize("start_anew", [Pipeline.reset, Pipeline.give_up])
def test_a_calibration_that_a_start_at_the_priors_has_undone_is_told_to_be_lost(
    start_anew: Callable[[Pipeline], object],
) -> None:
    pipeline = calibrated()
    start_anew(pipeline)
    row = pipeline.calibration_status()
    assert row is not None
    assert row.level == DiagnosticStatus.WARN
    assert row.message == "ratio not calibrated: the estimate was started anew"
    assert "ratio bias [-]" not in {value.key for value in row.values}


def test_a_calibration_outlives_a_clock_that_goes_back() -> None:
    pipeline = calibrated()
    before = pipeline.calibration_status()
    assert pipeline.reset_after_jump(0)
    assert pipeline.calibration_status() == before


class Waiting:
    """A drive whose sensors have never said anything."""

    def __init__(self) -> None:
        self.steady = 100.0
        self.pipeline = Pipeline(
            "node", ("/joint_states",), load_settings(PAPER_DRIVE), steady=lambda: self.steady
        )

    def wait(self, seconds: float, now: float, *, stands: bool = False) -> AlarmStatus | None:
        """Watch every tenth of a second, from a ROS time on; return what was told last."""
        told = None
        for tick in range(round(10 * seconds)):
            self.steady += 0.1
            outcome = self.pipeline.watch(round((now if stands else now + 0.1 * tick) * 1e9))
            told = outcome.alarm or told
        return told


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


def states_of(pipeline: Pipeline, samples: range) -> int:
    """Take in measurements of 100 Hz; return how many estimates came of them."""
    stamps = [sample * STEP_NS for sample in samples]
    outcomes = [
        pipeline.take(Measurement(each, 120.0, 119.4, 30.0, -30.0), each, each) for each in stamps
    ]
    assert all(outcome.reason is Rejection.NONE for outcome in outcomes)
    return sum(outcome.estimate is not None for outcome in outcomes)


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


@pytest.mark.parametrize(("back", "anew"), [(0.001, False), (0.9, False), (1.1, True)])
def test_a_clock_that_is_corrected_a_little_is_no_new_run(back: float, anew: bool) -> None:
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    states_of(pipeline, range(1, 200))
    estimate_ns = 199 * STEP_NS
    assert pipeline.reset_after_jump(estimate_ns - round(back * 1e9)) is anew
    assert pipeline.health.resets == anew


class Looping:
    """A drive in simulated time that has just gone back from 100 s to 5 s."""

    def __init__(self) -> None:
        self.steady = 0.0
        self.pipeline = Pipeline(
            "node", ("/joint_states",), load_settings(PAPER_DRIVE), steady=lambda: self.steady
        )
        states_of(self.pipeline, range(9900, 10000))
        assert self.pipeline.reset_after_jump(5 * 10**9)

    def take(self, stamp: float, now: float) -> Rejection:
        measurement = Measurement(round(stamp * 1e9), 120.0, 119.4, 30.0, -30.0)
        return self.pipeline.take(measurement, measurement.stamp_ns, round(now * 1e9)).reason


def test_what_was_on_its_way_when_time_went_back_starts_nothing_anew() -> None:
    drive = Looping()
    late = [drive.take(100.0 + 0.01 * step, 5.0) for step in range(5)]
    assert late == [Rejection.OUT_OF_ORDER] * 5
    after = [drive.take(5.0 + 0.01 * step, 5.0 + 0.01 * step) for step in range(20)]
    assert after == [Rejection.NONE] * 20

    health = drive.pipeline.health
    assert health.resets == 1
    assert health.rejections[Rejection.OUT_OF_ORDER] == 5


def test_once_a_stamp_fits_the_time_that_went_back_later_ones_are_judged_as_ever() -> None:
    drive = Looping()
    assert drive.take(5.0, 5.0) is Rejection.NONE
    ahead = [drive.take(100.0 + 0.01 * step, 5.01) for step in range(3)]
    assert ahead == [Rejection.OUT_OF_ORDER, Rejection.OUT_OF_ORDER, Rejection.NONE]


def test_a_sender_whose_clock_is_ahead_for_good_is_heard_again_after_the_greatest_gap() -> None:
    drive = Looping()
    assert drive.take(100.0, 5.0) is Rejection.OUT_OF_ORDER
    drive.steady += 1.1
    assert drive.take(101.1, 6.1) is Rejection.NONE


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


def take_one(pipeline: Pipeline, seconds: float, driven: float = 119.4) -> AlarmStatus | None:
    """Take in a measurement at a time [s]; return the alarms' status if that is to be told."""
    stamp_ns = round(seconds * 1e9)
    row = Measurement(stamp_ns, 120.0, driven, 30.0, -30.0)
    return pipeline.take(row, stamp_ns, stamp_ns).alarm


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
