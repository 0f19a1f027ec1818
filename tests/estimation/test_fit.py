"""Innovations squared: their mean, its chi-square limits, and the sensor that does not fit."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from belt_ros.estimation.estimate import Consistency, Fit
from belt_ros.estimation.fit import (
    BOTH_SPEEDS,
    LIMIT_95,
    LIMIT_999,
    InnovationFit,
    SensorFits,
    chi_square_limit,
    worst_sensor,
)


def played(squares: np.ndarray, dof: int, dt: float = 0.01, memory: float = 10.0) -> InnovationFit:
    fit = InnovationFit(memory)
    for squared in squares.tolist():
        fit.update(squared, dof, dt)
    return fit


@pytest.mark.parametrize("dof", [20, 50.5, 400, 8000])
@pytest.mark.parametrize(("deviations", "tail"), [(LIMIT_95, 0.025), (LIMIT_999, 0.0005)])
def test_limits_are_those_of_chi_square(dof: float, deviations: float, tail: float) -> None:
    assert chi_square_limit(dof, deviations) == pytest.approx(chi2.isf(tail, dof) / dof, rel=0.02)
    assert chi_square_limit(dof, -deviations) == pytest.approx(chi2.ppf(tail, dof) / dof, rel=0.02)


@pytest.mark.parametrize("dof", [1, 2, 4, 6])
def test_limits_hold_the_mean_of_a_right_filter_as_often_as_they_say(dof: int) -> None:
    random = np.random.default_rng(dof)
    inside = []
    for _ in range(400):
        times = np.concatenate([random.exponential(0.1, 80), random.exponential(0.02, 80)])
        fit = InnovationFit(4.0)
        for dt, squared in zip(times, random.chisquare(dof, 160), strict=True):
            fit.update(squared, dof, dt)
        low, high = fit.limits(LIMIT_95)
        inside.append(low <= fit.fit.mean <= high)
    assert np.mean(inside) == pytest.approx(0.95, abs=3.3 * math.sqrt(0.95 * 0.05 / 400))


def test_sensors_may_come_and_go() -> None:
    random = np.random.default_rng(5)
    means = []
    for _ in range(400):
        fit = InnovationFit(2.0)
        for dof in random.integers(0, 5, 300).tolist():
            fit.update(float(random.chisquare(dof)) if dof else 0.0, dof, 0.02)
        low, high = fit.limits(LIMIT_95)
        means.append((fit.fit.mean, low <= fit.fit.mean <= high))
    mean, inside = np.mean(means, axis=0)
    assert mean == pytest.approx(1.0, abs=0.02)
    assert inside == pytest.approx(0.95, abs=0.036)


@pytest.mark.parametrize(
    ("scale", "verdict"),
    [
        (1.0, Consistency.CONSISTENT),
        (0.6, Consistency.CONSISTENT),  # as after a change of load
        (2.0, Consistency.OVERCONFIDENT),
        (0.25, Consistency.UNDERCONFIDENT),
    ],
)
@pytest.mark.parametrize("dof", [1, 4])
def test_verdict_is_that_of_the_size_of_innovations(
    scale: float, verdict: Consistency, dof: int
) -> None:
    squares = scale * np.random.default_rng(0).chisquare(dof, 3000)
    assert played(squares, dof).fit.consistency is verdict


def test_a_right_filter_is_never_called_wrong() -> None:
    random = np.random.default_rng(1)
    fit = InnovationFit()
    verdicts = set()
    for squared in random.chisquare(4, 50_000).tolist():
        fit.update(squared, 4, 0.01)
        verdicts.add(fit.fit.consistency)
    assert verdicts == {Consistency.UNKNOWN, Consistency.CONSISTENT}


@settings(derandomize=True, deadline=None, max_examples=60)
@given(
    dof=st.sampled_from([1, 2, 4, 6]),
    rate=st.sampled_from([3.0, 10.0, 100.0, 1000.0]),
    before=st.integers(20, 300),
    outlier=st.floats(0.0, math.inf),
)
def test_no_single_sample_makes_a_verdict(
    dof: int, rate: float, before: int, outlier: float
) -> None:
    fit = played(np.full(before, float(dof)), dof, 1.0 / rate)
    was = fit.fit.consistency
    fit.update(outlier, dof, 1.0 / rate)
    if was is Consistency.CONSISTENT:
        assert fit.fit.consistency is Consistency.CONSISTENT
    else:
        assert fit.fit.consistency in (Consistency.UNKNOWN, Consistency.CONSISTENT)


def test_a_load_step_makes_no_verdict() -> None:
    random = np.random.default_rng(2)
    fit = played(random.chisquare(4, 1000), 4)
    for squared in [1e3, 300.0, 80.0, 50.0, 30.0, 20.0, 15.0, 10.0]:
        fit.update(squared, 4, 0.01)
        assert fit.fit.consistency is Consistency.CONSISTENT


def test_what_was_wrong_is_forgotten() -> None:
    random = np.random.default_rng(3)
    fit = played(3.0 * random.chisquare(4, 2000), 4)
    assert fit.fit.consistency is Consistency.OVERCONFIDENT
    for squared in random.chisquare(4, 4000).tolist():
        fit.update(squared, 4, 0.01)
    assert fit.fit.consistency is Consistency.CONSISTENT


def test_too_few_samples_or_too_old_ones_are_no_verdict() -> None:
    assert InnovationFit().fit == Fit()
    fit = played(np.full(19, 400.0), 4)
    assert fit.fit == Fit()
    for _ in range(2):
        fit.update(400.0, 4, 0.01)
    assert fit.fit.consistency is not Consistency.UNKNOWN
    fit.update(4.0, 4, 1e6)
    assert fit.fit == Fit()


@pytest.mark.parametrize("squared", [math.nan, -1.0])
def test_what_is_no_square_is_left_out(squared: float) -> None:
    fit = played(np.full(50, 4.0), 4)
    before = fit.fit
    fit.update(squared, 4, 0.0)
    assert fit.fit == before


NAMES = ("driver speed", "driven speed", "driver torque", "driven torque")


def sensors(scales: list[float], seen: list[int], count: int = 2000) -> SensorFits:
    random = np.random.default_rng(4)
    fits = SensorFits(NAMES)
    for _ in range(count):
        squares = np.array(scales) * random.chisquare(1, len(scales))
        fits.update(np.array(seen), squares, 0.01)
    return fits


def test_the_sensor_that_does_not_fit_is_named() -> None:
    worst = worst_sensor(sensors([1.0, 1.5, 9.0, 0.7], [0, 1, 2, 3]).fits)
    assert worst is not None
    assert worst[0] == "driver torque"


def test_speeds_that_fit_badly_together_are_named_together() -> None:
    """What both pulleys gain does not follow from the torques; neither speed is to be blamed."""
    worst = worst_sensor(sensors([3.0, 2.4, 1.5, 1.0], [0, 1, 2, 3]).fits)
    assert worst is not None
    assert worst[0] == BOTH_SPEEDS
    assert worst[1].mean == pytest.approx(3.0, rel=0.15)


def test_one_speed_that_fits_far_worse_is_named_alone() -> None:
    worst = worst_sensor(sensors([2.0, 9.0, 1.0, 1.0], [0, 1, 2, 3]).fits)
    assert worst is not None
    assert worst[0] == "driven speed"


def test_a_speed_beside_one_that_is_never_read_is_named_alone() -> None:
    worst = worst_sensor(sensors([1.6, 1.0, 1.0], [0, 2, 3]).fits)
    assert worst is not None
    assert worst[0] == "driver speed"


def test_a_sensor_by_itself_is_judged_as_a_filter_of_one_sensor() -> None:
    squares = 1.7 * np.random.default_rng(6).chisquare(1, 100)
    fits = SensorFits(["driver speed"], 3.0)
    alone = InnovationFit(3.0)
    for squared in [*squares, math.nan, math.inf]:
        fits.update(np.array([0]), np.array([squared]), 0.05)
        alone.update(squared, 1, 0.05)
    assert fits.fits[0][1] == pytest.approx(alone.fit, rel=1e-12)


def test_nobody_is_blamed_where_all_fit() -> None:
    assert worst_sensor(sensors([1.0, 1.0, 1.0, 0.5], [0, 1, 2, 3]).fits) is None


def test_a_sensor_that_is_not_there_is_unknown() -> None:
    fits = dict(sensors([1.0, 1.0, 9.0], [0, 1, 3]).fits)
    assert fits["driver torque"] == Fit()
    assert fits["driven torque"].consistency is Consistency.OVERCONFIDENT
