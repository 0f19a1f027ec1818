"""What was learned has the moments of the belief it is from, and nothing broken is remembered."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from memories import MEAN, PLACES, STDDEV, exactly, learn, members, moments, one

from belt_ros.estimation.condensing import MEMBERS, condensed
from belt_ros.estimation.gaussian_sum import Component
from belt_ros.estimation.memory import MemoryRefusedError
from belt_ros.estimation.state import STATES, Index


@exactly
@given(members())
def test_what_was_learned_has_the_moments_of_the_belief_it_is_from(components) -> None:
    mean, covariance = moments(components)
    learned_mean, learned_covariance = moments(learn(components).components)
    np.testing.assert_allclose(learned_mean, mean[PLACES], rtol=1e-9, atol=1e-9)
    expected = covariance[np.ix_(PLACES, PLACES)]
    np.testing.assert_allclose(learned_covariance, expected, rtol=1e-9, atol=1e-9)


def test_too_many_members_are_merged_and_mean_and_covariance_stay() -> None:
    rng = np.random.default_rng(1)
    many = [
        Component(-0.01 * k, MEAN + STDDEV * 3.0 * rng.standard_normal(STATES), c.covariance)
        for k, c in enumerate(one(spread=0.01) * 90)
    ]
    learned = learn(many)
    assert len(learned.weights) == MEMBERS
    mean, covariance = moments(many)
    learned_mean, learned_covariance = moments(learned.components)
    np.testing.assert_allclose(learned_mean, mean[PLACES], atol=1e-9)
    np.testing.assert_allclose(learned_covariance, covariance[np.ix_(PLACES, PLACES)], atol=1e-9)


def test_condensing_few_that_differ_changes_nothing() -> None:
    apart = one(300.0) + one(600.0)
    kept = condensed(apart, (Index.LOG_TENSION, Index.LOG_STIFFNESS))
    for before, after in zip(apart, kept, strict=True):
        assert after.log_weight == before.log_weight
        assert np.array_equal(after.mean, before.mean)
        assert np.array_equal(after.covariance, before.covariance)


def test_what_was_learned_cannot_be_changed() -> None:
    learned = learn(one())
    with pytest.raises(ValueError, match="read-only"):
        learned.means[0, 0] = 0.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        learned.date = 0.0


@pytest.mark.parametrize("broken", [math.nan, math.inf, 1e9])
def test_a_belief_that_has_come_apart_is_not_remembered(broken) -> None:
    for place in ("mean", "covariance", "log_weight"):
        component = one()[0]
        if place == "mean":
            component.mean[Index.LOG_STIFFNESS] = broken
        elif place == "covariance":
            component.covariance[Index.LOG_STIFFNESS, Index.LOG_STIFFNESS] = broken
        elif math.isfinite(broken):
            continue
        else:
            component.log_weight = broken
        with pytest.raises(MemoryRefusedError), np.errstate(invalid="ignore"):
            learn([component])


def test_a_member_beyond_reason_does_not_spoil_the_others() -> None:
    sound, wild = one()[0], one()[0]
    wild.mean[Index.LOG_STIFFNESS] = 1e6
    learned = learn([sound, wild])
    assert len(learned.weights) == 1
    np.testing.assert_array_equal(learned.means[0], sound.mean[PLACES])


@pytest.mark.parametrize("certain", [1e-20, 1e-40, 0.0])
def test_what_is_known_beyond_rounding_is_remembered_as_well(certain) -> None:
    component = one()[0]
    place = Index.LOG_TENSION
    component.covariance[place, :] = component.covariance[:, place] = 0.0
    component.covariance[place, place] = certain
    learned = learn([component, *one()])
    assert np.all(learned.covariances[:, 0, 0] > 0.0)
    np.testing.assert_array_equal(learned.components[0].mean, component.mean[PLACES])
