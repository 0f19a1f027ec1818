"""Arcs of arrays are those of their scalars; an arc that cannot be is refused with its numbers."""

import math
from typing import Any

import numpy as np
import pytest

from belt_ros.mechanics import DriveError, Role, solve_arc


def test_arrays_broadcast_and_equal_their_scalars() -> None:
    stiffness = np.geomspace(1e5, 1e9, 7)[:, None]
    outlet = np.linspace(210.0, 900.0, 5)
    fixed = (0.08, 3.0, 0.9)
    belt = (8e4, 0.1, 9.0, 200.0)
    many = solve_arc(Role.DRIVEN, *fixed, stiffness, *belt, outlet)
    assert many.inlet_strain_gradient.shape == (7, 5)
    assert many.elastic_only.shape == (7, 5)
    for i in range(7):
        for j in range(5):
            one = solve_arc(Role.DRIVEN, *fixed, stiffness[i, 0], *belt, outlet[j])
            for field, value in zip(many, one, strict=True):
                np.testing.assert_array_equal(field[i, j], value)


GOOD: dict[str, Any] = {
    "role": Role.DRIVEN,
    "radius": 0.1,
    "wrap_angle": 3.0,
    "friction_coefficient": 0.5,
    "friction_stiffness": 1e7,
    "axial_stiffness": 1e5,
    "mass_per_length": 0.1,
    "inlet_speed": 30.0,
    "inlet_tension": 200.0,
    "outlet_tension": 300.0,
}


@pytest.mark.parametrize("bad", [0.0, -2.5, math.nan, math.inf])
@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("radius", "radius"),
        ("wrap_angle", "wrap angle"),
        ("friction_coefficient", "friction coefficient mu"),
        ("friction_stiffness", "friction stiffness kf"),
        ("axial_stiffness", "axial stiffness EA"),
    ],
)
def test_refuses_a_parameter_that_is_not_positive(name: str, text: str, bad: float) -> None:
    with pytest.raises(DriveError, match=rf"^{text} is {bad:g}; it must be finite and > 0$"):
        solve_arc(**{**GOOD, name: bad})


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (
            {"inlet_tension": 90.0},
            r"the belt lifts off: tension 90 N is not above m v\^2 90 N",
        ),
        (
            {"inlet_tension": 50.0},
            r"the belt lifts off: tension 50 N is not above m v\^2 90 N",
        ),
        (
            {"role": Role.DRIVER, "outlet_tension": 80.0},
            r"the belt lifts off: tension 80 N is not above m v\^2 90 N",
        ),
        (
            {"inlet_speed": 1000.0},
            "belt speed 1000 m/s is not below the critical speed 1000 m/s",
        ),
        (
            {"inlet_speed": -1200.0},
            "belt speed -?1200 m/s is not below the critical speed 1000 m/s",
        ),
        (
            {"outlet_tension": 600.0},
            r"effective tension ratio 4.6\d+ is not below exp\(mu phi\) = 4.48169: gross slip",
        ),
        (
            {"role": Role.DRIVER, "inlet_tension": 600.0, "outlet_tension": 200.0},
            r"effective tension ratio 4.6\d+ is not below exp\(mu phi\) = 4.48169: gross slip",
        ),
        (
            {"outlet_tension": 150.0},
            "tensions 200 -> 150 N run against the arc's role",
        ),
        (
            {"role": Role.DRIVER},
            "tensions 200 -> 300 N run against the arc's role",
        ),
    ],
)
def test_refuses_a_state_that_cannot_exist(changed: dict[str, float], message: str) -> None:
    with pytest.raises(DriveError, match=f"^{message}$"):
        solve_arc(**{**GOOD, **changed})


@pytest.mark.parametrize("mass", [-0.1, math.nan])
def test_refuses_a_mass_that_is_not_one(mass: float) -> None:
    with pytest.raises(DriveError, match="mass"):
        solve_arc(**{**GOOD, "mass_per_length": mass})


@pytest.mark.parametrize("role", [0.0, 2.0, -0.5, math.nan])
def test_refuses_a_role_that_is_neither_driven_nor_driver(role: float) -> None:
    with pytest.raises(DriveError, match="role"):
        solve_arc(**{**GOOD, "role": role, "outlet_tension": 200.0 + math.copysign(5.0, role)})


def test_names_the_first_bad_value_of_an_array() -> None:
    with pytest.raises(DriveError, match=r"^friction coefficient mu is -1; "):
        solve_arc(**{**GOOD, "friction_coefficient": [0.5, -1.0, -2.0]})
