"""Distributions along the arcs: Eqs. 1, 3, 32, 47 and 48 point by point, and the energy balance."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from belt_ros.mechanics import (
    Belt,
    BeltDrive,
    DriveError,
    Kinematics,
    Pulley,
    Role,
    Tensioning,
    arc_distribution,
    drive_distribution,
    solve_arc,
    solve_equilibrium,
    torque_capacity,
)

REPEATABLE = settings(derandomize=True, deadline=None, max_examples=60)
PAPER = (0.08125, math.pi, 1.2, 8.1e7, 80068.0)


def along(role: Role, low: float, high: float, mass: float = 0.0, points: int = 1001):
    ends = (low, high) if role is Role.DRIVEN else (high, low)
    angle = np.linspace(0.0, math.pi, points)
    return arc_distribution(angle, role, *PAPER, mass, 9.75, *ends)


@pytest.mark.parametrize("role", list(Role))
def test_ends_carry_the_tensions_given_and_the_inlet_no_friction(role: Role) -> None:
    found = along(role, 155.0, 715.0, 0.1036)
    inlet, outlet = (155.0, 715.0) if role is Role.DRIVEN else (715.0, 155.0)
    assert found.tension[0] == inlet
    assert found.tension[-1] == pytest.approx(outlet, rel=1e-12)
    assert found.friction[0] == 0.0
    assert found.displacement[0] == 0.0


@pytest.mark.parametrize("role", list(Role))
def test_friction_is_spring_then_coulomb_and_its_sign_is_the_roles(role: Role) -> None:
    found = along(role, 155.0, 715.0, 0.1036)
    solved = solve_arc(
        role, *PAPER, 0.1036, 9.75, *((155.0, 715.0) if role is Role.DRIVEN else (715.0, 155.0))
    )
    creeping = found.angle < float(solved.transition_angle)
    spring, coulomb = 8.1e7 * found.displacement, role * 1.2 * found.normal_force
    np.testing.assert_allclose(found.friction[creeping], spring[creeping], rtol=1e-10)
    np.testing.assert_allclose(found.friction[~creeping], coulomb[~creeping], rtol=1e-10)
    assert np.all(role * found.friction[1:] > 0.0)
    assert found.strain[0] == pytest.approx(float(solved.inlet_strain_gradient), rel=1e-12)


@pytest.mark.parametrize("role", list(Role))
@pytest.mark.parametrize("high", [220.0, 800.0, 4000.0])
def test_belt_equation_holds_along_the_arc(role: Role, high: float) -> None:
    found = along(role, 200.0, high, 0.1036, points=200001)
    inner = slice(2, -2)
    pitch = PAPER[0] * (found.angle[1] - found.angle[0])
    net = 80068.0 - 0.1036 * 9.75**2
    curvature = np.gradient(found.strain, pitch)[inner]
    peak = np.abs(found.friction).max()
    wrong = np.abs(net * curvature - found.friction[inner])
    assert np.sort(wrong)[-10] < 1e-6 * peak  # but for the corners at the zones' ends
    np.testing.assert_allclose(
        np.gradient(found.displacement, pitch)[inner], found.strain[inner], rtol=1e-4, atol=1e-12
    )
    stretched = found.tension[0] + 80068.0 * (found.strain - found.strain[0])
    np.testing.assert_allclose(found.tension, stretched, rtol=1e-11)
    lifted = (found.tension - found.normal_force * PAPER[0]) / (0.1036 * 9.75**2)
    np.testing.assert_allclose(lifted, 1.0, atol=0.06)  # v, by Eq. 32, follows the strain


def test_sliding_speed_is_the_strain_times_the_inlet_speed_to_first_order() -> None:
    found = along(Role.DRIVEN, 155.0, 715.0)
    np.testing.assert_allclose(found.sliding_speed, 9.75 * found.strain, rtol=5e-3)


def test_arrays_broadcast() -> None:
    angle = np.linspace(0.0, 1.0, 5)[:, None]
    found = arc_distribution(angle, 1, *PAPER, 0.0, 0.0, 200.0, [400.0, 800.0, 1600.0])
    assert {part.shape for part in found} == {(5, 3)}
    one = arc_distribution(0.5, 1, *PAPER, 0.0, 0.0, 200.0, 800.0)
    assert found.friction[2, 1] == one.friction


def test_an_angle_off_the_arc_is_refused_with_the_wrap_angle() -> None:
    for angle in (-0.1, 3.2, math.nan):
        with pytest.raises(DriveError, match=rf"angle {angle:g} rad is not on the arc.* 3\.14159"):
            arc_distribution(angle, 1, *PAPER, 0.0, 0.0, 200.0, 800.0)


def friction_power(drive: BeltDrive, *state: float) -> float:
    """Friction loss [W] by quadrature, on a grid that is dense where the gradient is steep."""
    found = drive_distribution(drive, *state, points=4001)
    total = 0.0
    for pulley, part in zip((drive.driven, drive.driver), found, strict=True):
        total += pulley.radius * np.trapezoid(part.power_loss, part.angle)
        assert np.all(part.power_loss >= 0.0)
    return float(total)


@given(
    st.floats(0.02, 10.0),
    st.floats(1.5, 5.0),
    st.floats(1.5, 5.0),
    st.floats(0.2, 1.2),
    st.floats(-0.97, 0.97),
    st.floats(0.0, 0.8),
    st.sampled_from(Tensioning),
)
@REPEATABLE
def test_power_in_is_power_out_and_friction_loss(
    growth: float,
    wrap: float,
    other: float,
    friction: float,
    load: float,
    lifted: float,
    tensioning: Tensioning,
) -> None:
    ea, tension, speed, radius = 2e4, 300.0, 80.0, 0.1
    stiffness = ea * (friction / (growth * radius)) ** 2
    assume(wrap * friction / growth < 100.0)  # the quadrature's grid would miss the layer
    mass = lifted * tension / (speed * 0.07) ** 2
    driven = Pulley(radius, wrap, friction, stiffness)
    driver = Pulley(0.07, other, friction, stiffness)
    drive = BeltDrive(Belt(ea, mass), driven, driver, tensioning=tensioning)
    torque = load * float(torque_capacity(drive, tension, speed, load < 0.0))
    try:
        state = solve_equilibrium(drive, torque, tension, speed)
    except DriveError as error:
        assume("slip beyond 100 %" not in str(error))
        raise
    receiving = state.driven_inlet_gradient if torque >= 0.0 else state.driver_inlet_gradient
    assume(float(receiving) <= 1.0)  # beyond, the rim is pushed backwards
    power_in = torque * 0.07 / radius * speed
    power_out = torque * float(state.driven_speed)
    loss = float(state.friction_loss)
    assert loss >= 0.0
    assert power_in - power_out == pytest.approx(loss, rel=1e-9, abs=1e-12 * abs(power_in))
    assert friction_power(drive, torque, tension, speed) == pytest.approx(
        loss, rel=1e-4, abs=1e-12 * abs(power_in)
    )


def test_pulleys_get_their_torques_from_friction() -> None:
    pulley = Pulley(0.1, 3.3, 0.9, 5e6)
    drive = BeltDrive(Belt(2e4, 0.5), pulley, replace(pulley, radius=0.06, wrap_angle=2.9))
    for torque in (20.0, -20.0):
        found = drive_distribution(drive, torque, 400.0, 100.0, points=40001)
        driven, driver = (np.trapezoid(part.friction, part.angle) for part in found)
        assert driven * 0.1**2 == pytest.approx(torque, rel=1e-6)
        assert driver * 0.06**2 == pytest.approx(-torque * 0.06 / 0.1, rel=1e-6)


def test_linear_kinematics_balance_to_second_order_in_the_strain() -> None:
    pulley = Pulley(0.1, 3.3, 0.9, 5e7)
    drive = BeltDrive(Belt(2e4), pulley, pulley, kinematics=Kinematics.LINEAR)
    loss = float(solve_equilibrium(drive, 20.0, 400.0, 100.0).friction_loss)
    assert friction_power(drive, 20.0, 400.0, 100.0) == pytest.approx(loss, rel=0.02)
