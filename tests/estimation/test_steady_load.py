"""What is not there to learn is not learned: steady load, and changes of traction under load."""

import math

import numpy as np
import pytest
from runs import Run, Runner, assert_sound, within

from belt_ros.estimation import Knowledge
from belt_ros.estimation.traction import Loss, named_loss

SEEDS = range(6)
TENSIONS = (420.0, 440.0)
BEGIN = 2.2  # of the steady load [s]


def z_of_log_tension(run: Run, seconds: float) -> float:
    """Error of ln T over its stated deviation."""
    estimate, truth = run.at(seconds)
    value, stddev = estimate.mean_tension
    log_stddev = math.sqrt(math.log1p((stddev / value) ** 2))
    return (math.log(value / truth.mean_tension) + 0.5 * log_stddev**2) / log_stddev


@pytest.fixture(scope="module")
def steady(run: Runner) -> list[Run]:
    """The demonstration's drive at 45 N m, three quarters of what it carries, for 40 s."""
    return [
        run(
            duration=BEGIN + 40.0,
            sample_rate=50.0,
            seed=seed,
            speed=[[0.0, 0.0], [1.0, 120.0]],
            load=[[2.0, 0.0], [BEGIN, 45.0]],
            condition__tension=tension,
            condition__friction_stiffness=6e6,
        )
        for seed, tension in zip(SEEDS, TENSIONS * 3, strict=True)
    ]


def test_a_steady_load_does_not_teach_a_wrong_tension(steady: list[Run]) -> None:
    off = np.array([z_of_log_tension(run, BEGIN + 40.0) for run in steady])
    assert np.mean(np.abs(off)) < 1.2
    assert abs(np.mean(off)) < 1.0  # nor all of them the same way
    assert np.max(np.abs(off)) < 2.5


def test_nor_does_it_on_the_way(steady: list[Run]) -> None:
    for run in steady:
        off = [z_of_log_tension(run, BEGIN + second) for second in range(1, 40)]
        assert np.max(np.abs(off)) < 2.5


def test_the_last_half_minute_of_it_teaches_next_to_nothing(steady: list[Run]) -> None:
    """The noise of torques is all that is new in it."""
    moved = []
    for run in steady:
        early, late = (run.at(BEGIN + second)[0].mean_tension for second in (10.0, 40.0))
        assert late.stddev > 0.75 * early.stddev
        moved.append((late.value - early.value) / early.stddev)
    assert np.max(np.abs(moved)) < 0.7


def test_the_margin_it_leaves_holds_the_truth(steady: list[Run]) -> None:
    inside = []
    for run in steady:
        estimate, truth = run.at(BEGIN + 40.0)
        inside.append(within(estimate.margin, truth.margin))
        assert estimate.friction_coefficient_knowledge is Knowledge.AT_PRIOR
    assert all(inside)


def test_a_steady_load_is_no_loss_of_traction(steady: list[Run]) -> None:
    for run in steady:
        for output in run.outputs[150::25]:
            assert named_loss(output.estimate.lost_traction) is Loss.NONE


def changed(run: Runner, seed: int, load: float, **to: float) -> Run:
    return run(
        duration=9.0,
        sample_rate=50.0,
        seed=seed,
        speed=[[0.0, 0.0], [1.0, 120.0]],
        load=[[2.0, 0.0], [BEGIN, load]],
        condition__tension=440.0,
        condition__friction_stiffness=6e6,
        events=[{"at": 5.0, "over": 1.0, **to}],
    )


@pytest.fixture(scope="module", params=[30.0, 38.0])
def loosened(run: Runner, request: pytest.FixtureRequest) -> list[Run]:
    """Tension falls by 40 % within a second, with half or two thirds of the capacity as load."""
    return [changed(run, seed, request.param, tension=264.0) for seed in range(8)]


def test_a_loss_of_tension_is_noticed_and_never_called_one_of_friction(loosened) -> None:
    for run in loosened:
        names = [named_loss(output.estimate.lost_traction) for output in run.outputs[1:]]
        assert set(names[:250]) == {Loss.NONE}
        assert Loss.FRICTION not in names
        assert names[325] in (Loss.TRACTION, Loss.TENSION)  # half a second after its end
        assert names[-1] in (Loss.TRACTION, Loss.TENSION)


def test_what_is_left_of_the_capacity_is_known_after_a_loss(loosened) -> None:
    off, deviations = [], []
    for run in loosened:
        estimate, truth = run.outputs[-1].estimate, run.truths[-1]
        off.append(estimate.margin.value - truth.margin)
        deviations.append(estimate.margin.stddev)
        for output in run.outputs:
            assert_sound(output.estimate)
    assert np.sqrt(np.mean(np.square(off))) < 0.06
    assert np.sqrt(np.mean(np.square(np.divide(off, deviations)))) < 1.9


def test_tension_and_mu_are_open_in_a_change_of_traction(loosened) -> None:
    """Neither is taken for granted while it goes on, however well mu was known before."""
    opened = []
    for run in loosened:
        before, during = run.at(4.9)[0], run.at(6.0)[0]
        opened.append(during.friction_coefficient.stddev / before.friction_coefficient.stddev)
    assert np.median(opened) > 3.5
    assert np.sort(opened)[1] > 2.0
    assert np.min(opened) > 1.5  # a loss that is noticed early is half over by then


def test_oil_that_halves_mu_at_once_leaves_open_that_the_tension_has_stayed(run: Runner) -> None:
    """With mu taken to change by no more than a third, the tension was 4.5 deviations off."""
    off = []
    for seed in range(4):
        oiled = changed(run, seed, 38.0, friction_coefficient=0.5, over=0.2)
        off += [z_of_log_tension(oiled, seconds) for seconds in (5.7, 6.5, 8.0)]
    assert math.sqrt(np.mean(np.square(off))) < 3.5


@pytest.mark.parametrize("seed", range(3))
def test_a_loss_of_friction_does_not_end_in_an_unsound_estimate(run: Runner, seed: int) -> None:
    """At a mu of 1.2, 40 % less of it takes 15 % of the capacity: no loss that has a name."""
    spoilt = changed(run, seed, 45.0, friction_coefficient=0.72)
    before, after = spoilt.truths[200], spoilt.truths[-1]
    assert after.capacity_torque > 0.8 * before.capacity_torque
    for output in spoilt.outputs:
        assert_sound(output.estimate)
        assert named_loss(output.estimate.lost_traction) is not Loss.FRICTION
    estimate = spoilt.outputs[-1].estimate
    assert within(estimate.slip, after.slip, 3.0)
    assert estimate.margin.value < after.margin + 2.0 * estimate.margin.stddev  # not too hopeful
