"""Steady states: tensions as they are held, slip by Eq. 11; what has none is told why."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from two_pulleys import PAPER_MASS, REPEATABLE, capacity_at, drives, paper_drive, slip_at

from belt_ros.mechanics import (
    Belt,
    BeltDrive,
    DriveError,
    Kinematics,
    Pulley,
    Tensioning,
    margin,
    solve_equilibrium,
    torque_capacity,
    torque_from_slip,
)

# --- Tensioning and kinematics ---------------------------------------------------------------


@pytest.mark.parametrize("torque", [20.0, -20.0])
def test_tensioning_holds_what_it_says(torque: float) -> None:
    pull = 20.0 / 0.08125
    mean = solve_equilibrium(paper_drive(8.1e7), torque, 400.0, 120.0)
    assert float(mean.mean_tension) == pytest.approx(400.0)
    assert float(mean.tight_tension) == pytest.approx(400.0 + 0.5 * pull)
    assert float(mean.slack_tension) == pytest.approx(400.0 - 0.5 * pull)
    drive = paper_drive(8.1e7, tensioning=Tensioning.CONSTANT_SLACK)
    slack = solve_equilibrium(drive, torque, 300.0, 120.0)
    assert float(slack.slack_tension) == 300.0
    assert float(slack.tight_tension) == pytest.approx(300.0 + pull)
    assert float(slack.mean_tension) == pytest.approx(300.0 + 0.5 * pull)


def test_both_tensionings_agree_where_their_tensions_do() -> None:
    share = 1.0 - PAPER_MASS * 9.75**2 / 80068.0
    pull = 20.0 / 0.08125 / share
    mean = solve_equilibrium(paper_drive(8.1e7, PAPER_MASS), 20.0, 400.0, 120.0)
    drive = paper_drive(8.1e7, PAPER_MASS, tensioning=Tensioning.CONSTANT_SLACK)
    slack = solve_equilibrium(drive, 20.0, 400.0 - 0.5 * pull, 120.0)
    np.testing.assert_allclose(slack.slip, mean.slip, rtol=1e-13)
    np.testing.assert_allclose(
        slack.driven_transition_angle, mean.driven_transition_angle, rtol=1e-13
    )


@given(drives(), st.floats(-0.99, 0.99))
@REPEATABLE
def test_slip_is_equation_11_with_the_belts_mass_conserved(
    given_drive: tuple[BeltDrive, float, float], load: float
) -> None:
    drive, held, speed = given_drive
    torque = load * capacity_at(drive, held, speed, load)
    assume(slip_at(drive, torque, held, speed) > -math.inf)
    state = solve_equilibrium(drive, torque, held, speed)
    ea = drive.belt.axial_stiffness
    # Slack belt enters the driven pulley when torque is along the rotation, tight belt otherwise.
    into_driven, into_driver = float(state.slack_tension), float(state.tight_tension)
    if torque * speed < 0.0:
        into_driven, into_driver = into_driver, into_driven
    if drive.kinematics is Kinematics.EXACT:
        strain = (ea + into_driven) / (ea + into_driver)
    else:
        pull = into_driver - into_driven
        strain = 1.0 / (1.0 + pull / ea) if pull >= 0.0 else 1.0 - pull / ea
    u1, u2 = float(state.driven_inlet_gradient), float(state.driver_inlet_gradient)
    receiving = u1 if torque * speed >= 0.0 else u2
    assume(receiving <= 1.0)  # beyond, the rim is pushed backwards
    ratio = (1.0 - u1) / (1.0 - u2) * strain
    assert 1.0 - float(state.slip) == pytest.approx(ratio, rel=1e-12, abs=1e-14)
    rim = drive.driver.radius * speed / drive.driven.radius
    assert float(state.driven_speed) == pytest.approx(
        rim * (1.0 - float(state.slip)), rel=1e-15, abs=1e-300
    )


def test_linear_and_exact_kinematics_differ_by_the_strain_of_the_slack_span() -> None:
    pulley = Pulley(0.05, math.pi, 0.6, 1e9)
    exact = BeltDrive(Belt(1e4), pulley, pulley)
    linear = replace(exact, kinematics=Kinematics.LINEAR)
    slip = [float(solve_equilibrium(d, 5.0, 400.0, 60.0).slip) for d in (exact, linear)]
    slack, pull = 400.0 - 50.0, 100.0
    assert slip[0] == pytest.approx(pull / (1e4 + slack + pull), rel=1e-6)
    assert slip[1] == pytest.approx(pull / (1e4 + pull), rel=1e-6)
    assert slip[1] / slip[0] - 1.0 == pytest.approx(slack / 1.01e4, rel=1e-3)


# --- Arrays and errors -----------------------------------------------------------------------


@pytest.mark.parametrize("mass", [0.0, PAPER_MASS])
def test_arrays_equal_their_scalars(mass: float) -> None:
    drive = paper_drive(2.8e7, mass)
    torque = np.array([-50.0, -1.0, 0.0, 20.0, 55.0])[:, None]
    tension = np.array([420.0, 600.0])
    speed = np.array([[[120.0]], [[-30.0]], [[0.0]]])
    many = solve_equilibrium(drive, torque, tension, speed)
    assert many.slip.shape == (3, 5, 2)
    pulls = torque_from_slip(drive, many.slip, tension, speed)
    capacities = torque_capacity(drive, tension, speed)
    margins = margin(drive, torque, tension, speed)
    for k, j, i in np.ndindex(3, 5, 2):
        args = (float(tension[i]), float(speed[k, 0, 0]))
        one = solve_equilibrium(drive, float(torque[j, 0]), *args)
        for field, value in zip(many, one, strict=True):
            np.testing.assert_array_equal(field[k, j, i], value)
        assert pulls[k, j, i] == torque_from_slip(drive, many.slip[k, j, i], *args)
        assert capacities[k, 0, i] == torque_capacity(drive, *args)
        assert margins[k, j, i] == margin(drive, float(torque[j, 0]), *args)


@pytest.mark.parametrize("function", [torque_capacity, solve_equilibrium, torque_from_slip, margin])
def test_lift_off_and_critical_speed_are_refused(function: Any) -> None:
    drive = paper_drive(8.1e7, 0.1)
    first = () if function is torque_capacity else (0.001,)
    lift = r"^the belt lifts off: tension 435 N is not above m v\^2 = 660.156 N$"
    with pytest.raises(DriveError, match=lift):
        function(drive, *first, 435.0, -1000.0)
    critical = "^belt speed 975 m/s is not below the critical speed 894.807"
    with pytest.raises(DriveError, match=critical):
        function(drive, *first, 435.0, 12000.0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize("function", [solve_equilibrium, torque_from_slip])
def test_a_state_that_is_not_finite_is_refused(function: Any, place: int, bad: float) -> None:
    state = [0.01, 435.0, 120.0]
    state[place] = bad
    with pytest.raises(DriveError, match="contains NaN or infinity"):
        function(paper_drive(8.1e7), *state)


def test_a_load_that_must_push_the_belt_back_has_no_steady_state() -> None:
    # A very compliant belt near capacity: the driver cannot be overrun by more than 100 %.
    pulley = Pulley(0.05, 3.0, 1.2, 2e5)
    drive = BeltDrive(Belt(2e3), pulley, pulley)
    capacity = float(torque_capacity(drive, 100.0))
    assert float(solve_equilibrium(drive, 0.9999 * capacity, 100.0, 50.0).slip) > 1.0
    with pytest.raises(DriveError, match="needs a slip beyond 100 %: no steady state"):
        solve_equilibrium(drive, -0.9999 * capacity, 100.0, 50.0)


def test_shapes_that_do_not_fit_are_refused_with_both() -> None:
    with pytest.raises(DriveError, match=r"shapes \(2,\), \(3,\), \(\) do not broadcast"):
        solve_equilibrium(paper_drive(8.1e7), [1.0, 2.0], [400.0, 410.0, 420.0], 100.0)
