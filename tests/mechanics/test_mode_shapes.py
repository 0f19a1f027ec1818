"""Frequencies move continuously, shapes are normalised, and arcs without modes are refused."""

import math

import numpy as np
import pytest
from vibrating_arcs import Arc, every_arc

from belt_ros.mechanics.arc import Role
from belt_ros.mechanics.drive import DriveError

# --- Continuity, shapes --------------------------------------------------------------------------


@pytest.mark.parametrize("role", Role)
@pytest.mark.parametrize("speed", [0.0, 9.75, 100.0])
def test_frequencies_move_continuously_with_the_transition_angle(role: Role, speed: float) -> None:
    angles = np.concatenate([[0.0, 1e-9], np.linspace(1e-3, math.pi - 1e-3, 200)])
    angles = np.concatenate([angles, [math.pi - 1e-9, math.pi]])
    arc = Arc(role=role, speed=speed)
    found = np.stack([arc._replace(transition_angle=x).modes(5).frequencies for x in angles])
    steps = np.abs(np.diff(found, axis=0)) / np.abs(found[:-1])
    assert np.all(steps < 3.0 * np.diff(angles)[:, None] + 1e-7)


def test_two_overdamped_modes_become_a_pair_where_they_meet() -> None:
    arc = Arc(role=Role.DRIVER, speed=300.0)
    angles = np.linspace(0.4, 0.8, 101)
    modes = [arc._replace(transition_angle=x).modes().frequencies for x in angles]
    apart = np.array([omega[1].real == 0.0 for omega in modes])
    assert apart[0]
    assert not apart[-1]
    assert np.all(np.diff(apart.astype(int)) <= 0)
    first = np.array([omega[0] for omega in modes])
    second = np.array([omega[1] if omega[1].real == 0.0 else -omega[0].conj() for omega in modes])
    for smooth in (first + second, first * second):
        assert np.abs(np.diff(smooth)).max() < 0.02 * np.abs(smooth).max()


@every_arc
def test_shapes_are_normalised_with_a_positive_slope_at_the_inlet(arc: Arc) -> None:
    modes = arc.modes(5)
    angles = np.linspace(0.0, arc.wrap_angle, 20001)
    np.testing.assert_allclose(np.abs(modes.shapes(angles)).max(axis=1), 1.0, atol=1e-5)
    slope = modes.shapes(1e-7)
    assert np.all(slope.real > 0.0)
    np.testing.assert_allclose(slope.imag / slope.real, 0.0, atol=1e-4)


def test_shapes_keep_the_shape_of_the_angles() -> None:
    modes = Arc(transition_angle=2.0).modes(4)
    assert modes.shapes(1.0).shape == (4,)
    assert modes.shapes(np.ones((2, 3))).shape == (4, 2, 3)


# --- Errors --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"speed": 900.0}, r"900 m/s is not below the critical speed 879\.1"),
        ({"speed": -1.0}, "-1 m/s is against"),
        ({"speed": math.nan}, "nan m/s"),
        ({"mass_per_length": 0.0}, "without inertia"),
        ({"transition_angle": 3.2}, "3.2 rad is not within the wrap angle 3.14"),
        ({"transition_angle": math.nan}, "nan rad"),
        ({"transition_angle": 1.0, "restick_angle": 2.0}, "only driven arcs with mu > lambda R"),
        ({"friction_stiffness": 1e6, "restick_angle": 2.0}, "not between the transition angle"),
        ({"friction_stiffness": 0.0}, "kf is 0"),
        ({"radius": -1.0}, "radius is -1"),
    ],
)
def test_what_cannot_be_is_refused(changed: dict[str, float], message: str) -> None:
    with pytest.raises(DriveError, match=message):
        Arc()._replace(**changed).modes()


@pytest.mark.parametrize("count", [0, 21])
def test_counts_out_of_range_are_refused(count: int) -> None:
    with pytest.raises(DriveError, match=f"{count} modes"):
        Arc().modes(count)


@pytest.mark.parametrize("angle", [-0.1, 3.2, math.nan])
def test_shapes_off_the_arc_are_refused(angle: float) -> None:
    with pytest.raises(DriveError, match="not on the arc"):
        Arc().modes().shapes(angle)
