"""Slip against torque: each gives the other back, and turning the drive round mirrors both."""

import math

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from two_pulleys import PAPER_MASS, REPEATABLE, capacity_at, drives, paper_drive, slip_at

from belt_ros.mechanics import (
    Belt,
    BeltDrive,
    DriveError,
    Kinematics,
    Pulley,
    Tensioning,
    solve_equilibrium,
    torque_capacity,
    torque_from_slip,
)


def between_fixed_centres(driven: Pulley, driver: Pulley) -> tuple[BeltDrive, float, float]:
    """A drive stretched by 2 %, its held tension and speed."""
    fixed = {"kinematics": Kinematics.EXACT, "tensioning": Tensioning.FIXED_CENTRES}
    return BeltDrive(Belt(8103.0), driven, driver, span_length=0.5, **fixed), 148.4, 1.0


@given(drives(), st.floats(-0.9999, 0.9999))
@example(
    between_fixed_centres(Pulley(0.05, 1.125, 1.0, 3.27e6), Pulley(0.082, 2.5, 0.5, 1.2e6)), 0.996
)
@example(
    between_fixed_centres(Pulley(0.368, 1.0, 1.0, 6e4), Pulley(0.135, 1.0, 2.0, 4.42e5)), 0.9999
)
@settings(REPEATABLE, max_examples=400)
def test_slip_to_torque_to_slip_returns_the_slip(
    given_drive: tuple[BeltDrive, float, float], load: float
) -> None:
    drive, held, speed = given_drive
    capacity = capacity_at(drive, held, speed, load)
    torque = load * capacity
    slip = slip_at(drive, torque, held, speed)
    assume(slip > -math.inf)
    again = float(torque_from_slip(drive, slip, held, speed))
    assert again == pytest.approx(torque, rel=0, abs=1e-11 * capacity)
    back = float(solve_equilibrium(drive, again, held, speed).slip)
    lost = 0.0
    if (drive.tensioning, drive.kinematics) == (Tensioning.FIXED_CENTRES, Kinematics.EXACT):
        # The tension is a small difference of lengths. The digits that rounding takes of it show in
        # slip the more, the steeper it is.
        steepness = abs(slip - slip_at(drive, torque * (1.0 - 1e-6), held, speed)) / 1e-6
        lost = 5e-16 * drive.belt.axial_stiffness / held * steepness
    assert back == pytest.approx(slip, rel=1e-9, abs=1e-15 + lost)


@pytest.mark.parametrize("load", [-0.9, -0.5, 0.1, 0.3, 0.5, 0.9])
@pytest.mark.parametrize("growth", [0.99, 1.0, 2.0])
def test_slip_returns_the_torque_where_friction_is_compliant(growth: float, load: float) -> None:
    pulley = Pulley(1.0, 1.0, 1.0, 1e4 / growth**2)
    drive = BeltDrive(Belt(1e4), pulley, pulley)
    torque = load * float(torque_capacity(drive, 100.0))
    slip = float(solve_equilibrium(drive, torque, 100.0, 1.0).slip)
    assert float(torque_from_slip(drive, slip, 100.0, 1.0)) == pytest.approx(torque, rel=1e-12)


@pytest.mark.parametrize("torque", [1e-9, 1e-6, 1e-3])
def test_the_smallest_loads_keep_their_digits(torque: float) -> None:
    drive = paper_drive(8.1e7, PAPER_MASS)
    slip = float(solve_equilibrium(drive, torque, 435.0, 120.0).slip)
    assert float(torque_from_slip(drive, slip, 435.0, 120.0)) == pytest.approx(torque, rel=1e-11)


@given(drives())
@settings(REPEATABLE, max_examples=60)
def test_torque_rises_with_slip_into_gross_slip(
    given_drive: tuple[BeltDrive, float, float],
) -> None:
    drive, held, speed = given_drive
    fine = np.geomspace(1e-9, 5.0, 80)
    slip = np.concatenate([-fine[::-1], [0.0], fine])
    torque = torque_from_slip(drive, slip, held, speed) * math.copysign(1.0, speed)
    capacity = float(torque_capacity(drive, held, speed))
    assert np.all(np.isfinite(torque))
    assert torque[80] == 0.0
    assert np.all(np.diff(torque) >= -1e-15 * capacity)
    small = np.abs(torque) < (1.0 - 1e-9) * capacity
    assert np.all(np.diff(torque)[small[1:] & small[:-1]] > 0.0)


def assert_within_capacity(drive: BeltDrive, held: float, speed: float) -> None:
    slip = np.array([-5.0, -0.5, -0.05, 0.05, 0.5, 5.0])
    torque = np.abs(torque_from_slip(drive, slip, held, speed))
    assert np.all(torque <= torque_capacity(drive, held, speed, slip < 0.0))


@given(drives(massless=True))
@settings(REPEATABLE, max_examples=60)
def test_torque_stays_within_capacity_at_any_slip(
    given_drive: tuple[BeltDrive, float, float],
) -> None:
    assert_within_capacity(*given_drive)


@given(drives())
@settings(REPEATABLE, max_examples=60)
def test_torque_of_a_heavy_belt_stays_within_capacity_at_any_slip(
    given_drive: tuple[BeltDrive, float, float],
) -> None:
    assert_within_capacity(*given_drive)


@given(drives(), st.sampled_from([1.0, -1.0]))
@settings(REPEATABLE, max_examples=100)
def test_slip_grows_strictly_with_torque(
    given_drive: tuple[BeltDrive, float, float], sign: float
) -> None:
    drive, held, speed = given_drive
    capacity = capacity_at(drive, held, speed, sign)
    loads = np.linspace(0.0, 0.97, 50)
    slips = np.array([slip_at(drive, sign * load * capacity, held, speed) for load in loads])
    direction = sign * math.copysign(1.0, speed)
    assert slips[0] == 0.0
    finite = slips[np.isfinite(slips)]
    assert np.all(direction * np.diff(finite) > 0.0)
    assert np.all(np.isinf(slips[len(finite) :]))


@pytest.mark.parametrize("mass", [0.0, PAPER_MASS])
def test_slip_has_an_asymptote_at_capacity(mass: float) -> None:
    drive = paper_drive(2.8e7, mass)
    capacity = float(torque_capacity(drive, 435.0, 120.0))
    near, nearer = (
        solve_equilibrium(drive, capacity * (1.0 - gap), 435.0, 120.0) for gap in (1e-6, 1e-8)
    )
    ratio = float(nearer.driven_inlet_gradient / near.driven_inlet_gradient)
    assert ratio == pytest.approx(100.0, rel=1e-2)
    assert float(nearer.slip) > 1.0


@given(drives(), st.floats(-0.999, 0.999))
@REPEATABLE
def test_rotation_reversal_mirrors_the_drive(
    given_drive: tuple[BeltDrive, float, float], load: float
) -> None:
    drive, held, speed = given_drive
    torque = load * capacity_at(drive, held, speed, load)
    try:
        one = solve_equilibrium(drive, torque, held, speed)
    except DriveError:
        with pytest.raises(DriveError, match="slip beyond 100 %"):
            solve_equilibrium(drive, -torque, held, -speed)
        return
    other = solve_equilibrium(drive, -torque, held, -speed)
    assert float(other.driven_speed) == -float(one.driven_speed)
    for name in set(one._fields) - {"driven_speed"}:
        np.testing.assert_array_equal(getattr(other, name), getattr(one, name))
    slip = float(one.slip)
    assert float(torque_from_slip(drive, slip, held, -speed)) == -float(
        torque_from_slip(drive, slip, held, speed)
    )


@given(drives(massless=True, equal=True), st.floats(0.0, 0.99))
@REPEATABLE
def test_torque_reversal_inverts_the_speed_ratio_of_equal_pulleys(
    given_drive: tuple[BeltDrive, float, float], load: float
) -> None:
    # Who gives and who receives change places: (1 - s(M)) (1 - s(-M)) = 1, odd to first order.
    drive, held, speed = given_drive
    torque = math.copysign(load * float(torque_capacity(drive, held)), speed)
    ahead = solve_equilibrium(drive, torque, held, speed)
    if float(ahead.slip) >= 1.0:
        with pytest.raises(DriveError, match="slip beyond 100 %"):
            solve_equilibrium(drive, -torque, held, speed)
        return
    behind = solve_equilibrium(drive, -torque, held, speed)
    product = (1.0 - float(ahead.slip)) * (1.0 - float(behind.slip))
    assert product == pytest.approx(1.0, rel=1e-13)
    assert float(behind.driven_transition_angle) == float(ahead.driver_transition_angle)
    assert float(behind.driver_inlet_gradient) == float(ahead.driven_inlet_gradient)


@given(drives(equal=True), st.floats(0.0, 0.95))
@REPEATABLE
def test_torque_reversal_nearly_inverts_the_speed_ratio_of_a_heavy_belt(
    given_drive: tuple[BeltDrive, float, float], load: float
) -> None:
    # Where the load drives, inertia is taken at rim speed: an error of creep times m v^2.
    drive, held, speed = given_drive
    torque = math.copysign(load * float(torque_capacity(drive, held, speed)), speed)
    ahead = solve_equilibrium(drive, torque, held, speed)
    slip = float(ahead.slip)
    assume(slip < 0.05)
    behind = solve_equilibrium(drive, -torque, held, speed)
    slack = float(ahead.slack_tension)
    lift = drive.belt.mass_per_length * (speed * drive.driver.radius) ** 2
    heaviness = lift / (slack - lift)
    product = (1.0 - slip) * (1.0 - float(behind.slip))
    assert product == pytest.approx(1.0, abs=1e-13 + 40.0 * slip**2 * heaviness)


@given(drives(massless=True), st.floats(0.01, 0.99))
@REPEATABLE
def test_without_inertia_slip_does_not_depend_on_speed(
    given_drive: tuple[BeltDrive, float, float], load: float
) -> None:
    drive, held, speed = given_drive
    torque = math.copysign(load * float(torque_capacity(drive, held)), speed)
    slips = [float(solve_equilibrium(drive, torque, held, speed * f).slip) for f in (1.0, 1e-6)]
    assert slips[0] == pytest.approx(slips[1], rel=1e-14)


def test_no_torque_means_no_slip() -> None:
    state = solve_equilibrium(paper_drive(8.1e7, PAPER_MASS), 0.0, 435.0, 120.0)
    assert float(state.slip) == 0.0
    assert float(state.driven_speed) == 120.0
    assert float(state.margin) == 1.0
    assert float(state.tight_tension) == float(state.slack_tension) == 435.0


def test_slip_is_smooth_through_torque_reversal() -> None:
    drive = paper_drive(8.1e7, PAPER_MASS)
    torque = np.linspace(-1e-3, 1e-3, 21)
    slip = solve_equilibrium(drive, torque, 435.0, 120.0).slip
    slope = np.diff(slip) / np.diff(torque)
    np.testing.assert_allclose(slope, slope.mean(), rtol=1e-6)


def test_standstill_is_the_limit_of_slow_rotation() -> None:
    drive = paper_drive(8.1e7, PAPER_MASS)
    torque = np.array([-40.0, 0.0, 25.0])
    still = solve_equilibrium(drive, torque, 435.0, 0.0)
    slow = solve_equilibrium(drive, torque, 435.0, 1e-9)
    np.testing.assert_allclose(still.slip, slow.slip, rtol=1e-12)
    np.testing.assert_array_equal(still.driven_speed, 0.0)
