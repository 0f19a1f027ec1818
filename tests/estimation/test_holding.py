"""What is held becomes less certain by as much as it seems to change."""

import math
from dataclasses import replace

import pytest
from runs import Runner

from belt_ros.estimation import BeltEstimate, Quantity
from belt_ros.estimation.holding import Pace

SECOND = 1_000_000_000


@pytest.fixture(scope="module")
def estimate(run: Runner) -> BeltEstimate:
    loaded = run(duration=2.0, speed=120.0, load=[[0.0, 0.0], [1.0, 0.0], [1.2, 20.0]])
    return loaded.outputs[-1].estimate


def test_a_speed_is_widened_by_its_pace_and_slip_by_the_wander_of_creep(
    estimate: BeltEstimate,
) -> None:
    value, stddev = estimate.driven_speed
    pace = Pace()
    pace.see(replace(estimate, driven_speed=Quantity(value - 0.2, stddev)), 0)
    pace.see(estimate, SECOND)
    held = pace.held(estimate, 0.1, creep_wander=0.01)

    assert held.driven_speed == pytest.approx((value, math.hypot(stddev, 0.02)))
    assert held.driver_speed == estimate.driver_speed
    creep = 0.01 * math.sqrt(0.1) * estimate.predicted_creep.value
    assert held.slip.stddev == pytest.approx(math.hypot(estimate.slip.stddev, creep))
    assert held.mean_tension == estimate.mean_tension


def test_two_estimates_close_to_each_other_tell_no_great_pace(estimate: BeltEstimate) -> None:
    value, stddev = estimate.driver_speed
    pace = Pace()
    pace.see(replace(estimate, driver_speed=Quantity(value - 0.01, stddev)), 0)
    pace.see(estimate, SECOND // 1000)
    held = pace.held(estimate, 0.1, creep_wander=0.0)
    assert held.driver_speed.stddev == pytest.approx(math.hypot(stddev, 0.01))
