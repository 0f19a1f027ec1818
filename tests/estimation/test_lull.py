"""While nothing happens measurements wait; what happens is taken in at once; nothing is lost."""

import math
from dataclasses import replace

import numpy as np
import pytest
from runs import Runner, within

from belt_ros.estimation import Maintenance, MaintenanceKind, Measurement, Rejection
from belt_ros.estimation.lull import Expected, Lull
from belt_ros.settings import DriveSettings

MILLISECOND = 1_000_000
TURN = 2.0 * math.pi
SPEEDS, TORQUES = (100.0, 99.0), (10.0, -9.0)
EXPECTED = Expected((*SPEEDS, *TORQUES), (1e-6,) * 4)
INTERVAL = 10  # [ms]


def at(milliseconds: float, **others: float) -> Measurement:
    standard = Measurement(round(milliseconds * MILLISECOND), *SPEEDS, *TORQUES)
    return replace(standard, **others)


@pytest.fixture
def lull(settings: DriveSettings) -> Lull:
    """A lull that has just begun; the noise of the settings is 0.01 rad/s or less."""
    lull = Lull((TURN, TURN), settings.noise.noise_rows())
    lull.take(at(-INTERVAL))
    for _ in range(300):
        lull.expect(EXPECTED, 0.01)
    return lull


def test_a_tenth_of_a_second_is_taken_in_as_its_mean(lull: Lull) -> None:
    taken = [lull.take(at(INTERVAL * k)) for k in range(10)]
    assert taken[:9] == [()] * 9
    (mean,) = taken[9]
    assert (mean.stamp_ns, mean.pooled) == (45 * MILLISECOND, 10)
    assert mean.change < 0.1  # nothing has been noticed
    assert mean.speeds == pytest.approx(SPEEDS)
    assert mean.samples[:4] == (10.0,) * 4
    assert not lull.waits


def test_means_of_fast_input_count_as_often_as_they_stand_for(lull: Lull) -> None:
    pooled = [
        replace(at(INTERVAL * k), samples=(5.0,) * 9, bending=(1e-8,) * 9, pooled=5)
        for k in range(10)
    ]
    (mean,) = [each for measurement in pooled for each in lull.take(measurement)]
    assert (mean.pooled, mean.samples[0]) == (50, 50.0)
    assert mean.bending[0] >= 1e-8 * (1.0 - 1e-9)


@pytest.mark.parametrize("place", ["driver_speed", "driven_speed", "driver_torque"])
def test_what_is_off_is_taken_in_at_once_with_all_that_waits_one_by_one(
    lull: Lull, place: str
) -> None:
    waiting = [at(INTERVAL * k) for k in range(5)]
    for measurement in waiting:
        assert lull.take(measurement) == ()
    odd = at(50, **{place: 1.05 * getattr(at(0), place) + 3.0})
    assert lull.take(odd) == (*waiting, odd)
    after = at(60)
    assert lull.take(after) == (after,)


def test_a_mean_that_is_off_is_not_taken_in_as_one(lull: Lull, settings: DriveSettings) -> None:
    deviation = math.sqrt(settings.noise.noise_rows()[:, 2] @ (TORQUES[0] ** 2, 1.0))
    off = [at(INTERVAL * k, driver_torque=TORQUES[0] + 2.0 * deviation) for k in range(10)]
    assert [each for measurement in off for each in lull.take(measurement)] == off


@pytest.mark.parametrize("turns", [0, 3])
def test_a_position_that_leaps_ends_the_lull_a_turn_does_not(lull: Lull, turns: int) -> None:
    def turned(k: int, ahead: float = 0.0) -> Measurement:
        angle = math.remainder(SPEEDS[0] * 0.01 * k, TURN) + TURN * turns * (k % 2)
        return at(INTERVAL * k, driver_position=angle + ahead)

    waiting = [turned(k) for k in range(6)]
    for measurement in waiting:
        assert lull.take(measurement) == ()
    odd = turned(6, ahead=0.5)
    assert lull.take(odd) == (*waiting, odd)


def test_slow_input_does_not_wait(lull: Lull) -> None:
    for k in range(1, 5):
        measurement = at(100.0 * k)
        assert lull.take(measurement) == (measurement,)
        lull.expect(EXPECTED, 0.1)


def test_after_one_odd_reading_it_goes_on_soon_after_another_later(lull: Lull) -> None:
    def odd_then_calm(begin: float) -> int:
        lull.take(at(begin, driven_speed=90.0))
        lull.expect(EXPECTED, 0.01)
        for k in range(1, 1000):
            taken = lull.take(at(begin + INTERVAL * k))
            if not taken:
                return k
            lull.expect(EXPECTED, 0.01)
        return 1000

    soon = odd_then_calm(0.0)
    assert 40 <= soon <= 60
    assert 190 <= odd_then_calm(INTERVAL * (soon + 1)) <= 210


def test_what_is_not_calm_is_no_lull(lull: Lull) -> None:
    lull.expect(None, 0.01)
    for k in range(20):
        assert len(lull.take(at(INTERVAL * k))) == 1


def test_an_estimate_comes_with_every_measurement_and_of_its_stamp(run: Runner) -> None:
    steady = run(duration=8.0, load=[[0.0, 0.0], [1.0, 0.0], [1.2, 20.0]])
    stamps = [output.estimate.stamp_ns for output in steady.outputs]
    assert stamps == [measurement.stamp_ns for measurement in steady.measurements]
    assert all(output.fresh for output in steady.outputs)
    health = steady.outputs[-1].estimate.health
    assert health.accepted == len(steady.measurements)
    values = [output.estimate.slip.value for output in steady.outputs[-200:]]
    assert len(set(values)) < 50  # it has waited


def test_the_truth_is_held_through_a_lull_and_after_what_ends_it(run: Runner) -> None:
    """Idle, loaded, steady for 6 s, then a step of the load: slip and tension stay right."""
    held = []
    for seed in range(6):
        stepped = run(
            seed=seed,
            duration=10.0,
            load=[[0.0, 0.0], [1.0, 0.0], [1.2, 20.0], [8.0, 20.0], [8.05, 40.0]],
        )
        for output, truth in zip(stepped.outputs, stepped.truths, strict=True):
            if output.estimate.stamp_ns > 3e9:
                held.append(within(output.estimate.slip, truth.slip, 1.96))
                assert within(output.estimate.tight_tension, truth.tight_tension, 4.0)
    assert np.mean(held) > 0.92


def test_time_that_jumps_in_a_lull_loses_nothing(run: Runner, settings: DriveSettings) -> None:
    steady = run(duration=6.0, load=[[0.0, 0.0], [1.0, 0.0], [1.2, 20.0]])
    monitor = settings.monitor()
    outputs = [monitor.step(measurement) for measurement in steady.measurements[:505]]
    last = outputs[-1].estimate
    late = [replace(m, stamp_ns=m.stamp_ns + 10**11) for m in steady.measurements[505:600]]
    outputs += [monitor.step(measurement) for measurement in late]
    assert all(output.rejection is Rejection.NONE for output in outputs[510:])
    after = outputs[-1].estimate
    assert after.friction_stiffness_log_stddev < 1.2 * last.friction_stiffness_log_stddev
    assert after.health.resets == 0


def test_after_a_gated_sample_that_was_ahead_time_does_not_go_back(
    run: Runner, settings: DriveSettings
) -> None:
    steady = run(duration=3.0, speed=120.0, load=[[0.0, 0.0], [1.0, 0.0], [1.2, 20.0]])
    monitor = settings.monitor()
    for measurement in steady.measurements[:200]:
        monitor.step(measurement)
    last, following = steady.measurements[199:201]
    wild = replace(last, stamp_ns=last.stamp_ns + 250 * MILLISECOND, driver_speed=-300.0)
    assert monitor.step(wild).rejection is Rejection.GATED
    assert monitor.step(following).rejection is Rejection.OUT_OF_ORDER


def test_maintenance_in_a_lull_shows_with_the_next_measurement(
    run: Runner, settings: DriveSettings
) -> None:
    steady = run(duration=6.0, speed=120.0, load=[[0.0, 0.0], [1.0, 0.0], [1.2, 20.0]])
    monitor = settings.monitor()
    coming = iter(steady.measurements)
    before = now = None
    while now is None or now != before:  # until it is held
        before, estimate = now, monitor.step(next(coming)).estimate
        now = estimate.mean_tension
    monitor.maintain(Maintenance(MaintenanceKind.BELT_REPLACED, 600.0, 20.0))
    tension = monitor.step(next(coming)).estimate.mean_tension
    assert within(tension, 600.0, 1.0)


def test_means_do_not_reach_across_a_hole(lull: Lull) -> None:
    waiting = [at(INTERVAL * k) for k in range(5)]
    for measurement in waiting:
        assert lull.take(measurement) == ()
    late = at(900.0)
    assert lull.take(late) == (*waiting, late)


def test_angles_that_come_without_speeds_are_unwrapped_by_the_last_ones(lull: Lull) -> None:
    """Positions and speeds on topics of their own, half a turn and more between two positions."""
    means = []
    for k in range(60):
        speeds = {"driver_speed": SPEEDS[0], "driven_speed": SPEEDS[1]}
        angle = math.remainder(SPEEDS[0] * 0.01 * k, TURN)
        others = {"driver_position": angle} if k % 4 == 0 else speeds
        alone = Measurement(round(INTERVAL * k * MILLISECOND), **others)
        means += [each for each in lull.take(alone) if each.pooled > 1]
        if not lull.waits:
            lull.expect(EXPECTED, 0.01)
    assert len(means) >= 4
    for mean in means:
        led = SPEEDS[0] * mean.stamp_ns * 1e-9
        assert math.remainder(mean.driver_position - led, TURN) == pytest.approx(0.0, abs=1e-3)
