"""What the spans of a belt take up is no slip; what slides is."""

import dataclasses
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from belt_ros.estimation import (
    BeltEstimate,
    Condition,
    Measurement,
    Quantity,
    measurement_from_joints,
)
from belt_ros.estimation.wind_up import WindUp
from belt_ros.rig import simulate
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.settings import load_settings

ROOT = Path(__file__).resolve().parents[2]
RADIUS = 0.2  # [m]
COMPLIANCE = 4e-4  # [m/N]
PERIOD = 0.01  # [s]


@pytest.fixture(scope="module")
def estimate(settings) -> BeltEstimate:
    """Any estimate, to be changed."""
    monitor = settings.monitor()
    scenario = scenario_from_mapping({"duration": 0.1, "speed": [[0.0, 0.0]]}, settings)
    for sample in simulate(settings, scenario):
        monitor.step(Measurement(sample.stamp_ns, *sample.joints.velocities))
    assert monitor.estimate is not None
    return monitor.estimate


def at(estimate: BeltEstimate, step: int, speed: float, slip: float, pull: float, deviation=0.0):
    return dataclasses.replace(
        estimate,
        stamp_ns=round(step * PERIOD * 1e9),
        driver_speed=Quantity(speed, 0.0),
        excess_slip=Quantity(slip, 1e-4),
        transmitted_torque=Quantity(pull * RADIUS, deviation * RADIUS),
    )


def follow() -> WindUp:
    return WindUp(COMPLIANCE, RADIUS, RADIUS, slowest=0.02)


@hypothesis_settings(derandomize=True, deadline=None, max_examples=50)
@given(
    st.floats(0.5, 50.0).flatmap(lambda speed: st.sampled_from([speed, -speed])),
    st.floats(-500.0, 500.0),
    st.floats(-0.3, 0.3),
)
def test_slip_is_what_is_left_when_winding_up_is_taken_off(
    estimate: BeltEstimate, speed: float, rate: float, sliding: float
) -> None:
    """Pull that grows by `rate` [N/s], and `sliding` beside it."""
    winding = COMPLIANCE * rate / (speed * RADIUS)
    wind_up = follow()
    for step in range(40):
        pull = rate * step * PERIOD
        slip = wind_up.slip(at(estimate, step, speed, winding + sliding, pull))
    assert slip.value == pytest.approx(sliding, abs=1e-9)


def test_a_pull_that_is_not_known_leaves_the_slip_uncertain(estimate: BeltEstimate) -> None:
    wind_up = follow()
    for step in range(40):
        slip = wind_up.slip(at(estimate, step, 1.0, 0.1, 100.0, deviation=20.0))
    assert slip.value == pytest.approx(0.1)
    path = 0.1 * 1.0 * RADIUS
    assert slip.stddev == pytest.approx(COMPLIANCE * 20.0 * math.sqrt(2.0) / path, rel=0.01)


@pytest.mark.parametrize("jump", [-100, 300])
def test_nothing_is_compared_across_a_jump_in_time(estimate: BeltEstimate, jump: int) -> None:
    wind_up = follow()
    for step in range(20):
        wind_up.slip(at(estimate, 100 + step, 5.0, 0.01, 100.0))
    slip = wind_up.slip(at(estimate, 120 + jump, 5.0, 0.02, 500.0))
    assert slip == Quantity(0.02, 1e-4)


def test_a_long_elastic_belt_starts_without_an_alarm_and_one_that_slips_does_not() -> None:
    conveyor = load_settings(ROOT / "config" / "conveyor_drive.yaml")
    raised = {}
    for tension in (1200.0, 60.0):
        script = {
            "duration": 3.0,
            "seed": 1,
            "speed": [[0.5, 0.0], [3.0, 3.125]],
            "load": [[0.0, 15.0]],
            "motor.bandwidth": 3.0,
            "condition.tension": tension,
        }
        monitor = conveyor.monitor()
        raised[tension] = set()
        for sample in simulate(conveyor, scenario_from_mapping(script, conveyor)):
            j = sample.joints
            read = measurement_from_joints(
                conveyor.driver,
                conveyor.driven,
                sample.stamp_ns,
                j.names,
                j.velocities,
                j.efforts,
                j.positions,
            )
            alarm = monitor.step(read).alarm
            if alarm is not None:
                raised[tension] |= {each.condition for each in alarm.conditions}
    assert raised[1200.0] == set()
    assert Condition.GROSS_SLIP in raised[60.0]


def test_a_pull_that_was_not_known_until_now_has_wound_nothing_up(estimate) -> None:
    wind_up = follow()
    wind_up.slip(at(estimate, 0, 25.0, 0.0, 0.0, deviation=400.0))
    for step in range(1, 10):
        slip = wind_up.slip(at(estimate, step, 25.0, 0.01, 700.0, deviation=1.0))
        assert slip.value == pytest.approx(0.01)


def test_another_standstill_speed_counts_at_once(settings) -> None:
    monitor = settings.monitor()
    other = dataclasses.replace(settings.limits, standstill_speed=0.7)
    monitor.retune(settings.noise, settings.drift, other, settings.alarm)
    assert monitor.alarm._wind_up.slowest == 0.7
