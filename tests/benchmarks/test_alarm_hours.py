"""A varying load, sampled slowly, is nothing to be alarmed about: some minutes of the campaign."""

import pytest

from belt_ros.estimation import Condition
from benchmarks.alarms import hours
from benchmarks.alarms.cases import Case

# Drives of which the alarm rose while a load that ramps was followed too slowly.
DRIVES = [("paper", 1), ("paper", 7)]


@pytest.mark.parametrize(("belt", "seed"), DRIVES)
def test_a_load_that_ramps_is_not_taken_for_a_faulty_sensor(belt: str, seed: int) -> None:
    (run,) = hours.run_hours(Case(belt, 2e8), seed, duration=100.0)
    raised = dict(zip(hours.CONDITIONS, run.raised, strict=True))
    assert raised[Condition.SENSOR_IMPLAUSIBLE] == 0
    assert raised[Condition.ESTIMATOR_LOST] == 0
