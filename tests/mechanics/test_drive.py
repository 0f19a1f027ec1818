"""What a belt, a pulley and a drive refuse to be."""

import math
from dataclasses import FrozenInstanceError, replace
from typing import Any

import numpy as np
import pytest

from belt_ros.mechanics import Belt, BeltDrive, DriveError, Kinematics, Pulley, Tensioning

BELT = Belt(8e4, 0.1)
PULLEY = Pulley(0.08, 3.0, 0.9, 1e7)
DRIVE = BeltDrive(BELT, PULLEY, PULLEY)


@pytest.mark.parametrize(
    ("value", "shown"),
    [(0.0, "0"), (-1.5, "-1.5"), (math.nan, "nan"), (math.inf, "inf"), (-math.inf, "-inf")],
)
@pytest.mark.parametrize(
    ("thing", "field", "name", "unit"),
    [
        (BELT, "axial_stiffness", "belt axial stiffness EA", " N"),
        (PULLEY, "radius", "pulley radius", " m"),
        (PULLEY, "wrap_angle", "wrap angle", " rad"),
        (PULLEY, "friction_coefficient", "friction coefficient mu", ""),
        (PULLEY, "friction_stiffness", "friction stiffness kf", " N/m2"),
        (PULLEY, "inertia", "pulley inertia", " kg m2"),
        (DRIVE, "span_length", "span length", " m"),
    ],
)
def test_every_size_must_be_finite_and_positive(
    thing: Any, field: str, name: str, unit: str, value: float, shown: str
) -> None:
    message = f"^{name} is {shown}{unit}; it must be finite and > 0$"
    with pytest.raises(DriveError, match=message):
        replace(thing, **{field: value})


@pytest.mark.parametrize("mass", [-1e-9, math.nan, math.inf])
def test_belt_mass_must_be_finite_and_not_negative(mass: float) -> None:
    message = f"^belt mass per length is {mass:g} kg/m; it must be finite and >= 0$"
    with pytest.raises(DriveError, match=message):
        Belt(8e4, mass)


def test_a_belt_wraps_less_than_a_turn() -> None:
    assert replace(PULLEY, wrap_angle=6.28).wrap_angle == 6.28
    for angle in (2.0 * math.pi, 7.0):
        with pytest.raises(DriveError, match=rf"^wrap angle is {angle:g} rad; .*\(2 pi rad\)$"):
            replace(PULLEY, wrap_angle=angle)


def test_critical_speed_is_that_of_equation_72() -> None:
    assert Belt(8e4, 0.2).critical_speed == pytest.approx(math.sqrt(4e5))
    assert Belt(8e4).critical_speed == math.inf


def test_traction_limit_is_friction_times_wrap() -> None:
    assert PULLEY.traction_limit == pytest.approx(2.7)


def test_exact_kinematics_and_held_mean_tension_are_the_defaults() -> None:
    assert DRIVE.kinematics is Kinematics.EXACT
    assert DRIVE.tensioning is Tensioning.CONSTANT_MEAN


def test_without_inertia_changes_the_belts_mass_alone() -> None:
    light = DRIVE.without_inertia()
    assert light.belt.mass_per_length == 0.0
    assert replace(light, belt=BELT) == DRIVE
    assert DRIVE.belt.mass_per_length == 0.1


def test_a_drive_cannot_be_changed_in_place() -> None:
    for thing in (BELT, PULLEY, DRIVE):
        with pytest.raises(FrozenInstanceError):
            thing.__setattr__(next(iter(vars(thing))), 1.0)


def test_a_drive_error_is_a_value_error() -> None:
    assert issubclass(DriveError, ValueError)


def test_pulleys_of_an_open_belt_must_not_overlap() -> None:
    driven, driver = Pulley(0.1, 3.2, 0.5, 1e7), Pulley(0.09, 2.0 * math.pi - 3.2, 0.5, 1e7)
    with pytest.raises(DriveError, match=r"pulleys overlap: the span length is 0\.1 m.*0\.189737"):
        BeltDrive(Belt(1e4), driven, driver, span_length=0.1)
    BeltDrive(Belt(1e4), driven, driver, span_length=0.19)


def test_shorter_spans_are_left_to_belts_that_idlers_or_a_crossing_guide() -> None:
    pulley = Pulley(0.1, 3.9, 0.5, 1e7)
    assert BeltDrive(Belt(1e4), pulley, pulley, span_length=0.05).span_length == 0.05


@pytest.mark.parametrize("value", [None, "80068", [1e4]])
def test_a_size_that_is_no_number_is_refused_by_name(value: object) -> None:
    with pytest.raises(DriveError, match=r"axial stiffness EA is .*must be a number"):
        Belt(value)


def test_whole_numbers_and_numpys_own_are_numbers() -> None:
    assert BeltDrive(Belt(80000), Pulley(1, 3, 1, 10**7), Pulley(np.float64(1.0), 3, 1, 10**7))


def test_friction_that_would_overflow_the_tensions_is_refused() -> None:
    with pytest.raises(DriveError, match=r"mu phi is 600; above 500"):
        Pulley(0.1, 6.0, 100.0, 1e7)
