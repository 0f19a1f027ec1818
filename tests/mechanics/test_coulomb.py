"""Classical creep theory: its own laws, and EPP friction as it stiffens."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from drawing import spread
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.mechanics.arc import Role
from belt_ros.mechanics.coulomb import coulomb_torque_from_slip, solve_coulomb
from belt_ros.mechanics.coulomb_arc import coulomb_profile
from belt_ros.mechanics.drive import Belt, BeltDrive, DriveError, Kinematics, Pulley, Tensioning
from belt_ros.mechanics.equilibrium import solve_equilibrium, torque_capacity

REPEATABLE = settings(derandomize=True, deadline=None, max_examples=100)
HELD = [mode for mode in Tensioning if mode is not Tensioning.FIXED_CENTRES]
PAPER_MASS = 0.1036


def paper_drive(mass: float = 0.0, stiffness: float = 8.1e9, **changed: Any) -> BeltDrive:
    """Table 1."""
    pulley = Pulley(0.08125, math.pi, 1.2, stiffness)
    return BeltDrive(Belt(80068.0, mass), pulley, pulley, **changed)


def stiffened(drive: BeltDrive, stretch: float) -> BeltDrive:
    """Return the drive with kf such that sqrt(kf/EA) R is `stretch` on both pulleys."""

    def pulley(one: Pulley) -> Pulley:
        stiffness = drive.belt.axial_stiffness * (stretch / one.radius) ** 2
        return replace(one, friction_stiffness=stiffness)

    return replace(drive, driven=pulley(drive.driven), driver=pulley(drive.driver))


@st.composite
def cases(draw: st.DrawFn, modes: Any = Tensioning) -> tuple[BeltDrive, float, float, float]:
    """A drive, a torque [N m] within its capacity, the tension held [N], driver speed [rad/s]."""
    axial = draw(spread(3e3, 3e6))
    tension = axial * draw(spread(1e-4, 3e-2))
    friction = draw(st.floats(0.1, 1.5))
    driven, driver = (
        Pulley(draw(spread(0.02, 0.5)), draw(st.floats(0.5, 6.0)), mu, 1e7)
        for mu in (friction, friction * draw(st.floats(0.5, 2.0)))
    )
    speed = draw(spread(0.1, 500.0)) * draw(st.sampled_from([1.0, -1.0]))
    lift = draw(st.floats(0.0, 0.8)) * tension
    drive = BeltDrive(
        Belt(axial, lift / (speed * driver.radius) ** 2),
        driven,
        driver,
        kinematics=draw(st.sampled_from(Kinematics)),
        tensioning=draw(st.sampled_from(list(modes))),
    )
    share = draw(st.floats(0.01, 0.98)) * draw(st.sampled_from([1.0, -1.0]))
    limit = float(solve_coulomb(drive, share / abs(share) * 1e-9, tension, speed).torque_capacity)
    return drive, share * limit, tension, speed


# --- The paper's example, and laws that hold by themselves ---------------------------------------


def test_slip_angle_of_table_2_is_near_what_the_paper_quotes_of_coulomb_theory() -> None:
    # With the third column's tensions it is ln(707.1/158.3)/1.2 = 1.247; the paper prints 1.24.
    drive = paper_drive(tensioning=Tensioning.CONSTANT_SLACK)
    torque = (707.1 - 158.3) * drive.driven.radius
    state = solve_coulomb(drive, torque, 158.3, 120.0)
    assert state.tight_tension == pytest.approx(707.1, abs=1e-9)
    for angle in (state.driven_transition_angle, state.driver_transition_angle):
        assert math.pi - angle == pytest.approx(1.24, abs=0.01)
        assert math.pi - angle == pytest.approx(math.log(707.1 / 158.3) / 1.2, abs=1e-12)
    assert state.driven_speed == pytest.approx(119.18, abs=0.005)
    epp = solve_equilibrium(drive, torque, 158.3, 120.0)
    assert math.pi - epp.driven_transition_angle == pytest.approx(1.21, abs=0.005)


@pytest.mark.parametrize("mass", [0.0, PAPER_MASS])
def test_slip_is_the_strain_of_the_spans(mass: float) -> None:
    drive = paper_drive(mass, kinematics=Kinematics.EXACT)
    state = solve_coulomb(drive, 45.0, 434.0, 120.0)
    ratio = (80068.0 + state.slack_tension) / (80068.0 + state.tight_tension)
    assert state.slip == pytest.approx(1.0 - ratio, rel=1e-12)
    linear = solve_coulomb(replace(drive, kinematics=Kinematics.LINEAR), 45.0, 434.0, 120.0)
    strain = (linear.tight_tension - linear.slack_tension) / 80068.0
    assert linear.slip == pytest.approx(strain / (1.0 + strain), rel=1e-12)


@REPEATABLE
@given(cases())
def test_every_steady_state_balances_and_obeys_the_capstan_law(
    case: tuple[BeltDrive, float, float, float],
) -> None:
    drive, torque, _, speed = case
    state = solve_coulomb(*case)
    lift = drive.belt.mass_per_length * (speed * drive.driver.radius) ** 2
    w_slack = state.slack_tension - lift
    share = 1.0 - lift / drive.belt.axial_stiffness
    pull = share * (state.tight_tension - state.slack_tension)
    assert pull * drive.driven.radius == pytest.approx(abs(torque), rel=1e-9)
    for pulley, angle in (
        (drive.driven, state.driven_transition_angle),
        (drive.driver, state.driver_transition_angle),
    ):
        assert 0.0 < angle < pulley.wrap_angle
        traction = pulley.friction_coefficient * (pulley.wrap_angle - angle)
        assert traction == pytest.approx(math.log1p(pull / w_slack), rel=1e-9)
    assert state.driven_inlet_gradient == state.driver_inlet_gradient == 0.0
    assert np.isnan(state.driven_restick_angle)
    assert state.slip * torque * speed > 0.0
    assert 0.0 < state.margin < 1.0


@REPEATABLE
@given(cases())
def test_torque_from_slip_inverts_creep(case: tuple[BeltDrive, float, float, float]) -> None:
    drive, torque, tension, speed = case
    slip = solve_coulomb(*case).slip
    assert coulomb_torque_from_slip(drive, slip, tension, speed) == pytest.approx(torque, rel=1e-8)


@REPEATABLE
@given(cases(), st.floats(1e-6, 10.0))
def test_beyond_creep_the_torque_stays_at_the_capacity(
    case: tuple[BeltDrive, float, float, float], excess: float
) -> None:
    drive, torque, tension, speed = case
    limit = solve_coulomb(*case).torque_capacity
    nearly = solve_coulomb(drive, math.copysign(limit * (1.0 - 1e-9), torque), tension, speed).slip
    slip = nearly + math.copysign(excess, nearly)
    held = coulomb_torque_from_slip(drive, slip, tension, speed)
    assert held == pytest.approx(math.copysign(limit, torque), rel=1e-8)


def test_creep_is_in_proportion_to_small_torques() -> None:
    slip = np.array([1e-5, 2e-5, 1e-4])
    torque = coulomb_torque_from_slip(paper_drive(), slip, 434.0, 120.0)
    np.testing.assert_allclose(torque / slip, 0.08125 * (80068.0 + 434.0), rtol=1e-4)


@pytest.mark.parametrize("mode", Tensioning)
def test_a_driving_load_mirrors_a_driven_one(mode: Tensioning) -> None:
    drive = paper_drive(PAPER_MASS, tensioning=mode)
    forward = solve_coulomb(drive, 45.0, 434.0, 120.0)
    back = solve_coulomb(drive, -45.0, 434.0, 120.0)
    assert 1.0 - back.slip == pytest.approx(1.0 / (1.0 - forward.slip), rel=1e-12)
    assert back.driven_transition_angle == pytest.approx(forward.driver_transition_angle)
    assert back.slack_tension == pytest.approx(forward.slack_tension)
    reverse = solve_coulomb(drive, 45.0, 434.0, -120.0)
    assert reverse.slip == pytest.approx(back.slip, rel=1e-12)
    assert reverse.friction_loss == pytest.approx(back.friction_loss, rel=1e-12)
    assert back.friction_loss > 0.0


def test_no_torque_means_no_slip_and_no_sliding() -> None:
    state = solve_coulomb(paper_drive(PAPER_MASS), 0.0, 434.0, 120.0)
    assert state.slip == 0.0
    assert state.driven_transition_angle == math.pi
    assert coulomb_torque_from_slip(paper_drive(), 0.0, 434.0, 120.0) == 0.0


# --- The limit of EPP friction -------------------------------------------------------------------


@REPEATABLE
@given(cases(HELD))
def test_epp_slip_and_sliding_approach_coulombs_as_friction_stiffens(
    case: tuple[BeltDrive, float, float, float],
) -> None:
    drive = case[0]
    limit = solve_coulomb(*case)
    stretches = 10.0 ** np.array([1.5, 2.0, 3.0, 4.0, 5.0])
    epp = [solve_equilibrium(stiffened(drive, x), *case[1:]) for x in stretches]
    slip = np.array([abs(state.slip) for state in epp])
    assert np.all(np.diff(slip) <= 1e-14)
    assert slip[-1] == pytest.approx(abs(limit.slip), rel=1e-9)
    for name in ("driven", "driver"):
        angles = np.array([getattr(state, f"{name}_transition_angle") for state in epp])
        gap = angles - getattr(limit, f"{name}_transition_angle")
        assert np.all(np.diff(gap) <= 1e-9)
        assert np.all(gap >= -1e-9)
        # The elastic zone outlasts adhesion by what it gains, ln(1 +- a)/mu, a = mu/(lambda R).
        assert gap[-1] == pytest.approx(1.0 / stretches[-1], rel=0.01, abs=1e-9)


@pytest.mark.parametrize("mass", [0.0, PAPER_MASS])
def test_between_fixed_centres_the_limit_is_the_same(mass: float) -> None:
    # Not monotone: with stiffness the tensions, too, move, and slip passes below its limit.
    drive = paper_drive(mass, tensioning=Tensioning.FIXED_CENTRES)
    limit = solve_coulomb(drive, 45.0, 434.0, 120.0)
    gaps = []
    for stretch in (1e2, 1e3, 1e4):
        epp = solve_equilibrium(stiffened(drive, stretch), 45.0, 434.0, 120.0)
        gaps.append(
            [
                abs(epp.slip / limit.slip - 1.0),
                abs(epp.slack_tension / limit.slack_tension - 1.0),
                abs(epp.driven_transition_angle - limit.driven_transition_angle),
            ]
        )
    assert np.all(np.diff(gaps, axis=0) < 0.0)
    np.testing.assert_array_less(gaps[-1], [1e-8, 1e-5, 1e-3])


@REPEATABLE
@given(cases(HELD))
def test_the_capacity_is_that_of_epp_friction(case: tuple[BeltDrive, float, float, float]) -> None:
    drive, _, tension, speed = case
    expected = torque_capacity(drive, tension, speed)
    assert solve_coulomb(*case).torque_capacity == pytest.approx(float(expected), rel=1e-12)


# --- Along an arc --------------------------------------------------------------------------------


@pytest.mark.parametrize("role", Role)
@pytest.mark.parametrize("mass", [0.0, PAPER_MASS])
def test_along_an_arc_the_belt_adheres_then_follows_the_capstan_law(
    role: Role, mass: float
) -> None:
    ends = (200.0, 1000.0) if role is Role.DRIVEN else (1000.0, 200.0)
    angle = np.linspace(0.0, math.pi, 20001)
    arc = (role, 0.08125, math.pi, 1.2, 80068.0, mass, 9.75)
    profile = coulomb_profile(*arc, *ends, angle)
    share = 1.0 - mass * 9.75**2 / 80068.0
    w = np.array(ends) - mass * 9.75**2
    w[1] = w[0] + share * (ends[1] - ends[0])
    begin = math.pi - abs(math.log(w[1] / w[0])) / 1.2
    before, after = angle < begin, angle > begin
    np.testing.assert_array_equal(profile.friction[before], 0.0)
    np.testing.assert_array_equal(profile.tension[before], ends[0])
    assert profile.tension[-1] == pytest.approx(ends[1], rel=1e-12)
    effective = w[0] + share * (profile.tension - ends[0])
    np.testing.assert_allclose(
        profile.friction[after], role * 1.2 * effective[after] / 0.08125, rtol=1e-12
    )
    slope = np.gradient(effective[after], 0.08125 * angle[after])
    np.testing.assert_allclose(slope[1:-1], profile.friction[after][1:-1], rtol=1e-6)


def test_the_sum_of_friction_is_the_torque() -> None:
    drive = paper_drive(PAPER_MASS)
    state = solve_coulomb(drive, 45.0, 434.0, 120.0)
    angle = np.linspace(state.driven_transition_angle, math.pi, 2001)
    ends = state.slack_tension, state.tight_tension
    arc = (Role.DRIVEN, 0.08125, math.pi, 1.2, 80068.0, PAPER_MASS, 9.75)
    friction = coulomb_profile(*arc, *ends, angle).friction[1:]
    middle = 0.5 * (friction[1:] + friction[:-1])
    assert 0.08125**2 * middle.sum() * (angle[1] - angle[0]) == pytest.approx(45.0, rel=1e-3)


def test_an_arc_that_transmits_nothing_adheres_all_over() -> None:
    profile = coulomb_profile(1, 0.1, 3.0, 0.5, 1e4, 0.0, 1.0, 100.0, 100.0, [0.0, 1.0, 3.0])
    np.testing.assert_array_equal(profile.friction, 0.0)
    np.testing.assert_array_equal(profile.tension, 100.0)


# --- Shapes and errors ---------------------------------------------------------------------------


@pytest.mark.parametrize("mode", Tensioning)
def test_arguments_broadcast(mode: Tensioning) -> None:
    drive = paper_drive(tensioning=mode)
    torque = np.array([[10.0], [-20.0], [30.0]])
    speed = np.array([10.0, -120.0])
    state = solve_coulomb(drive, torque, 434.0, speed)
    assert all(field.shape == (3, 2) for field in state)
    assert state.slip[1, 1] == solve_coulomb(drive, -20.0, 434.0, -120.0).slip
    assert coulomb_torque_from_slip(drive, state.slip, 434.0, speed).shape == (3, 2)
    profile = coulomb_profile(
        1, 0.1, 3.0, 0.5, 1e4, 0.0, 1.0, 100.0, [[120.0], [130.0]], [0.0, 1.0]
    )
    assert profile.tension.shape == (2, 2)


@pytest.mark.parametrize(
    ("torque", "tension", "speed", "message"),
    [
        (400.0, 434.0, 120.0, "torque 400 N m is not within the capacity"),
        (1.0, 9.0, 120.0, "lifts off: tension 9 N"),
        (1.0, 434.0, 12000.0, "critical speed"),
        (math.nan, 434.0, 120.0, "NaN"),
    ],
)
def test_errors_are_those_of_the_epp_equilibrium(
    torque: float, tension: float, speed: float, message: str
) -> None:
    drive = paper_drive(PAPER_MASS)
    with pytest.raises(DriveError, match=message) as found:
        solve_coulomb(drive, torque, tension, speed)
    with pytest.raises(DriveError) as expected:
        solve_equilibrium(drive, torque, tension, speed)
    assert str(found.value) == str(expected.value)


def test_slip_that_is_no_number_is_refused() -> None:
    with pytest.raises(DriveError, match="NaN"):
        coulomb_torque_from_slip(paper_drive(), math.nan, 434.0, 120.0)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"t_in": 5.0}, "lifts off: tension 5 N"),
        ({"t_out": 150.0}, "200 -> 150 N run against"),
        ({"t_out": 9000.0}, r"beyond mu phi = 3\.7"),
        ({"angle": 3.2}, "angle 3.2 rad"),
        ({"angle": math.nan}, "angle nan rad"),
        ({"speed": 900.0}, "critical speed"),
    ],
)
def test_an_arc_that_cannot_be_is_refused(changed: dict[str, float], message: str) -> None:
    values = {"speed": 9.75, "t_in": 200.0, "t_out": 700.0, "angle": 1.0} | changed
    with pytest.raises(DriveError, match=message):
        coulomb_profile(1, 0.08125, math.pi, 1.2, 80068.0, PAPER_MASS, *values.values())
