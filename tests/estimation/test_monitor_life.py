"""The whole life of a drive through the monitor, against the rig's truth."""

import dataclasses
import math

import pytest
from runs import Runner, assert_sound, coverage, within

from belt_ros.estimation import (
    Condition,
    Knowledge,
    Measurement,
    Phase,
    Rejection,
    Severity,
)
from belt_ros.estimation.estimate import Consistency
from belt_ros.estimation.fit import worst_sensor
from belt_ros.mechanics import solve_equilibrium

STEADY = {"seed": 5, "sample_rate": 100.0, "speed": [[0.0, 0.0], [1.0, 120.0]]}


@pytest.fixture(scope="module")
def loaded(run: Runner):
    """Run-up, then 45 N m: three quarters of what the belt carries."""
    return run(
        duration=8.0,
        load=[[2.0, 0.0], [2.2, 45.0]],
        condition__tension=440.0,
        condition__friction_stiffness=6e6,
        condition__creep_error=0.02,
        **STEADY,
    )


def test_every_number_is_sound_from_the_first_message_at_standstill(loaded) -> None:
    for output in loaded.outputs:
        assert output.estimate is not None
        assert_sound(output.estimate)


def test_slip_torque_and_tensions_follow_the_truth(loaded) -> None:
    estimate, truth = loaded.at(7.5)
    assert estimate.phase is Phase.RUNNING
    assert estimate.slip.value == pytest.approx(truth.slip, rel=0.03)
    assert estimate.transmitted_torque.value == pytest.approx(45.0, rel=0.01)
    for name in ("tight_tension", "slack_tension", "margin", "slip", "friction_coefficient"):
        assert within(getattr(estimate, name), getattr(truth, name), 3.0), name


def test_stated_intervals_of_speeds_and_slip_hold_the_truth(loaded) -> None:
    assert coverage(loaded, "slip", 3.0) > 0.9
    assert coverage(loaded, "driver_speed", 3.0) > 0.9
    assert coverage(loaded, "transmitted_torque", 3.0) > 0.9


def test_a_compliant_drive_teaches_its_friction_stiffness(loaded) -> None:
    estimate, truth = loaded.at(7.5)
    assert estimate.friction_stiffness_knowledge is Knowledge.LEARNED
    error = math.log(estimate.friction_stiffness.value / truth.friction_stiffness)
    assert abs(error) < 3.0 * estimate.friction_stiffness_log_stddev


def test_an_unloaded_drive_teaches_nothing_and_says_so(run: Runner) -> None:
    idle = run(duration=4.0, condition__tension=440.0, **STEADY)
    estimate, _ = idle.at(3.9)
    assert estimate.tension_knowledge is Knowledge.AT_PRIOR
    assert estimate.friction_coefficient_knowledge is Knowledge.AT_PRIOR
    prior = idle.settings.prior
    assert estimate.mean_tension.stddev == pytest.approx(prior.tension_stddev, rel=0.15)


@pytest.fixture(scope="module")
def failing(run: Runner):
    """Tension falls to 60 % under load, comes back, and an overload makes the belt slip."""
    return run(
        duration=16.0,
        load=[[2.0, 0.0], [2.2, 45.0], [4.0, 45.0], [4.2, 38.0]],
        condition__tension=440.0,
        condition__friction_stiffness=6e6,
        events=[
            {"at": 5.0, "tension": 264.0, "over": 1.0},
            {"at": 9.0, "tension": 440.0, "over": 1.0},
            {"at": 12.0, "load": 70.0, "over": 0.1},
            {"at": 13.2, "load": 15.0, "over": 0.1},
        ],
        **STEADY,
    )


def alarms(run):
    return [
        ((o.alarm.stamp_ns - run.measurements[0].stamp_ns) * 1e-9, o.alarm)
        for o in run.outputs
        if o.alarm is not None
    ]


def test_lost_tension_is_found_and_warned_of_before_the_belt_slips(failing) -> None:
    estimate, truth = failing.at(8.0)
    assert estimate.margin.value == pytest.approx(truth.margin, abs=0.02)
    # A drop of mu would look much the same, so tension is not told better than its deviation says.
    assert estimate.mean_tension.value == pytest.approx(truth.mean_tension, rel=0.12)
    assert within(estimate.mean_tension, truth.mean_tension, 1.0)
    first, status = alarms(failing)[1]  # after the first, which says that all is well
    assert 5.5 < first < 6.5
    assert status.condition is Condition.LOW_MARGIN


def test_tension_that_comes_back_is_believed_again(failing) -> None:
    estimate, truth = failing.at(11.5)
    assert estimate.margin.value > 0.3
    assert truth.margin > 0.3


def test_an_overload_is_gross_slip_and_trips(failing) -> None:
    estimate, truth = failing.at(13.0)
    assert truth.slip > 0.2
    assert estimate.phase is Phase.GROSS_SLIP
    assert estimate.gross_slip_probability > 0.9
    assert estimate.slip.value == pytest.approx(truth.slip, abs=0.01)
    assert estimate.tight_tension.value == pytest.approx(truth.tight_tension, rel=0.05)
    assert max(status.severity for _, status in alarms(failing)) is Severity.TRIP


def test_after_the_overload_it_runs_on_without_alarm(failing) -> None:
    estimate, truth = failing.at(15.5)
    assert estimate.phase is Phase.RUNNING
    assert estimate.slip.value == pytest.approx(truth.slip, abs=5e-4)
    assert alarms(failing)[-1][1].severity is Severity.NORMAL
    for output in failing.outputs:
        assert_sound(output.estimate)


def test_reverse_rotation_mirrors_the_estimate(run: Runner, loaded) -> None:
    def mirrored(measurement):
        return dataclasses.replace(
            measurement,
            driver_speed=-measurement.driver_speed,
            driven_speed=-measurement.driven_speed,
            driver_torque=-measurement.driver_torque,
            driven_torque=-measurement.driven_torque,
            driver_position=-measurement.driver_position,
            driven_position=-measurement.driven_position,
        )

    monitor = loaded.settings.monitor()
    for measurement in loaded.measurements:
        output = monitor.step(mirrored(measurement))
    estimate, forward = output.estimate, loaded.outputs[-1].estimate
    assert estimate.phase is Phase.REVERSE
    assert estimate.slip.value == pytest.approx(forward.slip.value, rel=1e-6)
    assert estimate.transmitted_torque.value == pytest.approx(
        -forward.transmitted_torque.value, rel=1e-6
    )
    assert estimate.tight_tension.value == pytest.approx(forward.tight_tension.value, rel=1e-3)


def test_positions_that_contradict_the_speeds_are_left_out_and_named(loaded) -> None:
    monitor = loaded.settings.monitor()
    for measurement in loaded.measurements:
        wrong = dataclasses.replace(measurement, driven_position=-measurement.driven_position)
        output = monitor.step(wrong)
    assert output.estimate.phase is Phase.RUNNING
    assert within(output.estimate.slip, loaded.truths[-1].slip, 3.0)
    name, fit = worst_sensor(monitor.health.sensor_fits)
    assert name == "positions"
    assert fit.consistency is Consistency.OVERCONFIDENT


@pytest.mark.parametrize("missing", ["driver_speed", "driven_speed"])
def test_one_speed_may_be_missing_for_a_while(run: Runner, missing: str) -> None:
    def alter(measurement):
        gone = 3.0e9 <= measurement.stamp_ns < 4.0e9
        return dataclasses.replace(measurement, **{missing: math.nan}) if gone else measurement

    partial = run(
        alter=alter,
        duration=5.0,
        load=[[2.0, 0.0], [2.2, 40.0], [3.3, 40.0], [3.5, 20.0]],
        condition__tension=440.0,
        condition__friction_stiffness=6e6,
        **STEADY,
    )
    assert all(output.rejection is Rejection.NONE for output in partial.outputs)
    for seconds in (3.2, 3.9, 4.9):
        estimate, truth = partial.at(seconds)
        assert within(estimate.slip, truth.slip, 3.0)
        assert within(estimate.margin, truth.margin, 3.0)
        assert_sound(estimate)


def test_a_load_that_drives_is_regeneration(run: Runner) -> None:
    driven_by_load = run(
        duration=5.0,
        load=[[2.0, 0.0], [2.2, -30.0]],
        condition__tension=440.0,
        condition__friction_stiffness=6e6,
        **STEADY,
    )
    estimate, truth = driven_by_load.at(4.9)
    assert truth.slip < 0.0
    assert estimate.phase is Phase.REGENERATING
    assert estimate.slip.value == pytest.approx(truth.slip, abs=4e-4)
    assert within(estimate.tight_tension, truth.tight_tension, 3.0)


@pytest.mark.parametrize("missing", ["driver_torque", "driven_torque"])
def test_one_torque_is_enough(run: Runner, missing: str) -> None:
    partial = run(
        alter=lambda m: dataclasses.replace(m, **{missing: math.nan}),
        duration=5.0,
        load=[[2.0, 0.0], [2.2, 40.0]],
        condition__tension=440.0,
        condition__friction_stiffness=6e6,
        **STEADY,
    )
    estimate, truth = partial.at(4.9)
    assert estimate.health.degrees_of_freedom == 4  # two speeds, one torque, travel
    assert estimate.transmitted_torque.value == pytest.approx(40.0, rel=0.05)
    assert within(estimate.margin, truth.margin, 3.0)


def test_without_any_torque_it_runs_and_claims_little(run: Runner) -> None:
    blind = run(
        alter=lambda m: dataclasses.replace(m, driver_torque=math.nan, driven_torque=math.nan),
        duration=4.0,
        load=[[2.0, 0.0], [2.2, 30.0]],
        condition__tension=440.0,
        condition__friction_stiffness=6e6,
        **STEADY,
    )
    estimate, truth = blind.at(3.9)
    for output in blind.outputs:
        assert_sound(output.estimate)
    assert within(estimate.transmitted_torque, truth.transmitted_torque, 3.0)


def test_predicted_creep_is_that_of_the_equilibrium(loaded) -> None:
    estimate, truth = loaded.at(7.5)
    steady = solve_equilibrium(loaded.settings.drive, 45.0, 440.0, 120.0)
    assert estimate.predicted_creep.value == pytest.approx(truth.slip, rel=0.05)
    assert float(steady.slip) > 0.0


def test_accumulated_slip_holds_the_truth_in_its_interval(loaded) -> None:
    estimate, truth = loaded.at(7.9)
    assert within(estimate.accumulated_slip, truth.accumulated_slip)
    assert estimate.accumulated_slip.stddev < 0.1 * abs(truth.accumulated_slip)


def test_an_idle_drive_stays_at_its_prior_for_an_hour(settings) -> None:
    monitor = settings.monitor()
    for k in range(3600):
        output = monitor.step(Measurement(k * 10**9, 0.0, 0.0, 0.0, 0.0))
    prior = settings.prior
    assert output.estimate.mean_tension.stddev == pytest.approx(prior.tension_stddev, rel=0.1)
    assert output.estimate.mean_tension.value == pytest.approx(prior.tension, rel=0.05)
