"""The two-pulley drive in steady state: the paper's numbers, and what every drive must obey."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from belt_ros.mechanics import (
    Belt,
    BeltDrive,
    DriveError,
    Kinematics,
    Pulley,
    Role,
    Tensioning,
    margin,
    solve_arc,
    solve_equilibrium,
    torque_capacity,
    torque_from_slip,
)
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.creep import span_tensions

REPEATABLE = settings(derandomize=True, deadline=None, max_examples=200)
PAPER_MASS = 0.1036


def paper_drive(stiffness: float, mass: float = 0.0, **changed: Any) -> BeltDrive:
    """Table 1."""
    pulley = Pulley(0.08125, math.pi, 1.2, stiffness)
    return BeltDrive(Belt(80068.0, mass), pulley, pulley, **changed)


def spread(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(math.log(low), math.log(high)).map(math.exp)


@st.composite
def drives(
    draw: st.DrawFn, *, massless: bool = False, equal: bool = False
) -> tuple[BeltDrive, float, float]:
    """A drive, the tension it holds [N] and a driver speed [rad/s] at which the belt stays on."""
    axial = draw(spread(3e3, 3e6))
    tension = axial * draw(spread(1e-4, 3e-2))
    friction = draw(st.floats(0.1, 1.5))

    def pulley(friction: float) -> Pulley:
        radius = draw(spread(0.02, 0.5))
        b = draw(spread(0.05, 50.0))
        return Pulley(radius, draw(st.floats(0.5, 6.0)), friction, axial * (b / radius) ** 2)

    driven = pulley(friction)
    driver = driven if equal else pulley(friction * draw(st.floats(0.5, 2.0)))
    speed = draw(spread(0.1, 500.0)) * draw(st.sampled_from([1.0, -1.0]))
    lift = 0.0 if massless else draw(st.floats(0.0, 0.8)) * tension
    drive = BeltDrive(
        Belt(axial, lift / (speed * driver.radius) ** 2),
        driven,
        driver,
        kinematics=draw(st.sampled_from(Kinematics)),
        tensioning=draw(st.sampled_from(Tensioning)),
    )
    return drive, tension, speed


def capacity_at(drive: BeltDrive, held: float, speed: float, torque: float) -> float:
    """Torque capacity in the direction in which a torque of that sign carries the power."""
    return float(torque_capacity(drive, held, speed, torque * speed < 0.0))


def slack_near_capacity(drive: BeltDrive, torque: float, held: float, speed: float) -> float:
    """Slack tension where a pulley is about to slip; there may be no steady state."""
    pull = (1.0 - 1e-9) * abs(torque) / drive.driven.radius
    friction = drive.driven.friction_coefficient, drive.driven.friction_stiffness
    rim = abs(speed) * drive.driver.radius
    return span_tensions(drive_constants(drive), pull, held, *friction, rim, torque * speed > 0.0)[
        0
    ]


def slip_at(drive: BeltDrive, torque: float, held: float, speed: float) -> float:
    """Slip; minus infinity where a load that drives would have to push the belt back."""
    try:
        return float(solve_equilibrium(drive, torque, held, speed).slip)
    except DriveError as error:
        if "slip beyond 100 %" in str(error) and torque * speed < 0.0:
            return -math.inf
        raise


# --- Tables and figures of the paper ---------------------------------------------------------

TABLE_2 = [  # kf, T_L, T_H
    (2.7678e7, 156.2, 712.2),  # the kf_min that the paper prints as 2.8e7
    (2.8e7, 156.2, 712.2),
    (2e8, 155.1, 716.7),
    (8.1e9, 158.3, 707.1),
]


def paper_arcs(case: int, mass: float) -> tuple[float, float, float, float]:
    """Transition angles driven and driver, T_o and inlet strain of the driven pulley."""
    stiffness, slack, tight = TABLE_2[case]
    fixed = (0.08125, math.pi, 1.2, stiffness, 80068.0, mass, 9.75)
    driven = solve_arc(Role.DRIVEN, *fixed, slack, tight)
    driver = solve_arc(Role.DRIVER, *fixed, tight, slack)
    strain = float(driven.inlet_strain_gradient)
    return (
        float(driven.transition_angle),
        float(driver.transition_angle),
        slack - 80068.0 * strain,
        strain,
    )


@pytest.mark.parametrize(
    ("case", "driven", "driver"),
    [(0, 3.14, 2.34), (1, 3.125, 2.342), (2, 2.158, 2.082), (3, 1.934, 1.932)],
)
def test_table_2_angles_without_inertia(case: int, driven: float, driver: float) -> None:
    theta1, theta2, _, _ = paper_arcs(case, 0.0)
    digit = 0.5e-2 if case == 0 else 0.5e-3
    assert theta1 == pytest.approx(driven, abs=digit)
    assert theta2 == pytest.approx(driver, abs=digit)


@pytest.mark.parametrize(
    ("case", "driven", "driver"),
    [(0, 0.00, 0.80), (2, 0.98, 1.06), (3, 1.21, 1.21)],
)
def test_table_2_slip_arcs_without_inertia(case: int, driven: float, driver: float) -> None:
    theta1, theta2, _, _ = paper_arcs(case, 0.0)
    assert math.pi - theta1 == pytest.approx(driven, abs=0.5e-2)
    assert math.pi - theta2 == pytest.approx(driver, abs=0.5e-2)


@pytest.mark.parametrize(
    ("case", "driven", "driver"),
    [(1, 3.078, 2.298), (2, 2.115, 2.039), (3, 1.892, 1.890)],
)
def test_table_2_angles_with_the_belts_own_inertia(case: int, driven: float, driver: float) -> None:
    theta1, theta2, _, _ = paper_arcs(case, PAPER_MASS)
    assert theta1 == pytest.approx(driven, abs=0.5e-3)
    assert theta2 == pytest.approx(driver, abs=1e-3)


@pytest.mark.parametrize(
    ("case", "unstretched", "strain"),
    [(0, 146.4, 1.2e-4), (1, 146.6, 1.2e-4), (2, 155.1, 2.5e-7), (3, 158.3, 0.0)],
)
def test_table_2_inlet_strain_and_unstretched_tension(
    case: int, unstretched: float, strain: float
) -> None:
    _, _, tension, gradient = paper_arcs(case, 0.0)
    assert tension == pytest.approx(unstretched, abs=0.05)
    assert gradient == pytest.approx(strain, rel=0.03, abs=1e-20)


@pytest.mark.parametrize(("case", "printed"), [(0, 119.13), (2, 119.16), (3, 119.18)])
@pytest.mark.parametrize("mass", [0.0, PAPER_MASS])
def test_table_2_driven_speed_from_the_linear_kinematics(
    case: int, printed: float, mass: float
) -> None:
    stiffness, slack, tight = TABLE_2[case]
    drive = paper_drive(stiffness, mass, kinematics=Kinematics.LINEAR)
    state = solve_equilibrium(drive, (tight - slack) * 0.08125, 0.5 * (tight + slack), 120.0)
    assert float(state.driven_speed) == pytest.approx(printed, abs=0.005)
    if mass == 0.0:
        angles = (float(state.driven_transition_angle), float(state.driver_transition_angle))
        assert angles == pytest.approx(paper_arcs(case, mass)[:2], abs=1e-12)


@pytest.mark.parametrize("case", [1, 2, 3])
def test_table_2_tensions_from_the_torque_to_their_own_imbalance(case: int) -> None:
    stiffness, slack, tight = TABLE_2[case]
    state = solve_equilibrium(paper_drive(stiffness), 45.0, 0.5 * (tight + slack), 120.0)
    assert float(state.tight_tension) == pytest.approx(tight, rel=0.015)
    assert float(state.slack_tension) == pytest.approx(slack, rel=0.03)
    assert float(state.tight_tension - state.slack_tension) == pytest.approx(45.0 / 0.08125)


def slack_held(pulley_driven: Pulley, pulley_driver: Pulley) -> BeltDrive:
    return BeltDrive(
        Belt(80068.0), pulley_driven, pulley_driver, tensioning=Tensioning.CONSTANT_SLACK
    )


def test_figure_10_limits_of_elastic_creep_and_full_slip() -> None:
    drive = slack_held(*[Pulley(0.08125, math.pi, 1.2, 8.1e7)] * 2)
    tight = np.array([292.5, 293.5, 372.5, 373.5])
    state = solve_equilibrium(drive, (tight - 200.0) * 0.08125, 200.0, 120.0)
    np.testing.assert_array_equal(
        state.driver_transition_angle >= math.pi * (1 - 1e-15), [True, False, False, False]
    )
    np.testing.assert_array_equal(
        state.driven_transition_angle >= math.pi * (1 - 1e-15), [True, True, True, False]
    )
    full_slip = 200.0 + float(torque_capacity(drive, 200.0)) / 0.08125
    assert full_slip == pytest.approx(8675.0, abs=0.5)


# --- Capacity and margin ---------------------------------------------------------------------


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


# --- Slip against torque ---------------------------------------------------------------------


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


def test_torque_beyond_capacity_is_refused_with_both_numbers() -> None:
    drive = paper_drive(8.1e7)
    limit = f"{float(torque_capacity(drive, 435.0)):g}"
    for torque in (70.0, -70.0):
        message = rf"^torque {torque:g} N m is not within the capacity of {limit} N m: gross slip$"
        with pytest.raises(DriveError, match=message):
            solve_equilibrium(drive, torque, 435.0, 120.0)


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


@pytest.mark.parametrize("torque", [math.nan, math.inf])
def test_margin_of_a_torque_that_is_not_finite_is_refused(torque: float) -> None:
    with pytest.raises(DriveError, match="NaN or infinity"):
        margin(paper_drive(8.1e7), torque, 435.0)


@pytest.mark.parametrize("torque", [1e-9, 1e-6, 1e-3])
def test_the_smallest_loads_keep_their_digits(torque: float) -> None:
    drive = paper_drive(8.1e7, PAPER_MASS)
    slip = float(solve_equilibrium(drive, torque, 435.0, 120.0).slip)
    assert float(torque_from_slip(drive, slip, 435.0, 120.0)) == pytest.approx(torque, rel=1e-11)


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
