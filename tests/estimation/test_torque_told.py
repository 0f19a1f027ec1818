"""Sigma points laid where torques say the load is: the same where the model is straight."""

import math

import numpy as np
import pytest
from scipy.stats import norm

from belt_ros.estimation.bank import UnscentedBank, motion_points
from belt_ros.estimation.process import Process
from belt_ros.estimation.state import STATES, Index, propagate
from belt_ros.estimation.torque_told import Torques, told
from belt_ros.mechanics import Belt, BeltDrive, Pulley
from belt_ros.mechanics.constants import drive_constants

PULLEY = Pulley(0.08125, np.pi, 1.2, 8.1e7, 0.05)
CONSTANTS = drive_constants(BeltDrive(Belt(80068.0, 0.1036), PULLEY, PULLEY, 0.5105))
DT = 0.02
LOADED = np.array([120.0, 119.2, 500.0, 41.0, -41.0, np.log(435.0), np.log(8e7), 0.18, 0, 0, 0, 0])
WIDE = np.array([0.01, 0.01, 80.0, 6.0, 6.0, 0.05, 0.2, 0.03, 1e-4, 0.01, 1e-3, 1e-3])
PLACES = np.array([Index.DRIVER_TORQUE, Index.DRIVEN_TORQUE])
STILL = Process(np.ones(STATES), np.zeros((STATES, STATES)), np.zeros(STATES))


def read(driver: float, driven: float, deviation: float = 0.2) -> Torques:
    return Torques(np.array([driver, driven]), np.full(2, deviation**2), PLACES)


def moved(torques: Torques | None, deviations: np.ndarray = WIDE, *, crosses: bool = False):
    bank = UnscentedBank(CONSTANTS, np.zeros(STATES))
    bank.x, bank.P = LOADED[np.newaxis].copy(), np.diag(deviations**2)[np.newaxis].copy()
    more = {} if torques is None else {"torques": torques}
    across = bank.predict(DT, (STILL, STILL), np.array([0]), crosses=crosses, **more)
    return bank.x[0], bank.P[0], across


def scaled(covariance: np.ndarray) -> np.ndarray:
    return covariance / np.outer(WIDE, WIDE)


def test_where_the_model_is_straight_it_does_not_matter_where_points_are_laid() -> None:
    narrow = 1e-4 * WIDE
    x, p, _ = moved(None, narrow)
    at_reading, p_at_reading, _ = moved(read(41.0003, -41.0002, 2e-4), narrow)
    np.testing.assert_allclose((at_reading - x) / narrow, 0.0, atol=2e-3)
    np.testing.assert_allclose(1e8 * scaled(p_at_reading - p), 0.0, atol=2e-3)


def test_it_is_posterior_linearisation_by_the_torques() -> None:
    """Against the same with full matrices, as the paper has it."""
    torques = read(36.0, -45.0)
    covariance = np.diag(WIDE**2)
    seen = np.eye(STATES)[PLACES]
    gain = covariance @ seen.T @ np.linalg.inv(seen @ covariance @ seen.T + 0.2**2 * np.eye(2))
    mean = LOADED + gain @ (torques.z - seen @ LOADED)
    left = covariance - gain @ seen @ covariance
    points_of = motion_points(CONSTANTS, DT)
    points = points_of.sigma_points(mean, left)
    after = propagate(CONSTANTS, points, DT)
    weights = points_of.Wm
    mean_after = weights @ after
    about, about_after = points - mean, after - mean_after
    slope = np.linalg.solve(left, (about.T * weights) @ about_after).T
    own = (about_after.T * weights) @ about_after - slope @ left @ slope.T
    x, p, crosses = moved(torques, crosses=True)
    np.testing.assert_allclose((x - mean_after - slope @ (LOADED - mean)) / WIDE, 0.0, atol=1e-8)
    expected = slope @ covariance @ slope.T + own
    np.testing.assert_allclose(scaled(p - expected), 0.0, atol=1e-8)
    np.testing.assert_allclose(scaled(crosses[0] - covariance @ slope.T), 0.0, atol=1e-8)


def test_a_reading_beyond_belief_lays_no_points() -> None:
    x, p, _ = moved(None)
    spiked, p_spiked, _ = moved(read(200.0, 90.0))
    np.testing.assert_array_equal(spiked, x)
    np.testing.assert_array_equal(p_spiked, p)


def test_a_reading_of_what_is_known_as_well_lays_no_points() -> None:
    """While a load stays as it is, points are laid as ever, at no cost."""
    calm = WIDE.copy()
    calm[PLACES] = 0.05
    x, p, _ = moved(None, calm)
    again, p_again, _ = moved(read(41.1, -41.2), calm)
    np.testing.assert_array_equal(again, x)
    np.testing.assert_array_equal(p_again, p)


def test_a_state_by_the_readings_and_what_they_took_make_the_whole_again() -> None:
    covariance = np.diag(WIDE**2)
    pull, torque = Index.PULL, Index.DRIVER_TORQUE
    covariance[pull, torque] = covariance[torque, pull] = 300.0
    known = told(LOADED, covariance, read(43.0, -36.0))
    whole = known.covariance + known.taken.T @ known.taken
    np.testing.assert_allclose(scaled(whole), scaled(covariance), atol=1e-12)
    np.testing.assert_allclose(known.mean - known.taken.T @ known.scores, LOADED, atol=1e-9)
    assert np.all(np.diag(known.covariance)[PLACES] < 0.2**2)


@pytest.mark.parametrize("tension", [330.0, 345.0, 365.0])
def test_near_its_knee_a_belt_is_foretold_by_the_load_that_there_is(tension: float) -> None:
    """The load of a step is known to 0.2 N m only by its readings; before them, to 6 N m."""
    c, at = CONSTANTS, Index.DRIVEN_SPEED
    x = LOADED.copy()
    x[Index.LOG_TENSION] = math.log(tension)
    alone, by_load = np.full(STATES, 1e-9), np.zeros(STATES)
    alone[[0, 1, 2, 3, 4]] = 0.01, 0.01, 2.0, 0.1, 0.1
    by_load[[2, 3, 4]] = 6.0 / PULLEY.radius, 6.0, -6.0
    covariance = np.diag(alone**2) + np.outer(by_load, by_load)
    torques = read(41.0, -41.0)

    def foretold(more: dict[str, Torques]) -> float:
        bank = UnscentedBank(c, np.zeros(STATES))
        bank.x, bank.P = x[np.newaxis].copy(), covariance[np.newaxis].copy()
        bank.predict(DT, (STILL, STILL), np.array([0]), **more)
        bank.update(torques.z, torques.variance, torques.places)
        return float(bank.x[0, at])

    random = np.random.default_rng(5)
    draws = x + alone * random.standard_normal((40_000, STATES))
    draws += np.outer(random.standard_normal(40_000), by_load)
    after = propagate(c, draws, DT)
    fit = norm.pdf(draws[:, 3], 41.0, 0.2) * norm.pdf(draws[:, 4], -41.0, 0.2)
    exact = float(fit @ after[:, at] / fit.sum())
    off = abs(foretold({"torques": torques}) - exact)
    assert off < 0.3 * abs(foretold({}) - exact)
