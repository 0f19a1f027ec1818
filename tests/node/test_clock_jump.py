"""ROS time that goes back, and what was on its way then."""

import pytest
from node_harness import PAPER_DRIVE
from pipeline_harness import STEP_NS, states_of

from belt_ros.estimation import Measurement, Rejection
from belt_ros.node.pipeline import Pipeline
from belt_ros.settings import load_settings


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
