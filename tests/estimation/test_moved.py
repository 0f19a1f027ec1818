"""What moved points make of mean and covariance: the unscented transform, of what moves."""

import numpy as np
import pytest

from belt_ros.estimation.moved import across, move_belief, slopes_of, together
from belt_ros.estimation.torque_told import Told
from belt_ros.estimation.unscented import GradedSigmaPoints, columns_along

POINTS = GradedSigmaPoints([2, 0, 1, 3, 4], [3.0, 4.0])
MOVING = np.array([0, 3])
ALONE = np.eye(5)[0]  # a sum that is the state itself
RANDOM = np.random.default_rng(2)
MEAN = RANDOM.standard_normal(5)
ROOT = RANDOM.standard_normal((5, 5))
COVARIANCE = ROOT @ ROOT.T
ROWS = RANDOM.standard_normal((2, 5))


def linear(points: np.ndarray) -> np.ndarray:
    moved = points.copy()
    moved[:, MOVING] = points @ ROWS.T
    return moved


def bent(points: np.ndarray) -> np.ndarray:
    moved = linear(points)
    moved[:, MOVING] += 0.1 * points[:, [1]] ** 2
    return moved


def belief_after(motion) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    known = Told(MEAN, COVARIANCE, np.zeros((1, 5)), np.zeros(1))
    columns = columns_along(COVARIANCE, POINTS.order, 0, ALONE)
    moved = motion(POINTS.sigma_points(MEAN, COVARIANCE))
    slopes = slopes_of(moved, MOVING, POINTS.spread)
    rows = np.zeros((1, 2))
    shared = together(known, columns, slopes, rows)
    mean, covariance = MEAN.copy(), COVARIANCE.copy()
    move_belief(mean, covariance, known.scores, rows, shared, moved, MOVING, POINTS.Wm)
    return mean, covariance, across(COVARIANCE, MOVING, shared)


@pytest.mark.parametrize("motion", [linear, bent])
def test_they_are_those_of_the_weighted_points(motion) -> None:
    points = POINTS.sigma_points(MEAN, COVARIANCE)
    moved = motion(points)
    mean = POINTS.Wm @ moved
    away = moved - mean
    mean_after, covariance_after, shared = belief_after(motion)
    np.testing.assert_allclose(mean_after, mean, atol=1e-12)
    np.testing.assert_allclose(covariance_after, (away.T * POINTS.Wm) @ away, atol=1e-12)
    np.testing.assert_allclose(shared, ((points - MEAN).T * POINTS.Wm) @ away, atol=1e-12)


def test_of_a_linear_motion_they_are_exact() -> None:
    matrix = np.eye(5)
    matrix[MOVING] = ROWS
    mean, covariance, shared = belief_after(linear)
    np.testing.assert_allclose(mean, matrix @ MEAN, atol=1e-12)
    np.testing.assert_allclose(covariance, matrix @ COVARIANCE @ matrix.T, atol=1e-12)
    np.testing.assert_allclose(shared, COVARIANCE @ matrix.T, atol=1e-12)


def test_what_stays_keeps_its_covariance_to_the_bit() -> None:
    staying = np.ix_([1, 2, 4], [1, 2, 4])
    np.testing.assert_array_equal(belief_after(bent)[1][staying], COVARIANCE[staying])
