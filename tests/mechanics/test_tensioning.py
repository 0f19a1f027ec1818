"""What the tensioning holds, and what becomes of the tensions under load and at speed."""

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
    Tensioning,
    drive_distribution,
    margin,
    solve_equilibrium,
    torque_capacity,
    torque_from_slip,
)

REPEATABLE = settings(derandomize=True, deadline=None, max_examples=60)
RADIUS, SPAN = 0.08125, 2.0 * math.pi * 0.08125
INSTALLED, SPEED = 434.0, 120.0


def paper_drive(
    tensioning: Tensioning, stiffness: float = 8.1e7, mass: float = 0.1036
) -> BeltDrive:
    pulley = Pulley(RADIUS, math.pi, 1.2, stiffness)
    return BeltDrive(Belt(80068.0, mass), pulley, pulley, SPAN, tensioning=tensioning)


def unstretched_length(drive: BeltDrive, torque: float, installed: float, speed: float) -> float:
    """Loop integral of the unstretched belt, by the trapezoidal rule over the distributions."""
    state = solve_equilibrium(drive, torque, installed, speed)
    ea = drive.belt.axial_stiffness
    total = sum(drive.span_length / (1.0 + float(t) / ea) for t in (state[2], state[3]))
    parts = drive_distribution(drive, torque, installed, speed, points=20001)
    for pulley, part in zip((drive.driven, drive.driver), parts, strict=True):
        total += pulley.radius * np.trapezoid(1.0 / (1.0 + part.tension / ea), part.angle)
    return float(total)


@pytest.mark.parametrize("load", [-0.95, -0.5, 0.0, 0.3, 0.7, 0.95])
@pytest.mark.parametrize("stiffness", [3e6, 2.8e7, 8.1e9])
@pytest.mark.parametrize("stretchy", [80068.0, 6000.0])
def test_fixed_centres_keep_the_belts_unstretched_length(
    load: float, stiffness: float, stretchy: float
) -> None:
    drive = paper_drive(Tensioning.FIXED_CENTRES, stiffness)
    drive = replace(
        drive,
        belt=Belt(stretchy, 0.1036),
        driver=replace(drive.driver, radius=0.06, wrap_angle=2.9),
    )
    torque = load * float(torque_capacity(drive, INSTALLED, SPEED, load < 0.0))
    path = 2.0 * SPAN + RADIUS * math.pi + 0.06 * 2.9
    at_rest = path / (1.0 + INSTALLED / stretchy)
    assert unstretched_length(drive, torque, INSTALLED, SPEED) == pytest.approx(at_rest, rel=2e-9)


def test_linear_kinematics_keep_the_mean_tension_round_the_loop() -> None:
    drive = replace(paper_drive(Tensioning.FIXED_CENTRES), kinematics=Kinematics.LINEAR)
    state = solve_equilibrium(drive, 45.0, INSTALLED, SPEED)
    total = SPAN * float(state.tight_tension + state.slack_tension)
    for part in drive_distribution(drive, 45.0, INSTALLED, SPEED, points=20001):
        total += RADIUS * np.trapezoid(part.tension, part.angle)
    assert total / (2.0 * SPAN + 2.0 * math.pi * RADIUS) == pytest.approx(INSTALLED, rel=2e-9)


@pytest.mark.parametrize("kinematics", list(Kinematics))
def test_tensions_of_a_fixed_loop_rise_with_the_torque(kinematics: Kinematics) -> None:
    drive = replace(paper_drive(Tensioning.FIXED_CENTRES), kinematics=kinematics)
    torques = np.linspace(0.0, 0.999, 60) * torque_capacity(drive, INSTALLED, SPEED)
    state = solve_equilibrium(drive, torques, INSTALLED, SPEED)
    total = state.tight_tension + state.slack_tension
    assert total[0] == pytest.approx(2.0 * INSTALLED, rel=1e-12)
    assert np.all(np.diff(total) > -1e-12 * INSTALLED)
    assert np.all(np.diff(total)[10:] > 0.0)
    assert total[-1] > 1.15 * total[0]


def test_rise_of_the_papers_drive_is_that_of_an_independent_simulation() -> None:
    # Exudyn, the same drive: 913 N at 12 N m, 949 N at 52 N m.
    drive = paper_drive(Tensioning.FIXED_CENTRES, 2e8)
    low, high = solve_equilibrium(drive, [12.0, 52.0], 456.0, SPEED).mean_tension
    assert 2.0 * low == pytest.approx(913.0, abs=2.0)
    assert 2.0 * high == pytest.approx(949.0, rel=0.01)


def test_rise_of_the_recorded_drive_is_that_of_its_belt_force() -> None:
    # shared/data: 400 N installed; at the end T_L + T_H = 186.6 + 665.2 N.
    pulley = Pulley(0.09995, math.pi, 0.5, 4e8)
    drive = BeltDrive(
        Belt(8000.0, 0.00829), pulley, pulley, 0.1 * math.pi, tensioning=Tensioning.FIXED_CENTRES
    )
    torque = (665.2 - 186.6) * 0.09995
    state = solve_equilibrium(drive, torque, 400.0, 12.0)
    assert float(state.mean_tension) == pytest.approx(0.5 * (186.6 + 665.2), rel=2e-3)


def test_a_hub_load_presses_alike_at_any_speed_and_other_tensionings_less() -> None:
    fast = 500.0
    for tensioning in Tensioning:
        drive = paper_drive(tensioning)
        slow_limit, fast_limit = torque_capacity(drive, INSTALLED, [1.0, fast])
        if tensioning is Tensioning.CONSTANT_HUB_LOAD:
            assert fast_limit == pytest.approx(slow_limit, rel=1e-12)
        else:
            assert fast_limit < 0.8 * slow_limit


def test_a_hub_load_carries_effective_tensions_that_add_up_to_it() -> None:
    drive = paper_drive(Tensioning.CONSTANT_HUB_LOAD)
    state = solve_equilibrium(drive, 45.0, INSTALLED, SPEED)
    lift = 0.1036 * (SPEED * RADIUS) ** 2
    effective = float(state.slack_tension) - lift
    assert 2.0 * effective + 45.0 / RADIUS == pytest.approx(2.0 * INSTALLED, rel=1e-13)
    assert float(state.mean_tension) == pytest.approx(INSTALLED + lift, rel=1e-3)


def test_tensionings_agree_without_load_and_inertia() -> None:
    for tensioning in Tensioning:
        state = solve_equilibrium(paper_drive(tensioning, mass=0.0), 0.0, INSTALLED, SPEED)
        assert float(state.tight_tension) == pytest.approx(INSTALLED, rel=1e-12)
        assert float(state.slack_tension) == pytest.approx(INSTALLED, rel=1e-12)


def test_margin_is_the_reserve_under_the_tensioning_at_hand() -> None:
    margins = {
        kind: float(margin(paper_drive(kind), 45.0, INSTALLED, SPEED)) for kind in Tensioning
    }
    for kind, reserve in margins.items():
        drive = paper_drive(kind)
        limit = 45.0 / (1.0 - reserve)
        with pytest.raises(DriveError, match="gross slip"):
            solve_equilibrium(drive, limit * (1.0 + 1e-9), INSTALLED, SPEED)
        solve_equilibrium(drive, limit * (1.0 - 1e-6), INSTALLED, SPEED)
    # A fixed loop tightens under load; a slack span held at the mean is tighter still.
    assert (
        margins[Tensioning.CONSTANT_MEAN]
        < margins[Tensioning.FIXED_CENTRES]
        < margins[Tensioning.CONSTANT_SLACK]
    )


@given(
    st.floats(4.0, 11.0),
    st.floats(1.5, 5.0),
    st.floats(1.5, 5.0),
    st.floats(0.15, 1.4),
    st.floats(1e-4, 0.08),
    st.floats(0.05, 0.999),
    st.booleans(),
)
@REPEATABLE
def test_fixed_centres_keep_slip_and_torque_one_to_one(
    decades: float,
    wrap: float,
    other: float,
    friction: float,
    strain: float,
    load: float,
    regenerating: bool,
) -> None:
    driven = Pulley(0.1, wrap, friction, 10.0**decades)
    driver = Pulley(0.07, other, friction, 10.0**decades)
    drive = BeltDrive(Belt(5e4, 0.05), driven, driver, tensioning=Tensioning.FIXED_CENTRES)
    installed, speed = strain * 5e4, 50.0
    capacity = float(torque_capacity(drive, installed, speed, regenerating))
    torque = load * capacity * (-1.0 if regenerating else 1.0)
    try:
        slip = float(solve_equilibrium(drive, torque, installed, speed).slip)
    except DriveError as error:
        assume("slip beyond 100 %" not in str(error))
        raise
    again = float(torque_from_slip(drive, slip, installed, speed))
    assert again == pytest.approx(torque, rel=0, abs=1e-10 * capacity)
    assert float(solve_equilibrium(drive, again, installed, speed).slip) == pytest.approx(
        slip, rel=1e-9
    )


def test_a_fixed_loop_is_lifted_off_by_the_speed_that_a_hub_load_bears() -> None:
    speed = math.sqrt(INSTALLED / 0.1036) / RADIUS * 1.01
    with pytest.raises(DriveError, match="lifts off"):
        solve_equilibrium(paper_drive(Tensioning.FIXED_CENTRES), 1.0, INSTALLED, speed)
    solve_equilibrium(paper_drive(Tensioning.CONSTANT_HUB_LOAD), 1.0, INSTALLED, speed)
