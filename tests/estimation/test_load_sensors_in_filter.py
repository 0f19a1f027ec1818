"""Hub loads and span tension, through the whole monitor."""

import math
from collections.abc import Iterator

import numpy as np
import pytest
from runs import Run, assert_sound, within
from sensor_runs import LOADS, SAMPLE_RATE, Alter, only, play

from belt_ros.estimation import Knowledge, Measurement
from belt_ros.estimation.state import Index
from belt_ros.estimation.traction import Loss, named_loss
from belt_ros.rig import measured
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.settings import DriveSettings

THIRD = 18.0  # N m, about 30 % of what the belt carries


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
    """Also where slip has just been taken for a load that moves, while both torques rest."""
    for seed in (0, 1, 2, 18, 33, 37, 53, 71):
        estimate = lost(settings, seed, 30.0, friction_coefficient=0.45).outputs[-1].estimate
        assert named_loss(estimate.lost_traction) is Loss.FRICTION
        assert within(estimate.friction_coefficient, 0.45, 4.0)


def test_with_a_hub_load_a_loss_of_tension_is_surely_one_of_tension(
    settings: DriveSettings,
) -> None:
    for seed in range(3):
        told = lost(settings, seed, 30.0, tension=264.0).outputs[-1].estimate.lost_traction
        assert named_loss(told) is Loss.TENSION
        assert told.tension > 0.9


def test_a_load_that_was_measured_long_ago_tells_nothing_of_a_loss(settings: DriveSettings) -> None:
    """Without it a loss of tension and one of friction look alike, as if it never had been."""
    told = {}
    for until in (-1.0, 0.03):
        run = play(
            settings,
            lambda m, until=until: only("driver_hub_load" if m.stamp_ns < until * 1e9 else "")(m),
            seed=2,
            duration=20.0,
            speed=100.0,
            load=[[0.0, 10.0], [1.0, 38.0]],
            condition__tension=440.0,
            events=[{"at": 14.0, "over": 0.5, "tension": 264.0}],
        )
        told[until] = run.outputs[-1].estimate.lost_traction
    assert told[-1.0].traction > 0.95
    assert told[0.03].friction == pytest.approx(told[-1.0].friction, abs=0.05)


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
