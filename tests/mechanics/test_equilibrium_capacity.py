"""The torque that a drive can carry, what of it is left, and what is refused beyond it."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from two_pulleys import PAPER_MASS, REPEATABLE, capacity_at, drives, paper_drive

from belt_ros.mechanics import (
    Belt,
    BeltDrive,
    DriveError,
    Pulley,
    Tensioning,
    margin,
    solve_equilibrium,
    torque_capacity,
)
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.creep import span_tensions


def slack_near_capacity(drive: BeltDrive, torque: float, held: float, speed: float) -> float:
    """Slack tension where a pulley is about to slip; there may be no steady state."""
    pull = (1.0 - 1e-9) * abs(torque) / drive.driven.radius
    friction = drive.driven.friction_coefficient, drive.driven.friction_stiffness
    rim = abs(speed) * drive.driver.radius
    return span_tensions(drive_constants(drive), pull, held, *friction, rim, torque * speed > 0.0)[
        0
    ]


@given(drives(massless=True, equal=True))
@REPEATABLE
def test_capacity_of_equal_pulleys_at_held_mean_tension(
    given_drive: tuple[BeltDrive, float, float],
) -> None:
    drive, tension, _ = given_drive
    drive = replace(drive, tensioning=Tensioning.CONSTANT_MEAN)
    expected = 2.0 * tension * math.tanh(0.5 * drive.driven.traction_limit) * drive.driven.radius
    assert float(torque_capacity(drive, tension)) == pytest.approx(expected, rel=1e-13)


@given(drives())
@REPEATABLE
def test_capacity_is_the_traction_limit_of_the_pulley_that_slips_first(
    given_drive: tuple[BeltDrive, float, float],
) -> None:
    drive, held, speed = given_drive
    capacity = float(torque_capacity(drive, held, speed))
    pull = capacity / drive.driven.radius
    lift = drive.belt.mass_per_length * (speed * drive.driver.radius) ** 2
    limit = min(drive.driven.traction_limit, drive.driver.traction_limit)
    share = 1.0 - lift / drive.belt.axial_stiffness
    if drive.tensioning is Tensioning.FIXED_CENTRES:
        slack = slack_near_capacity(drive, math.copysign(capacity, speed), held, speed) - lift
        assert math.log1p(pull / slack) == pytest.approx(limit, rel=1e-8, abs=2e-9 * pull / slack)
        return
    slack = {
        Tensioning.CONSTANT_MEAN: held - lift - 0.5 * pull / share,
        Tensioning.CONSTANT_SLACK: held - lift,
        Tensioning.CONSTANT_HUB_LOAD: held - 0.5 * pull,
    }[drive.tensioning]
    rounding = 1e-15 * held / slack
    assert math.log1p(pull / slack) == pytest.approx(limit, rel=1e-13, abs=8 * rounding)


def test_inertia_takes_its_share_of_the_capacity() -> None:
    drive = paper_drive(8.1e7, PAPER_MASS)
    lift = PAPER_MASS * 9.75**2
    expected = 2.0 * (435.0 - lift) * math.tanh(0.6 * math.pi) * 0.08125
    capacity = float(torque_capacity(drive, 435.0, 120.0))
    assert capacity == pytest.approx(expected, rel=lift / 80068.0)
    assert capacity < float(torque_capacity(drive, 435.0)) * (1.0 - 0.99 * lift / 435.0)


@pytest.mark.parametrize("tensioning", list(Tensioning))
def test_the_smallest_traction_limit_governs_whichever_pulley_has_it(
    tensioning: Tensioning,
) -> None:
    strong, weak = Pulley(0.1, 3.3, 0.9, 5e7), Pulley(0.06, 2.6, 0.8, 9e7)
    belt = Belt(6e4)
    for driven, driver in ((strong, weak), (weak, strong)):
        drive = BeltDrive(belt, driven, driver, tensioning=tensioning)
        growth = math.expm1(weak.traction_limit)
        for sign in (1.0, -1.0):
            capacity = float(torque_capacity(drive, 300.0, regenerating=sign < 0.0))
            if tensioning is Tensioning.FIXED_CENTRES:
                slack = slack_near_capacity(drive, sign * capacity, 300.0, 50.0)
                assert capacity == pytest.approx(slack * growth * driven.radius, rel=1e-7)
            else:
                held = tensioning is not Tensioning.CONSTANT_SLACK
                pull = 300.0 * growth / (1.0 + 0.5 * growth) if held else 300.0 * growth
                assert capacity == pytest.approx(pull * driven.radius, rel=1e-14)
            near = solve_equilibrium(drive, sign * capacity * (1.0 - 1e-3), 300.0, 50.0)
            angles = [float(near.driven_transition_angle), float(near.driver_transition_angle)]
            if driven is strong:
                angles.reverse()
            assert angles[0] < 0.02
            assert angles[1] > 0.1


@pytest.mark.parametrize("torque", [0.0, 12.0, -30.0])
def test_margin_is_the_reserve_of_torque(torque: float) -> None:
    drive = paper_drive(8.1e7, PAPER_MASS)
    capacity = float(torque_capacity(drive, 435.0, 120.0))
    expected = pytest.approx(1.0 - abs(torque) / capacity, rel=1e-14)
    assert float(margin(drive, torque, 435.0, 120.0)) == expected
    state = solve_equilibrium(drive, torque, 435.0, 120.0)
    assert float(state.margin) == expected
    assert float(state.torque_capacity) == capacity


def test_margin_is_negative_beyond_capacity() -> None:
    drive = paper_drive(8.1e7)
    capacity = float(torque_capacity(drive, 435.0))
    assert float(margin(drive, -1.25 * capacity, 435.0)) == pytest.approx(-0.25)


@pytest.mark.parametrize("torque", [math.nan, math.inf])
def test_margin_of_a_torque_that_is_not_finite_is_refused(torque: float) -> None:
    with pytest.raises(DriveError, match="NaN or infinity"):
        margin(paper_drive(8.1e7), torque, 435.0)


def test_torque_beyond_capacity_is_refused_with_both_numbers() -> None:
    drive = paper_drive(8.1e7)
    limit = f"{float(torque_capacity(drive, 435.0)):g}"
    for torque in (70.0, -70.0):
        message = rf"^torque {torque:g} N m is not within the capacity of {limit} N m: gross slip$"
        with pytest.raises(DriveError, match=message):
            solve_equilibrium(drive, torque, 435.0, 120.0)


def refusal(drive: BeltDrive, torque: float, held: float, speed: float) -> str:
    """Why there is no equilibrium, nothing if there is one."""
    try:
        solve_equilibrium(drive, torque, held, speed)
    except DriveError as error:
        return str(error)
    return ""


@given(drives())
@REPEATABLE
def test_beyond_capacity_is_called_gross_slip_and_nothing_else(
    given_drive: tuple[BeltDrive, float, float],
) -> None:
    drive, held, speed = given_drive
    capacity = math.copysign(capacity_at(drive, held, speed, speed), speed)
    assert "gross slip" in refusal(drive, 2.0 * capacity, held, speed)
    assert "gross slip" in refusal(drive, capacity, held, speed)
    within_rounding = refusal(drive, (1.0 - 2e-16) * capacity, held, speed)
    assert not within_rounding or "gross slip" in within_rounding
