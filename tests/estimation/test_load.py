"""How fast the load wanders, told from readings alone."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from belt_ros.estimation.load import LoadWander

DT = 0.01
NOISE = 0.3  # of both torques [N m]
FASTEST = 3.0  # wander of both torques at full pace [N m/sqrt(s)]
SLIP_NOISE = 1e-3  # [m/s]
SLIP_FASTEST = 0.05  # [m/s/sqrt(s)]
QUIET = 0.003
SEEDS = range(20)


class Bench:
    """Readings about a scripted torque, and the activity that is told from them."""

    def __init__(self, seed: int, noise: float = NOISE, dt: float = DT) -> None:
        self.wander = LoadWander()
        self.random = np.random.default_rng(seed)
        self.noise = np.array([noise, noise, SLIP_NOISE])
        self.dt = dt

    def take(self, torque: float, missing=(), ahead: float = 0.1, unforeseen: bool = False):
        z = np.array([torque, -torque, ahead]) + self.noise * self.random.standard_normal(3)
        z[list(missing)] = math.nan
        fastest = np.array([FASTEST, FASTEST, SLIP_FASTEST])
        noise = self.noise**2
        self.activity = self.wander.follow(
            z, noise, fastest, np.zeros(3), self.dt, unforeseen=unforeseen
        )
        return np.array(self.activity.taken)

    def hold(self, torque: float, seconds: float, missing: tuple[int, ...] = ()):
        """Activities (n, 2) over some time of constant torque."""
        return np.array([self.take(torque, missing) for _ in range(round(seconds / self.dt))])


@pytest.mark.parametrize("dt", [0.001, 0.01, 0.02])
@pytest.mark.parametrize("noise", [0.03, 0.3, 1.0])
def test_a_constant_torque_is_quiet_within_a_second_and_stays_so(dt: float, noise: float) -> None:
    runs = [Bench(seed, noise, dt).hold(20.0, 4.0).max(axis=1) for seed in SEEDS]
    within_a_second = [run[: round(1.0 / dt)].min() for run in runs]
    after = np.array([run[round(1.0 / dt) :] for run in runs])
    assert max(within_a_second) < QUIET
    assert np.mean(after < QUIET) > 0.9
    assert np.mean(after < 0.01) > 0.999
    assert after.max() < 0.1


@pytest.mark.parametrize("noise", [0.03, 0.3])
def test_a_ramp_is_lively_until_it_ends(noise: float) -> None:
    for seed in SEEDS:
        bench = Bench(seed, noise)
        before = bench.hold(20.0, 2.0)[-1]
        ramp = np.array([bench.take(20.0 + 15.0 * k * DT) for k in range(100)])
        after = bench.hold(35.0, 1.5)[-50:]
        assert np.median(ramp[20:], axis=0).min() > 10.0 * before.max()
        assert np.median(after) < QUIET


@pytest.mark.parametrize("step", [-60.0, 9.0, 30.0])
def test_a_step_is_as_lively_as_it_is_large_in_that_very_sample(step: float) -> None:
    """From 30 sigma of the sensor on, five times what the greatest wander would explain."""
    assert abs(step) > 5.0 * FASTEST * math.sqrt(DT)
    for seed in SEEDS:
        bench = Bench(seed)
        bench.hold(20.0, 2.0)
        expected = abs(step) / (FASTEST * math.sqrt(DT))
        np.testing.assert_allclose(bench.take(20.0 + step), expected, rtol=0.15)


@pytest.mark.parametrize("step", [9.0, 30.0])
def test_after_a_step_it_is_quiet_again_within_a_third_of_a_second(step: float) -> None:
    runs = []
    for seed in SEEDS:
        bench = Bench(seed)
        bench.hold(20.0, 2.0)
        runs.append(bench.hold(20.0 + step, 1.3).max(axis=1)[30:])
    assert np.median(runs) < QUIET
    assert np.mean(np.array(runs) < QUIET) > 0.85
    assert np.mean(np.array(runs) < 0.01) > 0.99


def test_a_step_of_one_torque_leaves_the_other_quiet() -> None:
    bench = Bench(1)
    bench.hold(20.0, 2.0)
    z = np.array([50.0, -20.0, 0.1])
    fastest = np.array([FASTEST, FASTEST, SLIP_FASTEST])
    driver, driven = bench.wander.follow(
        z, bench.noise**2, fastest, np.zeros(3), DT, unforeseen=False
    ).taken
    assert driver > 1.0
    assert driven < QUIET


def test_a_ramp_may_have_led_to_eight_deviations_of_the_noise_unseen() -> None:
    for seed in SEEDS:
        bench = Bench(seed)
        bench.hold(20.0, 2.0)
        steps = 0
        while (pace := bench.take(20.0 + 15.0 * steps * DT)[0]) < 0.1:
            steps += 1
        assert pace * FASTEST * math.sqrt(bench.activity.unseen[0]) == pytest.approx(8.0 * NOISE)


def test_what_a_step_leaves_behind_dates_its_onset_no_earlier() -> None:
    """While it calms down it passes through every pace, which might have been unseen for longer."""
    for seed in SEEDS:
        bench = Bench(seed)
        bench.hold(20.0, 2.0)
        for k in range(20):
            bench.take(50.0)
            assert max(bench.activity.unseen) < (k + 1.5) * DT


def test_between_two_readings_a_load_may_have_set_in_at_any_time() -> None:
    bench = Bench(4)
    bench.hold(20.0, 2.0)
    for _ in range(6):
        bench.take(50.0, missing=(0, 1))
    bench.take(50.0)
    assert max(bench.activity.taken) > 1.0
    np.testing.assert_allclose(bench.activity.unseen, 6.0 * DT, atol=0.5 * DT)


def test_a_load_that_has_begun_goes_on_while_no_torque_is_read() -> None:
    bench = Bench(5)
    bench.hold(20.0, 2.0)
    bench.take(50.0)
    at_once = np.array(bench.activity.unseen)
    for k in range(1, 6):
        bench.take(50.0, missing=(0, 1))
        np.testing.assert_allclose(bench.activity.unseen, at_once + k * DT)


def test_nobody_knows_when_a_load_began_that_nothing_tells_of() -> None:
    bench = Bench(6)
    bench.take(20.0, missing=(0, 1))
    assert bench.activity.unseen == (math.inf, math.inf)
    bench.hold(20.0, 2.0, missing=(1,))
    assert bench.activity.unseen[1] == bench.activity.unseen[0]


@pytest.mark.parametrize("missing", [0, 1])
def test_a_missing_torque_wanders_like_the_other(missing: int) -> None:
    bench = Bench(2)
    held = bench.hold(20.0, 2.0, (missing,))
    np.testing.assert_array_equal(held[:, 0], held[:, 1])
    assert held[-1, 0] < QUIET
    jumped = bench.take(50.0, (missing,))
    assert jumped[0] == jumped[1] > 1.0


def test_without_both_torques_for_half_a_second_the_load_may_do_anything() -> None:
    bench = Bench(3)
    bench.hold(20.0, 2.0)
    without = bench.hold(20.0, 1.5, (0, 1))
    assert without[:49].max() < QUIET
    np.testing.assert_array_equal(without[51:], 1.0)


def test_a_torque_that_comes_back_late_is_not_compared_with_what_it_was() -> None:
    bench = Bench(4)
    bench.hold(20.0, 2.0)
    bench.hold(20.0, 0.6, (0,))
    assert bench.take(80.0)[0] == 1.0  # not the jump that the driven pulley's torque has made


@pytest.mark.parametrize("every", [2, 5, 20])
def test_a_torque_that_comes_seldom_is_as_quiet_in_between(every: int) -> None:
    for seed in SEEDS:
        bench = Bench(seed)
        held = [bench.take(20.0, () if k % every == 0 else (0, 1)) for k in range(400)]
        assert np.median(held[200:]) < QUIET
        assert np.max(held[200:]) < 0.1


def test_signals_that_come_in_turns_tell_what_those_at_once_do() -> None:
    """A steady load is quiet, a ramp is lively, though no reading has everything."""
    turns = ((0,), (1,), (2,))
    for seed in SEEDS:
        bench = Bench(seed, dt=DT / 3.0)
        rows = [tuple({0, 1, 2} - set(turns[k % 3])) for k in range(900)]
        before = [bench.take(20.0, row) for row in rows[:600]][-1]
        ramp = [bench.take(20.0 + 5.0 * k * DT, row) for k, row in enumerate(rows[600:])]
        assert before.max() < QUIET
        assert np.median(ramp[60:], axis=0).min() > 10.0 * before.max()


@pytest.mark.parametrize("step", [12.0, 30.0])
def test_a_step_between_seldom_readings_is_one_of_the_step_that_shows_it(step: float) -> None:
    """Its noise is added in one step of the filter, however long there was no reading."""
    for seed in SEEDS:
        bench = Bench(seed)
        for k in range(200):
            bench.take(20.0, () if k % 5 == 0 else (0, 1))
        jump = bench.take(20.0 + step)
        np.testing.assert_allclose(jump, step / (FASTEST * math.sqrt(DT)), rtol=0.2)
        assert bench.take(20.0 + step, (0, 1)).max() < 0.1


def sliding(bench: Bench, steps: int, *, unforeseen: bool = False) -> np.ndarray:
    """Activities (n, 2) while slip moves and the torques do not."""
    return np.array(
        [bench.take(20.0, (), 0.1 + 0.5 * k * DT, unforeseen=unforeseen) for k in range(steps)]
    )


def test_slip_that_moves_unforeseen_speaks_for_a_load_that_does() -> None:
    bench = Bench(5)
    bench.hold(20.0, 2.0)
    still = bench.hold(20.0, 1.0)[-1]
    moving = sliding(bench, 100, unforeseen=True)
    assert np.median(moving[20:], axis=0).min() > 10.0 * still.max()


def test_slip_that_moves_as_foretold_says_nothing_of_the_load() -> None:
    """While creep develops, and near the knee, it is the belt that makes it move."""
    bench = Bench(5)
    bench.hold(20.0, 3.0)
    moving = sliding(bench, 100)
    assert np.median(moving, axis=0).max() < QUIET


def test_slip_once_unforeseen_speaks_until_it_rests() -> None:
    bench = Bench(5)
    bench.hold(20.0, 3.0)
    sliding(bench, 30, unforeseen=True)
    still_moving = np.array([bench.take(20.0, ahead=0.25 + 0.5 * k * DT) for k in range(70)])
    assert still_moving[-20:].min() > 0.03
    rested = np.array([bench.take(20.0, ahead=0.6) for _ in range(100)])
    assert np.median(rested[50:]) < QUIET
    again = sliding(bench, 50)  # foretold this time
    assert np.median(again) < QUIET


def test_slip_speaks_of_a_load_that_a_torque_has_shown_to_move() -> None:
    """A torque's noise hides how a ramp ends; slip goes on telling."""
    bench = Bench(8, noise=1.0)
    bench.hold(20.0, 3.0)
    for k in range(40):
        bench.take(20.0 + 60.0 * k * DT, ahead=0.1 + 0.5 * k * DT)
    end = np.array([bench.take(44.0, ahead=0.3 + 0.5 * k * DT) for k in range(40)])
    assert end[-10:].min() > 0.03


def test_slip_that_wanders_anyway_says_nothing_of_the_load() -> None:
    wander, random = LoadWander(), np.random.default_rng(6)
    variances = np.array([NOISE, NOISE, SLIP_NOISE]) ** 2
    fastest, anyway = np.array([FASTEST, FASTEST, SLIP_FASTEST]), np.array([0.0, 0.0, 0.05])
    ahead, seen = 0.1, []
    for _ in range(400):
        ahead += 0.05 * math.sqrt(DT) * random.standard_normal()
        z = np.array([20.0, -20.0, ahead]) + np.sqrt(variances) * random.standard_normal(3)
        seen.append(wander.follow(z, variances, fastest, anyway, DT, unforeseen=True).taken)
    assert np.mean(np.array(seen[100:]) < QUIET) > 0.95


def test_a_start_forgets_everything() -> None:
    bench, fresh = Bench(7), Bench(7)
    bench.hold(-70.0, 1.0)
    bench.wander.start()
    bench.random = np.random.default_rng(7)
    np.testing.assert_array_equal(bench.hold(20.0, 0.5), fresh.hold(20.0, 0.5))


READING = st.one_of(st.just(math.nan), st.floats(-1e9, 1e9))


@hypothesis_settings(derandomize=True, deadline=None, max_examples=150)
@given(
    rows=st.lists(
        st.tuples(st.tuples(READING, READING, READING), st.floats(1e-9, 1e3), st.booleans()),
        min_size=1,
        max_size=30,
    ),
    noise=st.floats(1e-18, 1e18),
    fastest=st.floats(1e-6, 1e9),
)
def test_nan_never_comes_out_whatever_is_read(rows, noise: float, fastest: float) -> None:
    wander = LoadWander()
    for readings, dt, unforeseen in rows:
        active = wander.follow(
            np.array(readings),
            np.full(3, noise),
            np.full(3, fastest),
            np.zeros(3),
            dt,
            unforeseen=unforeseen,
        )
        assert len(active.unseen) == 2
        assert min(active.unseen) >= 0.0
        for of_both in (active.taken, active.shown):
            assert len(of_both) == 2
            assert np.all(np.isfinite(of_both))
            assert min(of_both) >= 0.0
            if dt > 0.5 and math.isnan(readings[0]) and math.isnan(readings[1]):
                assert of_both == (1.0, 1.0)
        assert np.all(np.greater_equal(active.taken, active.shown))


@pytest.mark.parametrize("dt", [0.01, 0.02, 0.05])
def test_what_follows_a_ramp_that_fast_is_not_surprised_by_it(dt: float) -> None:
    """Sampled slowly, a ramp is far ahead of a walk that only creeps after it.

    Its first half second, until it has been noticed, may surprise.
    """
    noise, slope = 0.04 * FASTEST, 0.7 * FASTEST  # a 3 % sensor; from 60 % of capacity in 1.5 s
    squared = []
    for seed in SEEDS:
        bench = Bench(seed, noise, dt)
        bench.hold(20.0, 4.0)
        mean, variance = 20.0, 0.0
        for k in range(round(1.5 / dt)):
            z = 20.0 - slope * k * dt + noise * bench.random.standard_normal()
            noisy = np.array([z, -z, 0.1])
            fastest = np.array([FASTEST, FASTEST, SLIP_FASTEST])
            active = bench.wander.follow(
                noisy, bench.noise**2, fastest, np.zeros(3), dt, unforeseen=False
            )
            variance += (active.taken[0] * FASTEST) ** 2 * dt
            innovation = z - mean
            if k * dt > 0.5:
                squared.append(innovation**2 / (variance + noise**2))
            gain = variance / (variance + noise**2)
            mean += gain * innovation
            variance *= 1.0 - gain
    assert np.mean(squared) < 2.5
