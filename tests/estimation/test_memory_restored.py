"""What was learned is restored as old as it is, and only to the drive that it is of."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from memories import DRIFT, DRIVE, MEAN, PLACES, STDDEV, exactly, learn, members, moments, one

from belt_ros.estimation.condensing import MEMBERS
from belt_ros.estimation.fingerprint import fingerprint
from belt_ros.estimation.gaussian_sum import Component
from belt_ros.estimation.load import Activity
from belt_ros.estimation.memory import STANDING, MemoryRefusedError, aged, forgetting, restore
from belt_ros.estimation.process import drift_processes, drift_wander
from belt_ros.estimation.state import STATES, Index
from belt_ros.mechanics import Belt, Pulley
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.drive import Tensioning

HOUR, DAY = 3600.0, 86400.0


def assert_same(one: list[Component], other: list[Component], tolerance: float = 1e-9) -> None:
    for a, b in zip(moments(one), moments(other), strict=True):
        np.testing.assert_allclose(a, b, rtol=tolerance, atol=tolerance)


@exactly
@given(members(), st.floats(0.0, 30.0 * DAY), st.floats(0.0, 30.0 * DAY))
def test_ageing_composes(components, first, second) -> None:
    law = forgetting(MEAN, STDDEV, DRIFT)
    learned = learn(components).components
    assert_same(aged(aged(learned, law, first), law, second), aged(learned, law, first + second))


@exactly
@given(members(), st.floats(0.0, 1e6))
def test_without_a_change_of_tension_ageing_is_the_filter_s_own(components, elapsed) -> None:
    """All but the ratio bias, which the filter holds for constant."""
    law = forgetting(MEAN, STDDEV, DRIFT, pace=1.0)._replace(changes=0.0)
    constants = drive_constants(DRIVE)
    wander = drift_wander(DRIFT, STDDEV, 400.0)
    process, _ = drift_processes(
        wander, constants, Activity((1.0, 1.0), (1.0, 1.0)), (1.0, 0.0, 0.0), elapsed, elapsed
    )
    belt = PLACES[:3]
    learned = learn(components).components
    expected = [
        Component(
            c.log_weight,
            MEAN[belt] + process.memory[belt] * (c.mean[:3] - MEAN[belt]),
            np.outer(process.memory[belt], process.memory[belt]) * c.covariance[:3, :3]
            + process.covariance_before[np.ix_(belt, belt)],
        )
        for c in learned
    ]
    kept = [c for c in aged(learned, law, elapsed) if c.log_weight > -math.inf]
    for mine, its in zip(kept, expected, strict=True):
        np.testing.assert_allclose(mine.mean[:3], its.mean, rtol=1e-12)
        np.testing.assert_allclose(mine.covariance[:3, :3], its.covariance, rtol=1e-9, atol=1e-15)


@exactly
@given(members())
def test_restored_at_once_the_belief_is_what_it_was(components) -> None:
    restored = restore(learn(components), DRIVE, MEAN, STDDEV, DRIFT, 0.0)
    assert restored.note == ""
    mean, covariance = moments(components)
    restored_mean, restored_covariance = moments(restored.components)
    np.testing.assert_allclose(restored_mean[PLACES], mean[PLACES], rtol=1e-9, atol=1e-9)
    places = np.ix_(PLACES, PLACES)
    np.testing.assert_allclose(
        restored_covariance[places], covariance[places], rtol=1e-9, atol=1e-9
    )
    others = [place for place in Index if place not in PLACES]
    np.testing.assert_allclose(restored_mean[others], 0.0, atol=1e-12)
    np.testing.assert_allclose(restored_covariance[others], np.eye(STATES)[others], atol=1e-12)


@exactly
@given(members(), st.sampled_from([math.inf, 1e300, 1e4 * 365.0 * DAY]))
def test_restored_after_very_long_the_belief_is_the_prior(components, elapsed) -> None:
    restored = restore(learn(components), DRIVE, MEAN, STDDEV, DRIFT, elapsed)
    mean, covariance = moments(restored.components)
    np.testing.assert_allclose(mean, 0.0, atol=1e-9)
    np.testing.assert_allclose(covariance, np.eye(STATES), atol=1e-9)
    assert "years old" in restored.note


def test_the_longer_the_pause_the_likelier_the_tension_was_changed() -> None:
    """And only the tension: what is known of kf does not depend on it."""
    law = forgetting(MEAN, STDDEV, DRIFT)
    for elapsed in (HOUR, DAY, 7.0 * DAY):
        kept, changed = aged(learn(one()).components, law, elapsed)
        share = 1.0 - math.exp(-STANDING * DRIFT.tension_changes * elapsed)
        assert math.exp(changed.log_weight) == pytest.approx(share)
        assert math.exp(kept.log_weight) == pytest.approx(1.0 - share)
        assert changed.mean[0] == MEAN[Index.LOG_TENSION]
        assert changed.covariance[0, 0] == pytest.approx(STDDEV[Index.LOG_TENSION] ** 2)
        assert np.all(changed.covariance[0, 1:] == 0.0)
        assert np.array_equal(changed.mean[1:], kept.mean[1:])
        assert np.array_equal(changed.covariance[1:, 1:], kept.covariance[1:, 1:])


@pytest.mark.parametrize("elapsed", [-1.0, -1e9, -math.inf, math.nan])
def test_a_clock_that_was_set_back_ages_nothing_and_is_noted(elapsed) -> None:
    learned = learn(one())
    restored = restore(learned, DRIVE, MEAN, STDDEV, DRIFT, elapsed)
    assert "clock was set back" in restored.note
    fresh = restore(learned, DRIVE, MEAN, STDDEV, DRIFT, 0.0)
    assert_same(restored.components, fresh.components, 1e-15)


@exactly
@given(members(most=50), st.floats(0.0, 100.0 * DAY))
def test_what_is_restored_is_proper_and_bounded(components, elapsed) -> None:
    restored = restore(learn(components), DRIVE, MEAN, STDDEV, DRIFT, elapsed).components
    assert 1 <= len(restored) <= MEMBERS
    for component in restored:
        assert not component.changing
        unit = np.sqrt(np.diag(component.covariance))
        correlation = component.covariance / np.outer(unit, unit)
        assert np.array_equal(component.covariance, component.covariance.T)
        assert np.min(np.linalg.eigvalsh(correlation)) >= -1e-9


def test_what_is_restored_owns_its_numbers() -> None:
    learned = learn(one())
    restored = restore(learned, DRIVE, MEAN, STDDEV, DRIFT, 0.0).components[0]
    before = learned.means.copy()
    restored.mean += 1.0
    restored.covariance *= 2.0
    assert np.array_equal(learned.means, before)
    assert STDDEV[0] == 1.0


@pytest.mark.parametrize(
    ("other", "phrase"),
    [
        (dataclasses.replace(DRIVE, belt=Belt(7e4, 0.1036)), "axial_stiffness was 80068, is 70000"),
        (
            dataclasses.replace(DRIVE, driver=Pulley(0.07, 2.9, 0.6, 2e8)),
            "driver_radius was 0.06, is 0.07",
        ),
        (
            dataclasses.replace(DRIVE, tensioning=Tensioning.FIXED_CENTRES),
            "tensioning was constant_mean, is fixed_centres",
        ),
    ],
)
def test_the_memory_of_another_drive_is_refused_and_says_what_differs(other, phrase) -> None:
    with pytest.raises(MemoryRefusedError, match=phrase):
        restore(learn(one()), other, MEAN, STDDEV, DRIFT, 0.0)


def test_a_corrected_inertia_or_another_guess_of_friction_is_no_other_drive() -> None:
    driven = dataclasses.replace(DRIVE.driven, inertia=0.5, friction_coefficient=0.25)
    driver = dataclasses.replace(DRIVE.driver, friction_coefficient=0.3)
    other = dataclasses.replace(DRIVE, driven=driven, driver=driver)
    assert fingerprint(DRIVE).differences(fingerprint(other)) == []
