"""What the drive can carry, calibration, fit and lost traction, as the monitor says them."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from runs import Run, Runner, assert_sound, scripted, within

from belt_ros.estimation import BeltMonitor, Health, Measurement
from belt_ros.estimation.estimate import Consistency
from belt_ros.estimation.fit import worst_sensor
from belt_ros.estimation.maintenance import Maintenance, MaintenanceKind
from belt_ros.estimation.traction import Loss, named_loss
from belt_ros.mechanics import torque_capacity
from belt_ros.settings import DriveSettings

TRUE = {"condition__tension": 440.0, "condition__friction_stiffness": 6e6, "sample_rate": 50.0}
LOADED = {"duration": 3.0, "seed": 1, "speed": 120.0, "load": [[0.3, 0.0], [0.8, 45.0]], **TRUE}


@pytest.fixture(scope="module")
def loaded(run: Runner, settings: DriveSettings) -> tuple[BeltMonitor, Run]:
    """A monitor that has seen three quarters of what the belt carries."""
    monitor = settings.monitor()
    return monitor, run(monitor=monitor, **LOADED)


def test_before_the_first_estimate_there_is_no_reserve(settings: DriveSettings) -> None:
    monitor = settings.monitor()
    assert monitor.gross_slip_probability_at(50.0) == 0.0
    assert math.isnan(monitor.load_at_probability(0.5))


def test_after_a_reset_there_is_none_either(run: Runner, settings: DriveSettings) -> None:
    monitor = settings.monitor()
    run(monitor=monitor, **LOADED | {"duration": 0.9})
    assert monitor.gross_slip_probability_at(1e3) == pytest.approx(1.0)
    monitor.reset()
    assert monitor.gross_slip_probability_at(1e3) == 0.0


def test_probability_rises_from_none_at_no_load_to_all_far_above(loaded) -> None:
    monitor, played = loaded
    capacity = played.outputs[-1].estimate.capacity_torque.value
    loads = np.linspace(0.0, 3.0 * capacity, 200)
    chances = np.array([monitor.gross_slip_probability_at(load) for load in loads])
    assert chances[0] == 0.0
    assert np.all(np.diff(chances) >= 0.0)
    assert chances[-1] > 0.999
    assert monitor.gross_slip_probability_at(-capacity) == monitor.gross_slip_probability_at(
        capacity
    )
    assert monitor.gross_slip_probability_at(45.0) < 0.05  # which it has been seen to carry


@hypothesis_settings(derandomize=True, deadline=None, max_examples=100)
@given(probability=st.floats(1e-6, 1.0 - 1e-6))
def test_load_at_a_probability_is_the_inverse(loaded, probability: float) -> None:
    monitor, _ = loaded
    load = monitor.load_at_probability(probability)
    assert load > 0.0
    assert monitor.gross_slip_probability_at(load) == pytest.approx(probability, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("probability", [0.0, 1.0, math.nan])
def test_an_impossible_probability_is_refused(loaded, probability: float) -> None:
    with pytest.raises(ValueError, match="between 0 and 1"):
        loaded[0].load_at_probability(probability)


def test_capacity_at_the_prior_is_that_of_the_prior(run: Runner, settings: DriveSettings) -> None:
    estimate, _ = run(**LOADED | {"duration": 0.2, "load": 0.0}).at(0.1)
    prior = settings.prior
    capacity = estimate.capacity_torque
    at_mean = float(torque_capacity(settings.drive, prior.tension, 120.0))
    assert capacity.value == pytest.approx(at_mean, rel=0.05)
    assert capacity.stddev / capacity.value == pytest.approx(
        prior.tension_stddev / prior.tension, rel=0.25
    )


def test_peak_load_is_judged_where_one_is_set(run: Runner, settings: DriveSettings, loaded) -> None:
    monitor, played = loaded
    assert played.outputs[-1].estimate.reserve.gross_slip_probability_at_peak_load == 0.0
    limits = dataclasses.replace(settings.limits, peak_load=65.0)
    peaked = dataclasses.replace(settings, limits=limits)
    judged = run(drive=peaked, **LOADED).outputs[-1].estimate.reserve
    assert judged.gross_slip_probability_at_peak_load == monitor.gross_slip_probability_at(65.0)
    assert 0.02 < judged.gross_slip_probability_at_peak_load < 0.98


def drawn(settings: DriveSettings, seed: int) -> tuple[float, float, float]:
    """Tension, mu and kf from the prior."""
    random, prior = np.random.default_rng(1000 + seed), settings.prior

    def lognormal(mean: float, stddev: float) -> float:
        variance = math.log1p((stddev / mean) ** 2)
        normal = random.standard_normal()
        return mean * math.exp(math.sqrt(variance) * normal - 0.5 * variance)

    tension = lognormal(prior.tension, prior.tension_stddev)
    mu = lognormal(prior.friction_coefficient, prior.friction_coefficient_stddev)
    decades = prior.friction_stiffness_decades * random.standard_normal()
    return tension, mu, prior.friction_stiffness * 10.0**decades


def test_the_capacity_lies_in_its_interval_as_often_as_it_says(
    run: Runner, settings: DriveSettings
) -> None:
    """40 drives from the prior at half of their load; 2 of them may be outside, 5 hardly."""
    ranks = []
    for seed in range(40):
        tension, mu, kf = drawn(settings, seed)
        monitor = settings.monitor()
        load = 0.475 * tension / settings.prior.tension * 68.0 * math.tanh(0.5 * math.pi * mu)
        played = run(
            monitor=monitor,
            duration=1.4,
            sample_rate=50.0,
            seed=seed,
            speed=120.0,
            load=[[0.2, 0.0], [0.5, load]],
            condition__tension=tension,
            condition__friction_coefficient=mu,
            condition__friction_stiffness=kf,
        )
        ranks.append(monitor.gross_slip_probability_at(played.truths[-1].capacity_torque))
    ranks = np.array(ranks)
    assert np.mean((ranks > 0.025) & (ranks < 0.975)) >= 0.9
    assert 0.2 < np.mean(ranks) < 0.8


def calibrated(settings: DriveSettings, ratio_bias: float, monitor: BeltMonitor, **scenario):
    """Calibrate from 1.5 s on; outputs by time."""
    scenario = {
        "duration": 7.5,
        "seed": 2,
        "sample_rate": 50.0,
        "speed": [[0.0, 0.0], [0.5, 120.0]],
        "condition__ratio_bias": ratio_bias,
        "condition__friction_stiffness": 6e6,
    } | scenario
    outputs = []
    for measurement, _ in scripted(settings, **scenario):
        blind = dataclasses.replace(measurement, driver_position=math.nan, driven_position=math.nan)
        outputs.append(monitor.step(blind))
        if measurement.stamp_ns == 1_500_000_000:
            assert monitor.calibrate()
    return outputs


@pytest.mark.parametrize("ratio_bias", [4e-4, -4e-4])
def test_calibration_finds_the_ratio_and_the_estimate_adopts_it(
    settings: DriveSettings, ratio_bias: float
) -> None:
    outputs = calibrated(settings, ratio_bias, settings.monitor())
    results = [(k, out.calibration) for k, out in enumerate(outputs) if out.calibration is not None]
    assert len(results) == 1
    at, result = results[0]
    assert "ratio bias is" in result.message
    assert result.samples >= 250
    assert within(result.ratio_bias, ratio_bias, 3.0)
    assert result.ratio_bias.stddev < 5e-5
    adopted = outputs[at + 1].estimate.ratio_bias
    assert adopted.stddev < 1.2 * result.ratio_bias.stddev
    assert within(adopted, ratio_bias, 3.0)
    assert within(result.driver_torque_offset, 0.0, 3.0)
    for output in outputs:
        assert_sound(output.estimate)


def test_calibration_needs_an_estimate_first(settings: DriveSettings) -> None:
    assert not settings.monitor().calibrate()


def test_a_loaded_drive_is_not_calibrated_and_nothing_is_adopted(settings: DriveSettings) -> None:
    outputs = calibrated(
        settings, 0.0, settings.monitor(), load=30.0, duration=32.0, sample_rate=20.0
    )
    results = [out.calibration for out in outputs if out.calibration is not None]
    assert len(results) == 1
    assert results[0].ratio_bias is None
    assert "the drive is loaded" in results[0].message


def test_new_noise_does_not_break_off_a_calibration(settings: DriveSettings) -> None:
    monitor = settings.monitor()
    scenario = {"duration": 7.5, "seed": 2, "sample_rate": 50.0, "speed": 120.0}
    results = []
    for k, (measurement, _) in enumerate(scripted(settings, **scenario)):
        results.append(monitor.step(measurement).calibration)
        if k == 50:
            assert monitor.calibrate()
        if k == 100:
            monitor.retune(settings.noise, settings.drift, settings.limits, settings.alarm)
    assert next(result for result in results if result is not None).ratio_bias is not None


def test_a_calibration_is_told_also_where_its_last_mean_leaves_with_the_next_measurement(
    settings: DriveSettings,
) -> None:
    """As when measurements cease to be pooled just then."""
    pooled = dataclasses.replace(settings.limits, pool_period=0.2)
    unpooled = dataclasses.replace(settings.limits, pool_period=0.0)
    scenario = {"duration": 25.0, "seed": 2, "sample_rate": 50.0, "speed": 120.0}
    measurements = [measurement for measurement, _ in scripted(settings, **scenario)]

    def told(ends_at: int) -> list[int]:
        monitor = dataclasses.replace(settings, limits=pooled).monitor()
        found = []
        for k, measurement in enumerate(measurements):
            if k == ends_at:
                monitor.retune(settings.noise, settings.drift, unpooled, settings.alarm)
            if monitor.step(measurement).calibration is not None:
                found.append(k)
            if k == 60:
                assert monitor.calibrate()
        return found

    (end,) = told(len(measurements))
    for before in (1, 3, 5):
        assert len(told(end - before)) == 1


Alter = Callable[[Measurement], Measurement]


def played_through(
    settings: DriveSettings, alter: Alter = lambda m: m, rate: float = 50.0
) -> Health:
    """Health after some seconds under changing load."""
    monitor = settings.monitor()
    load = [[0.3, 0.0], [0.8, 45.0], [2.0, 45.0], [2.2, 20.0]]
    scenario = LOADED | {"duration": 5.0, "load": load, "sample_rate": rate}
    for measurement, _ in scripted(settings, **scenario):
        monitor.step(alter(measurement))
    return monitor.health


def test_a_right_filter_is_called_consistent_and_no_sensor_blamed(settings: DriveSettings) -> None:
    health = played_through(settings)
    assert health.fit.consistency is Consistency.CONSISTENT
    assert 0.5 < health.fit.mean < 1.25
    assert worst_sensor(health.sensor_fits) is None
    named = dict(health.sensor_fits)
    for sensor in ("driver speed", "driven speed", "driver torque", "driven torque"):
        assert named[sensor].consistency is Consistency.CONSISTENT


def test_a_wrong_offset_of_a_torque_is_overconfidence(settings: DriveSettings) -> None:
    health = played_through(
        settings, lambda m: dataclasses.replace(m, driver_torque=m.driver_torque + 5.0)
    )
    assert health.fit.consistency is Consistency.OVERCONFIDENT


def test_a_speed_that_is_far_noisier_than_stated_is_named(settings: DriveSettings) -> None:
    random = np.random.default_rng(0)

    def noisy(measurement: Measurement) -> Measurement:
        driven_speed = measurement.driven_speed + 0.5 * random.standard_normal()
        return dataclasses.replace(measurement, driven_speed=driven_speed)

    limits = dataclasses.replace(settings.limits, pool_period=0.0)  # 200 Hz, each sample by itself
    health = played_through(dataclasses.replace(settings, limits=limits), noisy, 200.0)
    assert health.fit.consistency is Consistency.OVERCONFIDENT
    assert worst_sensor(health.sensor_fits)[0] == "driven speed"


def test_a_sensor_that_is_never_there_is_not_judged(settings: DriveSettings) -> None:
    def without(measurement: Measurement) -> Measurement:
        return dataclasses.replace(measurement, driver_torque=math.nan, driver_position=math.nan)

    named = dict(played_through(settings, without).sensor_fits)
    assert named["driver torque"].consistency is Consistency.UNKNOWN
    assert named["positions"].consistency is Consistency.UNKNOWN
    assert named["driven torque"].consistency is not Consistency.UNKNOWN


def test_a_drive_at_rest_says_nothing_of_the_fit(settings: DriveSettings) -> None:
    monitor = settings.monitor()
    for k in range(200):
        monitor.step(Measurement(k * 20_000_000, 0.0, 0.0, 0.0, 0.0))
    assert monitor.health.fit.consistency is Consistency.UNKNOWN
    assert all(fit.consistency is Consistency.UNKNOWN for _, fit in monitor.health.sensor_fits)


@pytest.fixture(scope="module")
def loosened(run: Runner, settings: DriveSettings) -> tuple[BeltMonitor, Run]:
    monitor = settings.monitor()
    events = [{"at": 2.0, "over": 1.0, "tension": 264.0}]
    load = [[0.3, 0.0], [0.8, 30.0]]
    scenario = LOADED | {"duration": 5.0, "seed": 0, "load": load, "events": events}
    return monitor, run(monitor=monitor, **scenario)


def test_lost_traction_is_probable_only_once_it_is_lost(loosened) -> None:
    _, played = loosened
    before, after = played.at(1.9)[0].lost_traction, played.outputs[-1].estimate.lost_traction
    assert before.traction < 0.2
    assert after.traction > 0.9
    assert 0.0 <= after.tension <= after.traction
    assert 0.0 <= after.friction <= after.traction


def test_after_maintenance_traction_is_compared_with_what_it_then_was(loosened) -> None:
    """A drive that is left at a lower tension on purpose has not lost it."""
    monitor, played = loosened
    last = played.measurements[-1]
    assert named_loss(monitor.estimate.lost_traction) is not Loss.NONE
    assert monitor.maintain(Maintenance(MaintenanceKind.RETENSIONED, 264.0, 5.0))
    output = monitor.step(dataclasses.replace(last, stamp_ns=last.stamp_ns + 20_000_000))
    assert output.estimate.lost_traction.traction < 0.1
    assert named_loss(output.estimate.lost_traction) is Loss.NONE
    assert within(output.estimate.mean_tension, 264.0, 2.0)
