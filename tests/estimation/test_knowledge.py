"""Learned is what data have narrowed on both sides; half-open knowledge is not."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from belt_ros.estimation.estimate import Knowledge, Quantity
from belt_ros.estimation.knowledge import greatest_likelihood_beside, knowledge_of

PRIOR = Quantity(6.6, 0.3)
PLACE = 1


def one(mean: float, deviation: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A sum of one Gaussian over two states, of which the second is asked for."""
    covariance = np.diag([1.0, deviation**2])
    return np.ones(1), np.array([[0.0, mean]]), covariance[np.newaxis]


def cut_off(least: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The prior above `least`, as narrow Gaussians."""
    means = np.arange(least, PRIOR.value + 6.0 * PRIOR.stddev, 0.01)
    weights = np.exp(-0.5 * ((means - PRIOR.value) / PRIOR.stddev) ** 2)
    covariances = np.tile(np.diag([1.0, 0.01**2]), (means.size, 1, 1))
    return weights / weights.sum(), np.stack([0.0 * means, means], axis=1), covariances


def moments(weights: np.ndarray, means: np.ndarray, covariances: np.ndarray) -> Quantity:
    mean = float(weights @ means[:, PLACE])
    about = (means[:, PLACE] - mean) ** 2
    return Quantity(mean, math.sqrt(float(weights @ (covariances[:, PLACE, PLACE] + about))))


def knowledge(members: tuple[np.ndarray, np.ndarray, np.ndarray]) -> Knowledge:
    return knowledge_of(moments(*members), PRIOR, PLACE, *members)


@pytest.mark.parametrize(("mean", "deviation"), [(6.45, 0.1), (6.6, 0.1), (7.2, 0.08)])
def test_what_data_have_narrowed_enough_is_learned(mean: float, deviation: float) -> None:
    assert knowledge(one(mean, deviation)) is Knowledge.LEARNED


@pytest.mark.parametrize("deviation", [0.16, 0.3])
def test_what_is_wider_than_half_the_prior_is_not(deviation: float) -> None:
    assert knowledge(one(6.6, deviation)) is Knowledge.AT_PRIOR


@pytest.mark.parametrize("deviations", [0.0, 1.0, 2.0])
def test_what_is_only_bounded_from_below_is_not_learned_however_narrow(deviations: float) -> None:
    members = cut_off(PRIOR.value + deviations * PRIOR.stddev)
    believed = moments(*members)
    if deviations >= 1.0:
        assert believed.stddev < 0.5 * PRIOR.stddev
    assert knowledge(members) is Knowledge.AT_PRIOR


def test_the_prior_itself_speaks_against_nothing() -> None:
    beside = greatest_likelihood_beside(*one(*PRIOR), PLACE, PRIOR.value, (*PRIOR,))
    assert beside == pytest.approx(1.0)


@given(st.floats(-50.0, 50.0), st.floats(1e-6, 1.0))
def test_of_one_gaussian_it_is_the_likelihood_ratio_of_what_data_alone_say(
    mean: float, deviation: float
) -> None:
    found = greatest_likelihood_beside(*one(mean, deviation), PLACE, mean, (*PRIOR,))
    assert found >= 0.0
    at, square = (mean - PRIOR.value) / PRIOR.stddev, (PRIOR.stddev / deviation) ** 2
    if abs(at) < 10.0:
        exact = math.exp(min(-0.5 * square + 0.5 + abs(at), 700.0))
        assert found == pytest.approx(exact, rel=1e-6, abs=1e-300)
