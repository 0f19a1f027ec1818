"""The compiled filter against filterpy's stock class with a plain model."""

import dataclasses

import numpy as np
import pytest
from filterpy.kalman import UnscentedKalmanFilter

from belt_ros.estimation.bank import POINTS, UnscentedBank, motion_points
from belt_ros.estimation.process import Process
from belt_ros.estimation.state import (
    STATES,
    Index,
    Reading,
    propagate,
    read,
    step_direction,
)
from belt_ros.estimation.unscented import GradedSigmaPoints, take_in
from belt_ros.mechanics import Belt, BeltDrive, Pulley
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.drive import Tensioning
from belt_ros.mechanics.motion import Condition, Motion, step_at_speed

PULLEY = Pulley(0.08125, np.pi, 1.2, 8.1e7, 0.05)
DRIVE = BeltDrive(Belt(80068.0, 0.1036), PULLEY, PULLEY, 0.5105)
CONSTANTS = drive_constants(DRIVE)
X = np.array([120.0, 119.2, 500.0, 41.0, -41.0, np.log(435.0), np.log(8e7), 0.18, 0, 0, 0, 0])
DEVIATION = np.array([0.01, 0.01, 20.0, 1.0, 1.0, 0.05, 0.2, 0.03, 1e-4, 0.01, 1e-3, 1e-3])
SEEN = np.array([0, 1, 3, 4])
VARIANCE = np.array([0.012, 0.012, 0.3, 0.3]) ** 2
DT = 0.01


STILL = Process(np.ones(STATES), np.zeros((STATES, STATES)), (0.01 * DEVIATION) ** 2)


def bank(members: int) -> UnscentedBank:
    bank = UnscentedBank(CONSTANTS, np.zeros(STATES))
    bank.x = np.tile(X, (members, 1))
    bank.P = np.tile(np.diag(DEVIATION**2), (members, 1, 1))
    return bank


def belt_speed(x: np.ndarray) -> float:
    return abs(CONSTANTS.driver_radius * x[Index.DRIVER_SPEED])


def plain_step(x: np.ndarray, dt: float, speed: float, constants: object = CONSTANTS) -> np.ndarray:
    """One state moved by the drive's law alone, solved from nothing known."""
    tension, stiffness, friction = np.exp(x[Index.LOG_TENSION : Index.LOG_FRICTION + 1])
    beside = x[Index.RATIO_BIAS : Index.TRAVEL]
    condition = Condition(x[3], x[4], tension, friction, stiffness, *beside)
    moved = step_at_speed(constants, Motion(*x[:3]), condition, speed, dt)
    driver = constants.driver_radius * 0.5 * (x[0] + moved.driver_speed)
    driven = constants.driven_radius * 0.5 * (x[1] + moved.driven_speed)
    travel = x[Index.TRAVEL] + dt * (driver - driven)
    return np.array([*moved, *x[3 : Index.TRAVEL], travel])


def stock() -> UnscentedKalmanFilter:
    filter_ = UnscentedKalmanFilter(
        STATES,
        len(SEEN),
        DT,
        hx=lambda x: x[SEEN],
        fx=plain_step,
        points=motion_points(CONSTANTS, DT),
    )
    filter_.x, filter_.P = X.copy(), np.diag(DEVIATION**2)
    filter_.Q = np.diag((0.01 * DEVIATION) ** 2)
    filter_.R = np.diag(VARIANCE)
    return filter_


def test_each_member_equals_the_stock_filter_over_many_steps() -> None:
    ours, theirs = bank(2), stock()
    rng = np.random.default_rng(3)
    for _ in range(50):
        z = X[SEEN] + np.sqrt(VARIANCE) * rng.standard_normal(4)
        ours.predict(DT, (STILL, STILL), np.array([0, 1]))
        theirs.predict(DT, speed=belt_speed(theirs.x))
        ours.update(z, VARIANCE, SEEN)
        theirs.update(z)
        scale = np.sqrt(np.diag(theirs.P))
        for x, covariance in zip(ours.x, ours.P, strict=True):
            np.testing.assert_allclose(x / scale, theirs.x / scale, rtol=1e-9, atol=1e-9)
            np.testing.assert_allclose(
                covariance / scale / scale[:, None], theirs.P / scale / scale[:, None], atol=1e-9
            )


def test_what_fades_returns_to_its_anchor_and_takes_part_in_the_motion() -> None:
    memory, faded = np.ones(STATES), np.zeros(STATES)
    memory[5], faded[5] = 0.5, 0.3**2
    added = np.diag(faded)
    added[5, 6] = added[6, 5] = 1e-3
    ours = bank(1)
    ours.predict(DT, (Process(memory, added, np.zeros(STATES)),) * 2, np.array([0]))
    assert ours.P[0, 5, 6] == pytest.approx(1e-3, rel=1e-6)
    assert ours.x[0, 5] == pytest.approx(0.5 * X[5])
    assert ours.P[0, 5, 5] == pytest.approx((0.5 * DEVIATION[5]) ** 2 + 0.3**2)
    assert ours.P[0, 5, 2] != 0.0


def test_missing_sensors_leave_what_they_do_not_touch() -> None:
    covariance = np.diag(DEVIATION**2)
    x, p = take_in(X, covariance, np.array([121.0]), np.array([1e-4]), np.array([0]))
    assert x[0] != X[0]
    np.testing.assert_array_equal(x[1:], X[1:])
    assert np.all(np.diag(p)[1:] == np.diag(covariance)[1:])


@pytest.mark.parametrize("scale", [1.0, 1e6, 1e15])
@pytest.mark.parametrize("seed", range(5))
def test_however_much_a_reading_tells_covariances_stay_within_their_variances(
    scale: float, seed: int
) -> None:
    random = np.random.default_rng(seed)
    root = random.standard_normal((STATES, 3)) * 10.0 ** random.uniform(-3.0, 3.0, (STATES, 1))
    covariance = scale**2 * np.einsum("ik,jk->ij", root, root)  # all depend on three
    covariance = 0.5 * (covariance + covariance.T)
    seen = np.array([Index.DRIVER_SPEED, Index.DRIVEN_SPEED, Index.DRIVER_TORQUE, Index.TRAVEL])
    _, p = take_in(X, covariance, X[seen], np.full(4, 1e-6), seen)
    variances = np.diag(p)
    assert np.all(variances > 0.0)
    np.testing.assert_array_equal(p, p.T)
    rounding = 1e-14 * np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
    assert np.all(np.abs(p) <= np.sqrt(np.outer(variances, variances)) + rounding)
    for at in seen[-1:]:  # the last one read is known as well as it can be
        assert np.all(np.abs(p[at]) <= (1.0 + 1e-9) * np.sqrt(p[at, at] * variances))


@pytest.mark.parametrize("pull", [0.0, 8.0, 15.0])
def test_the_margin_of_an_idle_drive_is_as_uncertain_as_its_pull(pull: float) -> None:
    """Near none, most of what the pull may be has the same size either way."""
    idle = bank(1)
    idle.x[:, Index.PULL], idle.P[:, Index.PULL, Index.PULL] = pull, 8.0**2
    (means,), (deviations,) = idle.read(np.array([0]), 0.02)
    share = 8.0 * CONSTANTS.driven_radius / means[Reading.CAPACITY]
    assert share <= deviations[Reading.MARGIN] < 1.2 * share


def test_points_of_a_covariance_that_rounding_made_indefinite_are_finite() -> None:
    covariance = np.ones((3, 3))
    covariance[0, 1] = covariance[1, 0] = 1.0 + 1e-12
    points = GradedSigmaPoints([2, 0, 1], [3.0]).sigma_points(np.zeros(3), covariance)
    assert np.all(np.isfinite(points))
    assert points.shape == (7, 3)


def correlated(seed: int) -> np.ndarray:
    root = np.random.default_rng(seed).standard_normal((STATES, STATES)) * DEVIATION[:, None]
    return root @ root.T / STATES


@pytest.mark.parametrize("chosen", [POINTS, motion_points(CONSTANTS, DT)])
def test_points_reproduce_mean_and_covariance(chosen: GradedSigmaPoints) -> None:
    covariance = correlated(1)
    points, weights = chosen.sigma_points(X, covariance), chosen.Wm
    assert weights.sum() == pytest.approx(1.0)
    assert np.all(weights >= 0.0)
    spread = points - X
    np.testing.assert_allclose(weights @ points, X, rtol=1e-12, atol=1e-15)
    scale = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(
        (spread.T * weights) @ spread / scale / scale[:, None],
        covariance / scale / scale[:, None],
        atol=1e-9,
    )


def test_near_states_that_leave_no_weight_are_refused() -> None:
    with pytest.raises(ValueError, match="leave"):
        GradedSigmaPoints(range(4), [1.5, 3.0])


def test_only_five_pairs_of_points_change_what_a_step_has_to_solve() -> None:
    points = motion_points(CONSTANTS, DT).sigma_points(X, correlated(2))
    belt = [Index.LOG_TENSION, Index.LOG_STIFFNESS, Index.LOG_FRICTION, Index.CREEP_ERROR]
    moved = (points - X) @ step_direction(CONSTANTS, X, DT)
    others = np.r_[6 : 1 + STATES, 6 + STATES : 1 + 2 * STATES]
    np.testing.assert_array_equal(points[others][:, belt], np.tile(X[belt], (len(others), 1)))
    np.testing.assert_allclose(moved[others], 0.0, atol=1e-9 * np.max(np.abs(moved)))


TENSIONINGS = pytest.mark.parametrize(
    ("tensioning", "tolerance"),
    [(Tensioning.CONSTANT_MEAN, 1e-9), (Tensioning.FIXED_CENTRES, 3e-7)],
)


@TENSIONINGS
@pytest.mark.parametrize("log_stiffness", [14.5, 15.7, 18.2, 21.0])
@pytest.mark.parametrize("pull", [-500.0, -3.0, 0.0, 250.0, 600.0, 790.0])
def test_a_point_solved_beside_another_is_where_it_would_be_alone(
    tensioning: Tensioning, tolerance: float, log_stiffness: float, pull: float
) -> None:
    constants = drive_constants(dataclasses.replace(DRIVE, tensioning=tensioning))
    x = X.copy()
    x[Index.LOG_STIFFNESS], x[Index.PULL] = log_stiffness, pull
    points = motion_points(constants, DT).sigma_points(x, correlated(3))
    together = propagate(constants, points, DT)
    alone = np.array([plain_step(point, DT, belt_speed(x), constants) for point in points])
    np.testing.assert_allclose(together / DEVIATION, alone / DEVIATION, rtol=0.0, atol=tolerance)


@TENSIONINGS
@pytest.mark.parametrize("log_stiffness", [14.5, 15.7, 18.2, 21.0])
@pytest.mark.parametrize("pull", [-500.0, 0.0, 250.0, 600.0, 790.0])
def test_a_point_read_beside_another_reads_as_it_would_alone(
    tensioning: Tensioning, tolerance: float, log_stiffness: float, pull: float
) -> None:
    constants = drive_constants(dataclasses.replace(DRIVE, tensioning=tensioning))
    x = X.copy()
    x[Index.LOG_STIFFNESS], x[Index.PULL] = log_stiffness, pull
    covariance = correlated(4)
    covariance[:2] = covariance[:, :2] = 0.0  # so that each alone has the belt's speed of them all
    points = POINTS.sigma_points(x, covariance)
    points[:, :2] = x[:2]
    together = read(constants, points, 0.1)
    alone = np.vstack([read(constants, point[None, :], 0.1) for point in points])
    np.testing.assert_allclose(together, alone, rtol=tolerance, atol=1e-12)
