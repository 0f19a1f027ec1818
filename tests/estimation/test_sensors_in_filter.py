"""Hub loads, span tension, positions and missing sensors, through the whole monitor."""

import dataclasses
import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from runs import Run, assert_sound, within

from belt_ros.estimation import Knowledge, Measurement, Rejection
from belt_ros.estimation.load import Activity
from belt_ros.estimation.process import CREEP_ERROR, drift_processes, drift_wander, prior_state
from belt_ros.estimation.state import Index
from belt_ros.estimation.traction import Loss, named_loss
from belt_ros.mechanics.constants import drive_constants
from belt_ros.rig import measured
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.settings import DriveSettings

LOADS = ("driver_hub_load", "driven_hub_load", "span_tension")
POSITIONS = {"driver_position": math.nan, "driven_position": math.nan}
SAMPLE_RATE = 50.0
THIRD = 18.0  # N m, about 30 % of what the belt carries
Alter = Callable[[Measurement], Measurement]


def only(*names: str, gain: float = 1.0) -> Alter:
    """Keep some of the load sensors, with an error of their gain."""

    def alter(measurement: Measurement) -> Measurement:
        loads = {n: gain * getattr(measurement, n) if n in names else math.nan for n in LOADS}
        return dataclasses.replace(measurement, **loads)

    return alter


def play(settings: DriveSettings, alter: Alter, **scenario: object) -> Run:
    named = {name.replace("__", "."): value for name, value in scenario.items()}
    named = {"sample_rate": SAMPLE_RATE, "condition.friction_stiffness": 6e6} | named
    monitor = settings.monitor()
    pairs = [
        (alter(measurement), truth)
        for measurement, truth in measured(
            settings, scenario_from_mapping(named, settings), loads=True
        )
    ]
    outputs = [monitor.step(measurement) for measurement, _ in pairs]
    return Run(settings, [m for m, _ in pairs], [truth for _, truth in pairs], outputs)


def drawn_tension(settings: DriveSettings, seed: int) -> float:
    prior = settings.prior
    spread = prior.tension_stddev / prior.tension
    return prior.tension * math.exp(spread * np.random.default_rng(seed).standard_normal())


def drawn(
    settings: DriveSettings, alter: Alter, seeds: range, load: float = THIRD, **scenario: object
) -> Iterator[Run]:
    """Belts of tensions drawn from the prior, under little load."""
    scenario = {"duration": 2.2, "speed": 120.0, "load_direction": "fixed"} | scenario
    for seed in seeds:
        yield play(
            settings,
            alter,
            seed=seed,
            load=[[0.5, 0.0], [0.7, load]],
            condition__tension=drawn_tension(settings, seed),
            **scenario,
        )


def errors(runs: Iterator[Run]) -> np.ndarray:
    """Errors of the mean tension at the end over their stated deviations; all are learned."""
    out = []
    for run in runs:
        estimate, truth = run.outputs[-1].estimate, run.truths[-1]
        assert estimate.tension_knowledge is Knowledge.LEARNED
        assert_sound(estimate)
        tension = estimate.mean_tension
        out.append((tension.value - truth.mean_tension) / tension.stddev)
    return np.array(out)


def test_little_load_alone_does_not_teach_the_tension(settings: DriveSettings) -> None:
    for run in drawn(settings, only(), range(2)):
        assert run.outputs[-1].estimate.tension_knowledge is Knowledge.AT_PRIOR


def test_a_hub_load_settles_the_tension(settings: DriveSettings) -> None:
    off = errors(drawn(settings, only("driver_hub_load"), range(20)))
    assert np.mean(np.abs(off) < 1.96) >= 0.9
    assert 0.3 < np.sqrt(np.mean(off**2)) < 1.3


@pytest.mark.parametrize("load", [THIRD, -THIRD])
@pytest.mark.parametrize("speed", [120.0, -120.0])
def test_a_span_tension_settles_it_whichever_span_is_the_tight_one(
    settings: DriveSettings, load: float, speed: float
) -> None:
    off = errors(drawn(settings, only("span_tension"), range(5), load, speed=speed))
    assert np.max(np.abs(off)) < 2.5
    assert np.sqrt(np.mean(off**2)) < 1.5


def test_all_load_sensors_together_agree(settings: DriveSettings) -> None:
    off = errors(drawn(settings, only(*LOADS), range(5)))
    assert np.max(np.abs(off)) < 2.5


@pytest.mark.parametrize("gain", [0.99, 1.01])
def test_a_load_cells_gain_error_does_not_average_out(settings: DriveSettings, gain: float) -> None:
    """What the sensor is stated to be uncertain by is all gain; it is not claimed to go away.

    Between readings, a second apart, the tension may change; so a while of them is judged.
    """
    sensor = only("driver_hub_load", gain=gain)
    runs = drawn(settings, sensor, range(1), duration=60.0, sensors__load_relative=0.0)
    for run in runs:
        tensions = [output.estimate.mean_tension for output in run.outputs[-500:]]
        assert 0.007 < np.median([t.stddev / t.value for t in tensions]) < 0.013
        for tension, truth in zip(tensions, run.truths[-500:], strict=True):
            assert abs(tension.value - truth.mean_tension) < 2.5 * tension.stddev


def test_a_sensor_that_comes_late_is_believed_from_then_on(settings: DriveSettings) -> None:
    sensor, none = only("driver_hub_load"), only()

    def alter(measurement: Measurement) -> Measurement:
        return (sensor if measurement.stamp_ns > 1.5e9 else none)(measurement)

    for run in drawn(settings, alter, range(2)):
        assert run.at(1.4)[0].tension_knowledge is Knowledge.AT_PRIOR
        estimate, truth = run.at(1.6)
        assert estimate.tension_knowledge is Knowledge.LEARNED
        assert within(estimate.mean_tension, truth.mean_tension, 3.0)


def lost(settings: DriveSettings, seed: int, load: float, **to: float) -> Run:
    return play(
        settings,
        only("driver_hub_load"),
        seed=seed,
        duration=8.0,
        speed=120.0,
        load=[[0.5, 0.0], [0.7, load]],
        condition__tension=440.0,
        events=[{"at": 4.0, "over": 1.0, **to}],
    )


def test_with_a_hub_load_a_loss_of_tension_is_found_and_mu_is_not_blamed(
    settings: DriveSettings,
) -> None:
    truth, deviations = 264.0, []
    for seed in range(3):
        estimate = lost(settings, seed, 30.0, tension=truth).outputs[-1].estimate
        assert within(estimate.mean_tension, truth, 3.0)
        assert within(estimate.friction_coefficient, 1.2, 2.5)
        deviations.append(estimate.mean_tension.stddev)
    assert np.sqrt(np.mean(np.square(deviations))) < 0.011 * truth


@pytest.mark.parametrize("seed", range(3))
def test_with_a_hub_load_a_loss_of_friction_is_not_blamed_on_the_tension(
    settings: DriveSettings, seed: int
) -> None:
    run = lost(settings, seed, 45.0, friction_coefficient=0.72)
    for output, truth in zip(run.outputs[200:], run.truths[200:], strict=True):
        assert within(output.estimate.mean_tension, truth.mean_tension, 3.0)
    estimate, truth = run.outputs[-1].estimate, run.truths[-1]
    assert within(estimate.friction_coefficient, 0.72, 3.0)
    assert estimate.friction_coefficient.stddev < 0.05
    assert within(estimate.margin, truth.margin, 3.0)


def test_with_a_hub_load_oil_on_the_pulley_is_called_a_loss_of_friction(
    settings: DriveSettings,
) -> None:
    names = []
    for seed in range(3):
        estimate = lost(settings, seed, 30.0, friction_coefficient=0.45).outputs[-1].estimate
        names.append(named_loss(estimate.lost_traction))
    assert names == [Loss.FRICTION] * 3


def test_with_a_hub_load_a_loss_of_tension_is_surely_one_of_tension(
    settings: DriveSettings,
) -> None:
    for seed in range(3):
        told = lost(settings, seed, 30.0, tension=264.0).outputs[-1].estimate.lost_traction
        assert named_loss(told) is Loss.TENSION
        assert told.tension > 0.9


def test_in_a_change_of_traction_members_stand_side_by_side_along_mu(
    settings: DriveSettings,
) -> None:
    """Tension and mu are then open along a curve, which no single Gaussian follows."""
    monitor = settings.monitor()
    scenario = {
        "duration": 6.0,
        "sample_rate": SAMPLE_RATE,
        "seed": 0,
        "speed": 120.0,
        "load": [[0.5, 0.0], [0.7, 38.0]],
        "condition.tension": 440.0,
        "condition.friction_stiffness": 6e6,
        "events": [{"at": 4.0, "over": 1.0, "tension": 300.0}],
    }
    most, widest = 0.0, 0.0
    place = Index.LOG_FRICTION
    for measurement, _ in measured(settings, scenario_from_mapping(scenario, settings)):
        monitor.step(measurement)
        members = monitor._filter.belief()
        weights = np.exp([member.log_weight for member in members])
        weights /= weights.sum()
        logs = np.array([member.mean[place] for member in members])
        apart = math.sqrt(weights @ (logs - weights @ logs) ** 2)
        if apart > most:
            most = apart
            widest = max(
                math.sqrt(member.covariance[place, place])
                for member, weight in zip(members, weights, strict=True)
                if weight > 0.05
            )
        assert len(members) < 100
    assert most > 0.1
    assert widest < 0.3


def rounded_to(settings: DriveSettings, quantum: float) -> DriveSettings:
    """Coarse speeds and fine positions."""
    noise = dataclasses.replace(settings.noise, speed_quantum=quantum, position_absolute=2e-5)
    return dataclasses.replace(settings, noise=noise)


SLOW = {
    "slow": 3.0,
    "dwell": [[0.0, 3.0], [1.5, 3.0], [1.7, 0.0], [3.0, 0.0], [3.2, 3.0]],
    "reversal": [[0.0, 3.0], [1.5, 3.0], [1.9, -3.0], [3.0, -3.0], [3.4, 3.0]],
}


@pytest.fixture(scope="module", params=list(SLOW))
def pairs(settings: DriveSettings, request: pytest.FixtureRequest) -> list[tuple[Run, Run]]:
    """Runs with coarse speeds, with and without fine positions."""
    coarse = rounded_to(settings, 0.5)

    def without(measurement: Measurement) -> Measurement:
        return dataclasses.replace(only()(measurement), **POSITIONS)

    scenario = {
        "duration": 4.6,
        "speed": SLOW[request.param],
        "load": [[0.5, 0.0], [0.7, 20.0]],
        "load_direction": "fixed",
        "condition__tension": 440.0,
    }
    return [
        (
            play(coarse, only(), seed=seed, **scenario),
            play(coarse, without, seed=seed, **scenario),
        )
        for seed in range(2)
    ]


def lost_travel_errors(run: Run) -> np.ndarray:
    return np.array(
        [
            output.estimate.accumulated_slip.value - truth.accumulated_slip
            for output, truth in zip(run.outputs, run.truths, strict=True)
        ]
    )


def test_positions_count_the_lost_travel_where_speeds_are_coarse(pairs) -> None:
    with_positions, without = (
        np.sqrt(np.mean([lost_travel_errors(pair[which]) ** 2 for pair in pairs]))
        for which in range(2)
    )
    assert with_positions < 0.4 * without
    assert with_positions < 1e-4  # [m], of 3 to 5 mm


def test_positions_teach_kf_where_speeds_are_too_coarse_to(pairs) -> None:
    for run, blind in pairs:
        estimate, truth = run.outputs[-1].estimate, run.truths[-1]
        other = blind.outputs[-1].estimate
        assert estimate.friction_stiffness_log_stddev < 0.8 * other.friction_stiffness_log_stddev
        off = math.log(estimate.friction_stiffness.value / truth.friction_stiffness)
        assert abs(off) < 2.5 * estimate.friction_stiffness_log_stddev


def test_with_positions_every_number_is_sound(pairs) -> None:
    for run, _ in pairs:
        for output in run.outputs:
            assert output.rejection is Rejection.NONE
            assert_sound(output.estimate)


@pytest.fixture(scope="module")
def fast(settings: DriveSettings) -> dict[str, object]:
    return {
        "duration": 3.0,
        "seed": 4,
        "speed": [[0.0, 0.0], [0.5, 120.0]],
        "load": [[1.0, 0.0], [1.2, 30.0]],
    }


def test_encoders_that_wrap_say_the_same(settings: DriveSettings, fast) -> None:
    def wrapping(measurement: Measurement) -> Measurement:
        wrapped = [math.remainder(position, 2.0 * math.pi) for position in measurement.positions]
        return dataclasses.replace(
            only()(measurement), driver_position=wrapped[0], driven_position=wrapped[1]
        )

    counting, wrapped = play(settings, only(), **fast), play(settings, wrapping, **fast)
    assert abs(wrapped.measurements[-1].driver_position) <= math.pi
    assert abs(counting.measurements[-1].driver_position) > 100.0
    for name in ("slip", "accumulated_slip", "mean_tension", "friction_stiffness"):
        here = getattr(wrapped.outputs[-1].estimate, name)
        assert here == pytest.approx(getattr(counting.outputs[-1].estimate, name), rel=1e-6)


def test_a_gap_of_positions_starts_the_count_anew(settings: DriveSettings, fast) -> None:
    """In which an encoder has been reset as well."""

    def alter(measurement: Measurement) -> Measurement:
        measurement = only()(measurement)
        if 1.5e9 < measurement.stamp_ns < 1.7e9:
            return dataclasses.replace(measurement, **POSITIONS)
        if measurement.stamp_ns >= 1.7e9:
            return dataclasses.replace(
                measurement, driven_position=measurement.driven_position + 40.0
            )
        return measurement

    run, whole = play(settings, alter, **fast), play(settings, only(), **fast)
    for seconds in (1.6, 1.7, 1.72, 2.0, 2.9):
        estimate, truth = run.at(seconds)
        assert within(estimate.slip, truth.slip, 3.0)
        assert_sound(estimate)
    fitted = dict(settings.monitor().health.sensor_fits)
    assert "positions" in fitted
    here, there = run.outputs[-1].estimate, whole.outputs[-1].estimate
    assert here.friction_stiffness.value == pytest.approx(there.friction_stiffness.value, rel=0.1)


def without_speed(missing: str) -> Alter:
    """Leave a speed out for a second, and positions always."""

    def alter(measurement: Measurement) -> Measurement:
        measurement = dataclasses.replace(only()(measurement), **POSITIONS)
        gone = 1.0e9 <= measurement.stamp_ns < 2.0e9
        return dataclasses.replace(measurement, **{missing: math.nan}) if gone else measurement

    return alter


@pytest.mark.parametrize("missing", ["driver_speed", "driven_speed"])
@pytest.mark.parametrize("seed", range(3))
def test_a_speed_that_is_missing_is_told_from_the_other(
    settings: DriveSettings, missing: str, seed: int
) -> None:
    run = play(
        settings,
        without_speed(missing),
        seed=seed,
        duration=2.6,
        speed=120.0,
        load=[[0.3, 0.0], [0.5, 30.0], [1.4, 30.0], [1.5, 15.0]],
        condition__tension=440.0,
    )
    for seconds in (1.1, 1.3, 1.7, 1.98, 2.1, 2.5):
        estimate, truth = run.at(seconds)
        for name in (missing, "slip", "transmitted_torque", "margin"):
            assert within(getattr(estimate, name), getattr(truth, name), 3.5), (seconds, name)
    with_both, alone = run.at(0.98)[0], run.at(1.3)[0]
    assert getattr(alone, missing).stddev > 1.2 * getattr(with_both, missing).stddev


@pytest.mark.parametrize(("missing", "rate"), [("driver_speed", 100.0), ("driven_speed", 50.0)])
def test_it_is_also_while_the_drive_slows_down(
    settings: DriveSettings, missing: str, rate: float
) -> None:
    run = play(
        settings,
        without_speed(missing),
        seed=1,
        sample_rate=rate,
        duration=2.0,
        speed=[[1.2, 120.0], [1.5, 80.0]],
        load=[[0.3, 0.0], [0.5, 30.0]],
        condition__tension=440.0,
    )
    begun = round(1.2 * rate)
    for output, truth in zip(run.outputs[begun:], run.truths[begun:], strict=True):
        estimate = output.estimate
        assert output.rejection is Rejection.NONE
        assert getattr(estimate, missing).value == pytest.approx(getattr(truth, missing), rel=0.005)
        torque = estimate.transmitted_torque.value
        assert torque == pytest.approx(truth.transmitted_torque, abs=2.0)
        assert_sound(estimate)


def creep_memory(settings: DriveSettings, changed: float, dt: float) -> tuple[float, float]:
    """Share of the creep's error that is kept in a step, and the variance that is added."""
    c = drive_constants(settings.drive)
    _, spread = prior_state(settings.prior, settings.drive)
    wander = drift_wander(settings.drift, spread, settings.prior.tension)
    calm = Activity(np.zeros(2), np.zeros(2))
    process, _ = drift_processes(wander, c, calm, (0.01, 0.0, changed), dt, dt)
    gained = process.covariance_before[CREEP_ERROR, CREEP_ERROR]
    return float(process.memory[CREEP_ERROR]), float(gained)


def test_the_creeps_error_becomes_another_as_the_load_changes(settings: DriveSettings) -> None:
    drift, spread = settings.drift, settings.prior.creep_error_stddev
    far = drift.creep_error_load * settings.prior.tension
    steady, _ = creep_memory(settings, 0.0, 0.01)
    assert steady == pytest.approx(math.exp(-0.01 / drift.creep_error_time), rel=1e-12)
    moved, added = creep_memory(settings, far, 1e-9)
    assert moved == pytest.approx(math.exp(-1.0), rel=1e-6)
    assert added == pytest.approx((1.0 - math.exp(-2.0)) * spread**2, rel=1e-6)


def test_it_does_not_matter_in_how_many_steps_the_load_changes(settings: DriveSettings) -> None:
    whole, added = creep_memory(settings, 500.0, 0.2)
    half, part = creep_memory(settings, 250.0, 0.1)
    assert half**2 == pytest.approx(whole, rel=1e-12)
    assert half**2 * part + part == pytest.approx(added, rel=1e-12)
