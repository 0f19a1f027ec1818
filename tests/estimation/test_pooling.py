"""Fast input is pooled: what its mean is, when it is handed on, and that nothing is lost."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from belt_ros.estimation import Measurement, Rejection
from belt_ros.estimation.pooling import Pool
from belt_ros.settings import DriveSettings

MILLISECOND = 1_000_000
PERIOD = 0.01  # [s]


def at(milliseconds: float, speed: float = 100.0, **others: float) -> Measurement:
    return Measurement(round(milliseconds * MILLISECOND), speed, speed - 1.0, **others)


def test_a_span_of_fast_input_becomes_its_mean_at_the_mean_of_its_stamps() -> None:
    pool = Pool(PERIOD)
    pool.take(at(9.0))
    taken = [pool.take(at(10.0 + k, speed=100.0 + k)) for k in range(10)]

    assert taken[:9] == [()] * 9
    (mean,) = taken[9]
    assert (mean.stamp_ns, mean.pooled) == (round(14.5 * MILLISECOND), 10)
    assert mean.speeds == pytest.approx((104.5, 103.5))
    assert mean.samples[:2] == (10, 10)
    assert math.isnan(mean.driver_torque)


@pytest.mark.parametrize("interval", [9.5, 10.0, 25.0, 400.0])
def test_slow_input_passes_untouched(interval: float) -> None:
    pool = Pool(PERIOD)
    for k in range(1, 20):
        measurement = at(k * interval)
        assert pool.take(measurement) == (measurement,)


def test_a_period_of_nothing_pools_nothing() -> None:
    pool = Pool(0.0)
    assert all(len(pool.take(at(1.0 + 0.25 * k))) == 1 for k in range(50))


@pytest.mark.parametrize("stamp", [3.0, 12.0, 500.0])
def test_what_is_pooled_goes_before_a_stamp_that_does_not_follow(stamp: float) -> None:
    pool = Pool(PERIOD)
    pool.take(at(9.0))
    for k in range(3):
        pool.take(at(10.0 + k))
    odd = at(stamp, speed=7.0)

    mean, after = pool.take(odd)
    assert (mean.pooled, mean.stamp_ns, mean.driver_speed) == (3, 11 * MILLISECOND, 100.0)
    assert after is odd


def test_each_sensor_counts_its_own_samples() -> None:
    pool = Pool(PERIOD)
    pool.take(at(9.0))
    taken = ()
    for k in range(10):
        torque = {"driver_torque": 4.0 + k} if k % 5 == 0 else {}
        taken = pool.take(at(10.0 + k, **torque))

    (mean,) = taken
    assert mean.driver_torque == 6.5
    assert mean.samples[2] == 2
    assert mean.samples[0] == 10


@pytest.mark.parametrize("turn", [2.0 * math.pi, math.pi])
def test_angles_are_averaged_across_their_turns(turn: float) -> None:
    pool = Pool(PERIOD, (turn, turn))
    pool.take(at(9.0))
    taken = ()
    for k in range(10):  # over a turn in the span, and past where the angle wraps
        taken = pool.take(at(10.0 + k, speed=800.0, driver_position=(3.0 + 0.8 * k) % turn))

    (mean,) = taken
    assert mean.driver_position % turn == pytest.approx((3.0 + 0.8 * 4.5) % turn)
    assert mean.samples[4] == 1
    assert math.isnan(mean.driven_position)


def pooled(signal: Callable[[float], float], spans: int = 6) -> list[Measurement]:
    """Means of a driver speed that is a function of time [s], sampled at 1 kHz."""
    pool = Pool(PERIOD)
    taken = [pool.take(at(k, speed=signal(k * 1e-3))) for k in range(9, 10 + 10 * spans)]
    return [mean for means in taken[1:] for mean in means]


@pytest.mark.parametrize(
    "signal",
    [lambda t: 100.0 + 500.0 * t * t, lambda t: 100.0 + 0.5 * math.sin(60.0 * t)],
    ids=["even", "swinging"],
)
def test_what_bends_within_a_span_is_told_with_about_what_means_are_off_by(
    signal: Callable[[float], float],
) -> None:
    means = pooled(signal, spans=30)[2:]
    off = np.array([mean.driver_speed - signal(mean.stamp_ns * 1e-9) for mean in means])
    told = np.array([mean.bending[0] for mean in means])
    assert 0.5 < np.sqrt(np.mean(told) / np.mean(off**2)) < 3.0


def test_even_acceleration_bends_nothing_but_angles() -> None:
    pool = Pool(PERIOD)
    taken = [
        mean
        for k in range(60)
        for mean in pool.take(at(k, speed=100.0 + 0.1 * k, driver_position=0.1 * k))
    ]
    speed, angle = taken[-1].bending[0], taken[-1].bending[4]
    assert speed == pytest.approx(0.0, abs=1e-20)
    assert math.sqrt(angle) == pytest.approx(100.0 * 0.01**2 / 12.0)


@pytest.mark.parametrize("missing", [0, 4, 9])
def test_an_angle_that_is_missing_at_times_is_still_that_of_the_stamp(missing: int) -> None:
    pool = Pool(PERIOD)
    taken: list[Measurement] = []
    for k in range(60):
        angle = math.nan if k % 10 == missing else 100.0 * 1e-3 * k
        taken += pool.take(at(k, driver_position=angle))
    for mean in taken[2:]:
        assert mean.driver_position == pytest.approx(100.0 * mean.stamp_ns * 1e-9)


def test_what_comes_seldom_is_told_with_how_far_it_is_from_the_stamp() -> None:
    pool = Pool(PERIOD)
    taken: list[Measurement] = []
    for k in range(100):
        speed = 100.0 + 0.5 * k
        seldom = speed if k % 10 == 0 else math.nan
        taken += pool.take(Measurement(k * MILLISECOND, speed, seldom))
    mean = taken[-1]
    off = mean.driven_speed - (100.0 + 500.0 * mean.stamp_ns * 1e-9)
    assert 0.5 < math.sqrt(mean.bending[1]) / abs(off) < 2.0


def test_bends_are_told_across_short_gaps() -> None:
    pool = Pool(PERIOD)
    taken: list[Measurement] = []
    for k in range(400):
        stamp = k + 11 * (k // 25)  # ms; 12 ms pass after every 25 samples
        taken += pool.take(at(stamp, speed=100.0 + 0.5 * math.sin(0.06 * stamp)))
    means = [mean for mean in taken if mean.pooled > 1]
    assert sum(bool(mean.bending) for mean in means) >= len(means) - 2


@pytest.mark.parametrize("period", [0.0, 0.01])
@pytest.mark.parametrize("behind", [0.0, 2.5])
def test_what_is_not_later_than_the_last_is_turned_away_pooled_or_not(
    settings: DriveSettings, period: float, behind: float
) -> None:
    limits = dataclasses.replace(settings.limits, pool_period=period)
    monitor = dataclasses.replace(settings, limits=limits).monitor()
    for k in range(100):
        for stamp in (k, k - behind) if k % 10 == 7 else (k,):
            nanoseconds = round((1000 + stamp) * MILLISECOND)
            monitor.step(Measurement(nanoseconds, 120.0, 119.2, 45.0, -45.0))
    assert monitor.health.rejections[Rejection.OUT_OF_ORDER] == 10


@hypothesis_settings(derandomize=True, deadline=None)
@given(st.lists(st.floats(1e-4, 9e-3), min_size=30, max_size=200))
def test_no_sample_waits_longer_than_a_period_and_none_counts_twice(steps: list[float]) -> None:
    pool = Pool(PERIOD)
    stamps = np.round(np.cumsum(steps) * 1e9).astype(np.int64) + 1_000_000_000
    waiting: list[int] = []
    for stamp in stamps.tolist():
        waiting.append(stamp)
        taken = pool.take(Measurement(stamp, 1.0, 1.0))
        assert stamp - waiting[0] <= 2.0 * PERIOD * 1e9
        if taken:
            assert sum(mean.pooled for mean in taken) == len(waiting)
            waiting.clear()


def test_a_pooled_run_says_what_the_whole_run_says_with_less_work(settings) -> None:
    """A thousand samples a second, averaged over 10 ms and over nothing."""
    bounds = {  # in deviations, rms over seeds
        "slip": 0.4,
        "margin": 0.4,
        "mean_tension": 0.4,
        "transmitted_torque": 0.8,
    }
    names = tuple(bounds)
    apart = []
    for seed in range(4):
        estimates = []
        for period in (0.0, 0.01):
            limits = dataclasses.replace(settings.limits, pool_period=period)
            monitor = dataclasses.replace(settings, limits=limits).monitor()
            noise = np.random.default_rng(seed).normal(size=(1500, 4)) * [0.01, 0.01, 0.3, 0.3]
            fresh = 0
            for k, (a, b, c, d) in enumerate(noise.tolist()):
                stamp = 1_000_000_000 + k * MILLISECOND
                output = monitor.step(Measurement(stamp, 120 + a, 119.2 + b, 45 + c, -45 + d))
                fresh += output.fresh
            estimates.append(monitor.estimate)
            assert monitor.health.accepted >= 1500 - 10
            assert fresh == (1500 if period == 0.0 else pytest.approx(150, abs=3))
        whole, pooled = ([getattr(one, name) for name in names] for one in estimates)
        for name, ours, theirs in zip(names, pooled, whole, strict=True):
            assert 0.5 < ours.stddev / theirs.stddev < 2.0, (seed, name)
        pairs = zip(pooled, whole, strict=True)
        apart.append([(ours.value - theirs.value) / theirs.stddev for ours, theirs in pairs])
    assert np.all(np.abs(apart[3]) < 1.0)
    rms = np.sqrt(np.mean(np.square(apart), axis=0))
    assert np.all(rms < list(bounds.values())), dict(zip(names, rms, strict=True))


def test_means_never_come_farther_apart_than_the_greatest_gap(settings: DriveSettings) -> None:
    limits = dataclasses.replace(settings.limits, greatest_gap=0.008, pool_period=0.01)
    monitor = dataclasses.replace(settings, limits=limits).monitor()
    for k in range(300):
        monitor.step(at(1.0 + k, speed=100.0))
    assert monitor.health.rejections[Rejection.OUT_OF_ORDER] == 0
    assert monitor.health.accepted > 295  # the last few still wait for others


def test_at_the_end_what_is_pooled_is_taken_in(settings: DriveSettings) -> None:
    monitor = settings.monitor()
    for k in range(105):
        monitor.step(Measurement(k * 1_000_000, 100.0, 99.9, 10.0, -10.0))
    assert monitor.health.accepted < 105
    monitor.finish()
    assert monitor.health.accepted == 105
    assert monitor.estimate is not None
    assert monitor.estimate.stamp_ns > 100 * 1_000_000
