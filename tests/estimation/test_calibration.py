"""Calibration of the radius ratio at no load, on made-up measurements and on the rig's."""

import dataclasses
import math
import re
from typing import Any

import numpy as np
import pytest
from runs import scripted

from belt_ros.estimation import BeltEstimate, Health, Measurement, Quantity, Rejection, SensorNoise
from belt_ros.estimation.calibration import Calibration, CalibrationResult, with_ratio_bias
from belt_ros.estimation.estimate import Knowledge, Phase
from belt_ros.estimation.gaussian_sum import Component
from belt_ros.estimation.state import STATES, Index
from belt_ros.mechanics import Belt, BeltDrive, Pulley
from belt_ros.settings import DriveSettings

DRIVE = BeltDrive(Belt(80e3, 0.1), Pulley(0.12, 3.3, 0.8, 1e7), Pulley(0.08, 2.9, 0.8, 1e7), 0.5)
NOISE = SensorNoise(speed_relative=1e-4, speed_absolute=2e-3, torque_absolute=0.2)
PERIOD = 0.01


NEXT_TO_NONE = Quantity(1e-6, 2e-6)


def estimate(creep: Quantity = NEXT_TO_NONE, torque: float = 0.1) -> BeltEstimate:
    values: dict[str, Any] = {
        field.name: Quantity(1.0, 0.1) if "Quantity" in str(field.type) else 0.0
        for field in dataclasses.fields(BeltEstimate)
        if field.default is dataclasses.MISSING
    }
    return BeltEstimate(
        **values
        | {
            "stamp_ns": 0,
            "phase": Phase.RUNNING,
            "predicted_creep": creep,
            "transmitted_torque": Quantity(torque, 0.01),
            "tension_knowledge": Knowledge.AT_PRIOR,
            "health": Health(0.0, 0, 0, 0, Rejection.NONE, (0,) * len(Rejection)),
        }
    )


UNLOADED = estimate()
LOADED = estimate(Quantity(5e-4, 1e-5), 12.0)


class Bench:
    """Measurements of a drive whose R1/R2 is wrong by `bias`, taken in one by one."""

    def __init__(self, bias: float = 1.5e-4, seed: int = 0, noise: SensorNoise = NOISE) -> None:
        self.calibration = Calibration(DRIVE, noise)
        self.bias = bias
        self.offsets = (math.nan, math.nan)
        self._random = np.random.default_rng(seed)
        self._noise = noise
        self._stamp = 10**18
        self.calibration.begin(self._stamp)

    def run(
        self,
        seconds: float,
        speed: float = 100.0,
        creep: float = 0.0,
        now: BeltEstimate = UNLOADED,
        scatter: float = 1.0,
    ) -> CalibrationResult | None:
        driven = speed * 0.08 / (0.12 * (1.0 + self.bias)) * (1.0 - creep)
        for _ in range(round(seconds / PERIOD)):
            self._stamp += round(PERIOD * 1e9)
            noise = self._random.standard_normal(4).tolist()
            errors = [
                scatter * e * math.hypot(self._noise.speed_relative * s, self._noise.speed_absolute)
                for e, s in zip(noise, (speed, driven), strict=False)
            ]
            torques = [offset + 0.2 * e for offset, e in zip(self.offsets, noise[2:], strict=True)]
            result = self.calibration.take(
                Measurement(self._stamp, speed + errors[0], driven + errors[1], *torques), now
            )
            if result is not None:
                return result
        return None

    def gap(self, seconds: float) -> None:
        self._stamp += round(seconds * 1e9)


def done(result: CalibrationResult | None) -> Quantity:
    assert result is not None
    assert result.ratio_bias is not None, result.message
    return result.ratio_bias


def refused(result: CalibrationResult | None) -> str:
    assert result is not None
    assert result.ratio_bias is None
    return result.message


def test_its_interval_holds_the_true_ratio() -> None:
    found = [done(Bench(seed=seed).run(20.0)) for seed in range(150)]
    assert np.mean([abs(b.value - 1.5e-4) <= 1.96 * b.stddev for b in found]) >= 0.92
    driver, driven = math.hypot(1e-4, 2e-5), math.hypot(1e-4, 2e-3 * 0.12 / (0.08 * 100.0))
    ideal = math.hypot(driver, driven) / math.sqrt(5.0 / PERIOD)
    assert ideal < np.mean([b.stddev for b in found]) < 1.4 * ideal


@pytest.mark.parametrize("speed", [100.0, -100.0])
def test_creep_of_a_pull_that_is_left_is_taken_off_and_counts_as_uncertain(speed: float) -> None:
    bench = Bench()
    bias = done(bench.run(20.0, speed, 2e-5, estimate(Quantity(2e-5, 1e-6), 0.5)))
    assert bias.value == pytest.approx(1.5e-4, abs=2e-5)
    assert 2e-5 < bias.stddev < 2.5e-5


def test_correlated_noise_is_not_averaged_as_if_it_were_not() -> None:
    random = np.random.default_rng(1)
    inside = []
    for _ in range(150):
        bench, value, result = Bench(), 0.0, None
        stamp = 10**18
        while result is None:
            value = 0.95 * value + math.sqrt(1.0 - 0.95**2) * float(random.standard_normal())
            stamp += 10_000_000
            speeds = 100.0 * (1.0 + 1e-4 * value), 100.0 * 0.08 / (0.12 * (1.0 + 1.5e-4))
            result = bench.calibration.take(Measurement(stamp, *speeds), UNLOADED)
        bias = done(result)
        inside.append(abs(bias.value - 1.5e-4) <= 1.96 * bias.stddev)
    assert np.mean(inside) >= 0.88  # ten batches know their scatter to a quarter


def test_noise_that_does_not_show_does_not_average_out() -> None:
    noise = SensorNoise(speed_relative=0.0, speed_absolute=1e-9, speed_quantum=5e-3)
    bias = done(Bench(noise=noise).run(20.0))
    stated = 5e-3 / math.sqrt(12.0) * math.hypot(1.0 / 100.0, 0.12 / (0.08 * 100.0))
    assert bias.stddev >= stated


def test_torque_offsets_are_what_is_read_at_no_load() -> None:
    bench = Bench()
    bench.offsets = (0.7, math.nan)
    result = bench.run(20.0)
    assert result is not None
    assert result.driven_torque_offset is None
    assert result.driver_torque_offset is not None
    value, stddev = result.driver_torque_offset
    assert abs(value - 0.7) < 3.0 * stddev
    assert stddev < 0.03
    assert f"driver torque at no load {value:.2g} +/- {stddev:.2g} N m" in result.message


def test_an_earlier_load_must_have_left_the_belt() -> None:
    bench = Bench()
    assert bench.run(2.0, creep=5e-4, now=LOADED) is None
    # its creep stays on the arcs for a while, unseen by the estimate's steady creep
    assert bench.run(0.1, creep=5e-4) is None
    assert bench.calibration.progress == 0.0
    assert done(bench.run(20.0)).value == pytest.approx(1.5e-4, abs=2e-5)


def test_a_load_in_between_is_left_out() -> None:
    bench = Bench()
    bench.run(3.0)
    before = bench.calibration.progress
    assert 0.4 < before < 0.6
    bench.run(2.0, creep=5e-4, now=LOADED)
    assert bench.calibration.progress == before
    assert done(bench.run(10.0)).value == pytest.approx(1.5e-4, abs=2e-5)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"speed": 0.5}, r"the drive stands \(rim speed 0\.04 m/s, at least 0\.1 m/s\)"),
        (
            {"now": LOADED},
            r"loaded: 12 N m, under which the belt creeps by 0\.0005 .*most 2\.5e-05",
        ),
        ({"now": estimate(Quantity(0.0, 1e-3))}, r"creeps by 0 \+/- 0\.001"),
        ({"now": estimate(Quantity(math.nan, math.nan))}, "loaded"),
        ({"speed": math.nan}, "a speed is not measured"),
    ],
)
def test_it_is_given_up_with_the_reason(changes: dict[str, Any], reason: str) -> None:
    bench = Bench()
    message = refused(bench.run(40.0, **changes))
    assert re.search(reason, message), message
    assert "0 s of 5 s could be used in 30 s" in message
    assert not bench.calibration.running
    assert bench.run(1.0) is None


def test_silence_is_given_up_by_who_owns_the_clock() -> None:
    assert "no measurement came" in refused(Bench().calibration.give_up())


def test_too_little_accuracy_is_refused() -> None:
    message = refused(Bench(noise=SensorNoise(speed_absolute=0.5)).run(40.0, speed=20.0))
    assert "turn faster" in message


def test_it_goes_on_until_it_is_accurate() -> None:
    bench = Bench(noise=SensorNoise(speed_relative=1e-4, speed_absolute=0.08))
    assert bench.run(5.5) is None  # not yet
    assert done(bench.run(24.0)).stddev <= 5e-5


@pytest.mark.parametrize("quantum", [0.0, 0.05])
def test_means_of_fast_input_count_as_what_they_are(quantum: float) -> None:
    """As they come of 1 kHz; what rounding hides does not average out."""
    noise = SensorNoise(speed_relative=1e-4, speed_absolute=2e-3, speed_quantum=quantum)
    bench, random, result = Bench(noise=noise), np.random.default_rng(3), None
    for step in range(1, 3100):
        driver, driven = (
            s * (1.0 if quantum else 1.0 + 1e-4 / math.sqrt(10.0) * e)
            for s, e in zip((100.0, 66.66), random.standard_normal(2), strict=True)
        )
        pooled = Measurement(10**18 + step * 10**7, driver, driven, samples=(10.0,) * 9)
        result = result or bench.calibration.take(pooled, UNLOADED)
    assert result is not None
    assert (result.ratio_bias is None) == bool(quantum), result.message


def test_too_few_samples_are_refused() -> None:
    bench = Bench()
    result = None
    for _ in range(50):
        bench.gap(0.7)
        result = result or bench.run(0.01)
    assert "at least 50 are needed" in refused(result)


def test_gaps_are_not_averaging() -> None:
    bench = Bench()
    bench.run(1.0)
    before = bench.calibration.progress
    bench.gap(4.0)
    bench.run(0.05)
    assert bench.calibration.progress == before


def test_it_can_begin_again() -> None:
    bench = Bench()
    refused(bench.run(40.0, now=LOADED))
    bench.calibration.begin(10**18 + round(30e9))
    assert bench.calibration.running
    done(bench.run(20.0))


class TestTakingItOver:
    """What a filter believes of the ratio bias is replaced; the rest follows it."""

    BIAS = Quantity(1e-4, 1e-5)

    def member(self, deviation: float = 1e-4, correlation: float = 0.9) -> Component:
        deviations = np.ones(STATES)
        deviations[Index.RATIO_BIAS] = deviation
        correlations = np.eye(STATES)
        pair = [Index.RATIO_BIAS, Index.LOG_STIFFNESS]
        correlations[pair, pair[::-1]] = correlation
        covariance = correlations * np.outer(deviations, deviations)
        return Component(-1.5, np.zeros(STATES), covariance, changing=True)

    def test_the_bias_is_the_calibrated_one(self) -> None:
        for member in (self.member(), self.member(1e-6), self.member(1.0, 0.0)):
            (after,) = with_ratio_bias([member], self.BIAS)
            assert after.mean[Index.RATIO_BIAS] == pytest.approx(self.BIAS.value)
            variance = after.covariance[Index.RATIO_BIAS, Index.RATIO_BIAS]
            assert variance == pytest.approx(self.BIAS.stddev**2)
            assert (after.log_weight, after.changing) == (-1.5, True)
            assert np.all(np.linalg.eigvalsh(after.covariance) > 0.0)
            np.testing.assert_array_equal(after.covariance, after.covariance.T)

    def test_what_was_learned_with_a_wrong_ratio_follows_it(self) -> None:
        (after,) = with_ratio_bias([self.member()], self.BIAS)
        assert after.mean[Index.LOG_STIFFNESS] == pytest.approx(0.9)
        variance = after.covariance[Index.LOG_STIFFNESS, Index.LOG_STIFFNESS]
        assert variance == pytest.approx(1.0 - 0.81 + 0.81 * 0.01)

    def test_samples_do_not_count_twice(self) -> None:
        (once,) = with_ratio_bias([self.member()], self.BIAS)
        (twice,) = with_ratio_bias([once], self.BIAS)
        np.testing.assert_allclose(twice.mean, once.mean, rtol=1e-12)
        np.testing.assert_allclose(twice.covariance, once.covariance, rtol=1e-12)

    def test_a_bias_that_was_far_off_takes_nothing_along(self) -> None:
        (after,) = with_ratio_bias([self.member(1e-6)], self.BIAS)
        assert after.mean[Index.LOG_STIFFNESS] == 0.0
        assert after.covariance[Index.LOG_STIFFNESS, Index.LOG_STIFFNESS] == 1.0
        assert after.covariance[Index.LOG_STIFFNESS, Index.RATIO_BIAS] == 0.0


@pytest.mark.parametrize("seed", [1, 2])
def test_the_rigs_ratio_is_found(settings: DriveSettings, seed: int) -> None:
    monitor = settings.monitor()
    calibration = Calibration(settings.drive, settings.noise)
    calibration.begin(0)
    result = None
    for measurement, _ in scripted(
        settings,
        seed=seed,
        duration=14.0,
        speed=[[0.0, 0.0], [2.0, 120.0]],
        condition__ratio_bias=3e-4,
    ):
        now = monitor.step(measurement).estimate
        assert now is not None
        result = calibration.take(measurement, now) or result
    bias = done(result)
    assert abs(bias.value - 3e-4) < 3.0 * bias.stddev
    assert bias.stddev < 3e-5


IN_TURNS = [("driver_speed", "driver_torque"), ("driven_speed", "driven_torque")]
LOAD = [("driver_hub_load",)]
WHOLE = [(*IN_TURNS[0], *IN_TURNS[1])]


@pytest.mark.parametrize(
    "turns", [IN_TURNS, WHOLE * 49 + LOAD, [*IN_TURNS, *LOAD], [*IN_TURNS * 5, IN_TURNS[0]]]
)
def test_it_is_found_where_sensors_speak_in_turns(settings: DriveSettings, turns) -> None:
    """Also while the drive slowly gets faster."""
    monitor = settings.monitor()
    rates = {"duration": 40.0, "sample_rate": 100.0, "seed": 1, "load": 0.0}
    speed = [[0.0, 100.0], [40.0, 110.0]]
    result = None
    run = scripted(settings, speed=speed, condition__ratio_bias=3e-4, **rates)
    for k, (measurement, _) in enumerate(run):
        said = {name: getattr(measurement, name) for name in turns[k % len(turns)]}
        if "driver_hub_load" in said:
            said["driver_hub_load"] = 2.0 * settings.prior.tension
        output = monitor.step(Measurement(measurement.stamp_ns, **said))
        result = result or output.calibration
        if k == 200:
            assert monitor.calibrate()
    assert result is not None
    assert result.ratio_bias is not None, result.message
    assert abs(result.ratio_bias.value - 3e-4) < 3.0 * result.ratio_bias.stddev
    assert result.ratio_bias.stddev <= 5e-5


def test_a_calibration_goes_by_the_noise_that_was_told_last(settings: DriveSettings) -> None:
    """Also where that was told while another one ran."""
    noisy = dataclasses.replace(settings.noise, speed_absolute=0.05)
    found = []
    for told in (settings.noise, noisy):
        monitor, results = settings.monitor(), []
        idle = {"duration": 70.0, "sample_rate": 50.0, "seed": 1, "speed": 100.0, "load": 0.0}
        for k, (measurement, _) in enumerate(scripted(settings, **idle)):
            result = monitor.step(measurement).calibration
            results += [] if result is None else [result]
            if k == 50 or (result is not None and len(results) == 1):
                assert monitor.calibrate()
            if k == 60:
                monitor.retune(told, settings.drift, settings.limits, settings.alarm)
        found.append(results[1].ratio_bias is not None)
    assert found == [True, False]  # noise that was told and does not show does not average out
