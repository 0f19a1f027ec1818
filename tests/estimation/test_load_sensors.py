"""Load readings against the tractions on the pulleys; `observe` against filterpy's stock filter."""

import dataclasses
import math

import numpy as np
import pytest
from filterpy.kalman import JulierSigmaPoints, UnscentedKalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.estimation.load_sensors import Load, load_readings, loads_of_tensions, observe
from belt_ros.estimation.state import STATES, Index, Reading, read
from belt_ros.estimation.unscented import GradedSigmaPoints
from belt_ros.mechanics import (
    Belt,
    BeltDrive,
    Pulley,
    Tensioning,
    drive_distribution,
    open_drive,
    solve_equilibrium,
    torque_capacity,
)
from belt_ros.mechanics.constants import drive_constants

REPEATABLE = settings(derandomize=True, deadline=None)
BELT = Belt(80068.0, 0.1036)
SMALL = Pulley(0.08125, math.pi, 0.5, 8.1e7, 0.05)
EQUAL = BeltDrive(BELT, SMALL, SMALL, 0.5105)
SLOWEST = 0.02


def state(tension: float, pull: float, speed: float) -> np.ndarray:
    row = np.zeros(STATES)
    row[[Index.DRIVER_SPEED, Index.DRIVEN_SPEED, Index.PULL]] = speed, speed, pull
    row[[Index.LOG_TENSION, Index.LOG_STIFFNESS, Index.LOG_FRICTION]] = np.log(
        [tension, 8.1e7, 0.5]
    )
    return row


def readings(drive: BeltDrive, *rows: np.ndarray) -> np.ndarray:
    c, states = drive_constants(drive), np.array(rows)
    return load_readings(c, states, read(c, states, SLOWEST))


def unequal(driven_radius: float, driver_radius: float) -> BeltDrive:
    return open_drive(BELT, driven_radius, driver_radius, 0.6, 0.5, 8.1e7)


def pressed(drive: BeltDrive, torque: float, tension: float, speed: float) -> list[np.ndarray]:
    """Forces on both shafts along and across the bisector: tractions integrated over the arcs."""
    found = drive_distribution(drive, torque, tension, speed, points=40001)
    forces = []
    for arc, pulley in ((found.driver, drive.driver), (found.driven, drive.driven)):
        angle = arc.angle - 0.5 * pulley.wrap_angle
        inward = -np.array([np.cos(angle), np.sin(angle)])
        along = np.array([-np.sin(angle), np.cos(angle)])
        traction = arc.normal_force * inward + arc.friction * along
        along_bisector, across = np.trapezoid(traction, pulley.radius * arc.angle, axis=1)
        forces.append(np.array([-along_bisector, across]))
    return forces


@pytest.mark.parametrize("share", [0.0, 0.4, 0.9])
@pytest.mark.parametrize("drive", [EQUAL, unequal(0.16, 0.05), unequal(0.04, 0.12)])
def test_hub_loads_are_what_normal_force_and_friction_add_up_to(drive, share) -> None:
    speed, tension = 300.0, 435.0
    torque = share * float(torque_capacity(drive, tension, speed))
    driver, driven = pressed(drive, torque, tension, speed)
    found = solve_equilibrium(drive, torque, tension, speed)
    c = drive_constants(drive)
    ends = float(found.tight_tension), float(found.slack_tension)
    loads = loads_of_tensions(c, *ends, torque, speed * drive.driver.radius)
    assert loads[Load.DRIVER_HUB] == pytest.approx(driver[0], rel=1e-5)
    assert loads[Load.DRIVEN_HUB] == pytest.approx(driven[0], rel=1e-5)
    # Across the bisector there is more, which no sensor here reads.
    for force, pulley in ((driver, drive.driver), (driven, drive.driven)):
        across = torque / drive.driven.radius * math.cos(0.5 * pulley.wrap_angle)
        assert abs(force[1]) == pytest.approx(abs(across), abs=0.01)


@pytest.mark.parametrize("drive", [unequal(0.16, 0.05), unequal(0.04, 0.12)])
def test_both_shafts_of_an_open_drive_are_pulled_together_alike(drive) -> None:
    row = readings(drive, state(435.0, 200.0, 90.0))[0]
    assert row[Load.DRIVER_HUB] == pytest.approx(row[Load.DRIVEN_HUB], rel=1e-12)
    assert row[Load.DRIVER_HUB] < 2.0 * 435.0


@pytest.mark.parametrize("speed", [0.0, -120.0, 400.0])
@pytest.mark.parametrize("pull", [-300.0, 0.0, 300.0])
def test_a_held_hub_load_is_what_the_sensor_reads(pull, speed) -> None:
    drive = dataclasses.replace(EQUAL, tensioning=Tensioning.CONSTANT_HUB_LOAD)
    row = readings(drive, state(435.0, pull, speed))[0]
    assert row[Load.DRIVER_HUB] == pytest.approx(2.0 * 435.0, rel=1e-9)
    assert row[Load.DRIVEN_HUB] == pytest.approx(2.0 * 435.0, rel=1e-9)


@pytest.mark.parametrize("tensioning", list(Tensioning))
@pytest.mark.parametrize("speed", [120.0, -120.0])
def test_the_span_is_tight_where_the_driven_pulley_is_pulled_forward(tensioning, speed) -> None:
    drive = dataclasses.replace(EQUAL, tensioning=tensioning)
    c = drive_constants(drive)
    states = np.array([state(435.0, pull, speed) for pull in (250.0, -250.0)])
    seen, loads = read(c, states, SLOWEST), readings(drive, *states)
    lift = 0.1036 * (120.0 * 0.08125) ** 2
    assert loads[0, Load.SPAN] == pytest.approx(seen[0, Reading.TIGHT_TENSION] - lift, rel=2e-4)
    assert loads[1, Load.SPAN] == pytest.approx(seen[1, Reading.SLACK_TENSION] - lift, rel=1e-12)
    # Half of what both spans pull with, and half of the pull.
    for row, pull in zip(loads, (250.0, -250.0), strict=True):
        assert 2.0 * row[Load.SPAN] - row[Load.DRIVEN_HUB] == pytest.approx(pull, rel=1e-6)


def test_readings_pass_smoothly_through_a_reversal_of_torque() -> None:
    pulls = np.linspace(-1.0, 1.0, 2001)
    loads = readings(EQUAL, *[state(435.0, pull, 120.0) for pull in pulls])
    slopes = np.diff(loads, axis=0) / np.diff(pulls)[:, None]
    np.testing.assert_allclose(slopes[:, Load.SPAN], 0.5, atol=1e-3)
    np.testing.assert_allclose(slopes[:, Load.DRIVER_HUB], 0.0, atol=1e-3)


def test_states_that_cannot_be_still_have_finite_readings() -> None:
    odd = [
        state(435.0, 5000.0, 120.0),  # beyond the capacity
        state(1.0, 0.0, 400.0),  # lifted off
        state(435.0, 1.0, 1e6),  # above the critical speed
        state(1e-30, 1e3, 1.0),
        state(1e30, -1e3, 0.0),
    ]
    for row in odd:
        assert np.all(np.isfinite(readings(EQUAL, row)))


def gaussian(seed: int, n: int = 4) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    scale = 10.0 ** random.uniform(-4.0, 3.0, n)
    root = random.standard_normal((n, n + 2)) * scale[:, None]
    return random.standard_normal(n) * scale, root @ root.T


def bent(x: np.ndarray) -> np.ndarray:
    return 3.0 * np.exp(np.tanh(x[0])) + np.sin(x[1]) + 0.5 * x[-1]


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("variance", [1e-6, 1.0, 1e4])
def test_an_observation_is_the_stock_filters(seed, variance) -> None:
    x, covariance = gaussian(seed)
    points = JulierSigmaPoints(4, kappa=1.0)
    stock = UnscentedKalmanFilter(4, 1, 1.0, hx=lambda x: [bent(x)], fx=None, points=points)
    stock.x, stock.P, stock.R = x.copy(), covariance.copy(), np.array([[variance]])
    stock.sigmas_f = points.sigma_points(x, covariance)
    drawn = stock.sigmas_f.copy()
    z = bent(x) + 0.3
    stock.update([z])
    ours = observe(x, covariance, drawn, points.Wm, np.array([bent(p) for p in drawn]), z, variance)
    scale = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(ours.x / scale, stock.x / scale, atol=1e-9)
    np.testing.assert_allclose(
        ours.covariance / scale / scale[:, None], stock.P / scale / scale[:, None], atol=1e-9
    )
    assert ours.innovation == pytest.approx(float(stock.y[0]), rel=1e-9)
    assert ours.variance == pytest.approx(float(stock.S[0, 0]), rel=1e-9)


def test_load_readings_enter_as_in_the_stock_filter() -> None:
    x = state(435.0, 250.0, 120.0)
    deviation = np.full(STATES, 1e-3)
    deviation[[Index.PULL, Index.LOG_TENSION, Index.LOG_STIFFNESS]] = 20.0, 0.2, 0.3
    covariance = np.diag(deviation**2)
    points = GradedSigmaPoints(range(STATES), [])
    drawn = points.sigma_points(x, covariance)
    stock = UnscentedKalmanFilter(
        STATES,
        1,
        1.0,
        hx=lambda row: readings(EQUAL, x, row)[1, [Load.SPAN]],
        fx=None,
        points=points,
    )
    stock.x, stock.P, stock.R, stock.sigmas_f = x.copy(), covariance.copy(), 4.0 * np.eye(1), drawn
    stock.update([600.0])
    ours = observe(x, covariance, drawn, points.Wm, readings(EQUAL, *drawn)[:, 2], 600.0, 4.0)
    np.testing.assert_allclose(ours.x / deviation, stock.x / deviation, atol=1e-9)
    np.testing.assert_allclose(
        ours.covariance / deviation / deviation[:, None],
        stock.P / deviation / deviation[:, None],
        atol=1e-9,
    )


@pytest.mark.parametrize("load", list(Load))
def test_one_load_sensor_settles_the_tension(load: Load) -> None:
    truth = state(435.0, 250.0, 120.0)
    z = float(readings(EQUAL, truth)[0, load])
    x, covariance = truth.copy(), np.diag(np.full(STATES, 1e-8))
    x[Index.LOG_TENSION] = math.log(330.0)
    covariance[Index.LOG_TENSION, Index.LOG_TENSION] = 0.3**2
    covariance[Index.PULL, Index.PULL] = 5.0**2
    points = GradedSigmaPoints(range(STATES), [])
    for _ in range(20):
        drawn = points.sigma_points(x, covariance)
        predicted = readings(EQUAL, *drawn)[:, load]
        x, covariance, *_ = observe(x, covariance, drawn, points.Wm, predicted, z, (0.01 * z) ** 2)
    spread = math.sqrt(covariance[Index.LOG_TENSION, Index.LOG_TENSION])
    assert spread < 0.01
    assert abs(x[Index.LOG_TENSION] - math.log(435.0)) < 2.0 * spread


@settings(REPEATABLE, max_examples=300)
@given(
    st.integers(0, 2**32 - 1),
    st.floats(-150.0, 150.0),
    st.floats(-30.0, 150.0),
    st.floats(allow_nan=True, allow_infinity=True),
    st.booleans(),
)
def test_a_covariance_stays_positive_semidefinite_whatever_is_read(
    seed, size, noise, z, of_the_points
) -> None:
    random = np.random.default_rng(seed)
    x, covariance = gaussian(seed)
    points = GradedSigmaPoints(range(4), [])
    drawn = points.sigma_points(x, covariance)
    shape = drawn[:, 0] - x[0] if of_the_points else random.standard_normal(len(drawn))
    predicted = 10.0**size * shape
    if z % 7.0 < 1.0:
        predicted[3] = [math.nan, math.inf][seed % 2]
    found = observe(x, covariance, drawn, points.Wm, predicted, z, 10.0**noise)
    assert np.all(np.isfinite(found.x))
    assert np.all(np.isfinite(found.covariance))
    assert math.isfinite(found.innovation)
    assert found.variance > 0.0
    np.testing.assert_array_equal(found.covariance, found.covariance.T)
    assert np.all(np.diag(found.covariance) >= 0.0)
    scale = np.sqrt(np.diag(covariance))
    normal = found.covariance / scale / scale[:, None]
    assert np.linalg.eigvalsh(normal)[0] >= -1e-13
    assert np.linalg.eigvalsh(covariance / scale / scale[:, None] - normal)[0] >= -1e-9


def test_the_sharpest_of_readings_repeated_leave_no_negative_variance() -> None:
    x, covariance = gaussian(5)
    before = np.diag(covariance)
    points = GradedSigmaPoints(range(4), [])
    for _ in range(500):
        drawn = points.sigma_points(x, covariance)
        predicted = np.array([bent(p) for p in drawn])
        x, covariance, *_ = observe(x, covariance, drawn, points.Wm, predicted, 7.0, 1e-24)
        assert np.all(np.isfinite(x))
        assert np.all(np.diag(covariance) >= 0.0)
        assert np.all(np.diag(covariance) <= before * (1.0 + 1e-9))


@pytest.mark.parametrize("odd", [math.nan, math.inf])
def test_what_is_not_finite_changes_nothing(odd: float) -> None:
    x, covariance = gaussian(2)
    points = GradedSigmaPoints(range(4), [])
    drawn = points.sigma_points(x, covariance)
    broken = drawn[:, 0].copy()
    broken[2] = odd
    for predicted, z in ((drawn[:, 0], odd), (broken, 1.0)):
        found = observe(x, covariance, drawn, points.Wm, predicted, z, 0.25)
        np.testing.assert_array_equal(found.x, x)
        np.testing.assert_array_equal(found.covariance, covariance)
        assert (found.innovation, found.variance) == (0.0, 0.25)
