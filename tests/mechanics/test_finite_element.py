"""The finite element belt: the paper's drive against EPP equilibrium, and what physics demands."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.mechanics import (
    Belt,
    BeltDrive,
    DriveError,
    Pulley,
    Role,
    Tensioning,
    solve_arc,
    solve_equilibrium,
)
from belt_ros.mechanics.finite_element import ArcDistribution, FiniteElementRun, History, simulate
from belt_ros.mechanics.finite_element_kernel import Mesh, Profile, State, advance
from belt_ros.mechanics.finite_element_mesh import (
    Discretisation,
    build_mesh,
    initial_state,
    open_belt,
)

RADIUS = 0.08125
SPEED = 120.0
TORQUE = 45.0
INSTALLED = 422.5
COARSE = Discretisation(elements_per_half_pulley=30)
PAPER_STIFFNESSES = (2.8e7, 2e8, 8.1e9)


def make_drive(stiffness: float = 2e8, r1: float = RADIUS, r2: float = RADIUS) -> BeltDrive:
    """Table 1, spans 2 pi R; other radii on the same centres."""
    wrap1, wrap2, span = open_belt(r1, r2, 2.0 * math.pi * RADIUS)
    return BeltDrive(
        Belt(80068.0, 0.1036),
        Pulley(r1, wrap1, 1.2, stiffness, inertia=0.01),
        Pulley(r2, wrap2, 1.2, stiffness, inertia=0.01),
        span_length=span,
    )


def ramp(duration: float, torque: float, speed: float = SPEED, rise: float = 0.25) -> History:
    """Driver and load from rest, without kinks that would ring."""
    q = np.linspace(0.0, 1.0, 41)
    smooth = np.append(q * q * (3.0 - 2.0 * q), 1.0)
    return History(np.append(rise * q, duration), speed * smooth, torque * smooth)


def tail(values: np.ndarray, share: float = 0.15) -> float:
    return float(np.mean(values[-max(int(share * values.size), 1) :]))


def tensions(run: FiniteElementRun) -> tuple[float, float]:
    """Tight and slack [N] at the end."""
    ends = tail(run.to_driver_tension), tail(run.to_driven_tension)
    return max(ends), min(ends)


def equilibrium_arc(
    drive: BeltDrive, role: Role, pulley: Pulley, inlet: float, outlet: float
) -> Any:
    return solve_arc(
        role,
        pulley.radius,
        pulley.wrap_angle,
        pulley.friction_coefficient,
        pulley.friction_stiffness,
        drive.belt.axial_stiffness,
        drive.belt.mass_per_length,
        SPEED * drive.driver.radius,
        inlet,
        outlet,
    )


def equilibrium_speed(drive: BeltDrive, tight: float, slack: float) -> float:
    """omega1 of EPP equilibrium at these tensions, the driver giving the power."""
    u1 = equilibrium_arc(drive, Role.DRIVEN, drive.driven, slack, tight).inlet_strain_gradient
    u2 = equilibrium_arc(drive, Role.DRIVER, drive.driver, tight, slack).inlet_strain_gradient
    ea = drive.belt.axial_stiffness
    ratio = float((1.0 - u1) / (1.0 - u2)) * (1.0 + slack / ea) / (1.0 + tight / ea)
    return ratio * SPEED * drive.driver.radius / drive.driven.radius


def equilibrium_friction(
    drive: BeltDrive, role: Role, pulley: Pulley, inlet: float, outlet: float, angle: np.ndarray
) -> np.ndarray:
    """Friction per length along an arc in closed form: sinh up to the transition, then capstan."""
    arc = equilibrium_arc(drive, role, pulley, inlet, outlet)
    lift = drive.belt.mass_per_length * (SPEED * drive.driver.radius) ** 2
    k = drive.belt.axial_stiffness - lift
    root = math.sqrt(pulley.friction_stiffness / k)
    gradient, transition = float(arc.inlet_strain_gradient), float(arc.transition_angle)
    elastic = pulley.friction_stiffness * gradient / root
    creeping = elastic * np.sinh(root * pulley.radius * np.minimum(angle, transition))
    w = inlet - lift + k * gradient * (math.cosh(root * pulley.radius * transition) - 1.0)
    mu = pulley.friction_coefficient
    sliding = role * mu / pulley.radius * w * np.exp(role * mu * (angle - transition))
    return np.where(angle < transition, creeping, sliding)


def profile_errors(drive: BeltDrive, run: FiniteElementRun) -> tuple[float, float]:
    """Rms deviation of friction from equilibrium over its peak, driven and driver pulley."""
    tight, slack = tensions(run)
    errors = []
    for role, pulley, arc, ends in (
        (Role.DRIVEN, drive.driven, run.driven_arc, (slack, tight)),
        (Role.DRIVER, drive.driver, run.driver_arc, (tight, slack)),
    ):
        expected = equilibrium_friction(drive, role, pulley, *ends, arc.angle)
        rms = np.sqrt(np.mean((arc.friction - expected) ** 2))
        errors.append(float(rms / np.max(np.abs(expected))))
    return errors[0], errors[1]


@pytest.fixture(scope="module")
def paper_runs() -> dict[float, FiniteElementRun]:
    """The paper's drive at its three kf, with its own mesh of 100 elements per half pulley."""
    return {
        kf: simulate(make_drive(kf), ramp(0.6, TORQUE), INSTALLED, average_over=0.1)
        for kf in PAPER_STIFFNESSES
    }


@pytest.fixture(scope="module")
def coarse_run() -> FiniteElementRun:
    return simulate(make_drive(), ramp(0.6, TORQUE), INSTALLED, COARSE)


# --- The paper's drive -----------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("kf", PAPER_STIFFNESSES)
class TestPapersDrive:
    def test_span_tensions_balance_the_torque(self, paper_runs: Any, kf: float) -> None:
        tight, slack = tensions(paper_runs[kf])
        assert tight + slack == pytest.approx(868.0, abs=5.0)
        assert (tight - slack) * RADIUS == pytest.approx(TORQUE, rel=5e-3)

    def test_tension_level_is_that_of_fixed_centres(self, paper_runs: Any, kf: float) -> None:
        drive = replace(make_drive(kf), tensioning=Tensioning.FIXED_CENTRES)
        expected = solve_equilibrium(drive, TORQUE, INSTALLED, SPEED)
        rise = sum(tensions(paper_runs[kf])) - 2.0 * INSTALLED
        assert rise == pytest.approx(2.0 * float(expected.mean_tension) - 2.0 * INSTALLED, rel=0.05)
        assert rise > 20.0

    def test_driven_speed_is_that_of_equilibrium(self, paper_runs: Any, kf: float) -> None:
        run = paper_runs[kf]
        expected = equilibrium_speed(make_drive(kf), *tensions(run))
        assert tail(run.driven_speed) == pytest.approx(expected, abs=0.02)

    def test_friction_profiles_are_those_of_equilibrium(self, paper_runs: Any, kf: float) -> None:
        errors = profile_errors(make_drive(kf), paper_runs[kf])
        assert max(errors) < 0.01

    def test_tension_along_the_arcs_joins_the_spans(self, paper_runs: Any, kf: float) -> None:
        run = paper_runs[kf]
        tight, slack = tensions(run)
        assert run.driven_arc.tension[[1, -1]] == pytest.approx([slack, tight], rel=0.04)
        assert run.driver_arc.tension[[1, -1]] == pytest.approx([tight, slack], rel=0.04)

    def test_normal_force_carries_the_effective_tension(self, paper_runs: Any, kf: float) -> None:
        lift = 0.1036 * (SPEED * RADIUS) ** 2
        for arc in (paper_runs[kf].driven_arc, paper_runs[kf].driver_arc):
            expected = (arc.tension - lift) / RADIUS
            assert arc.normal == pytest.approx(expected, rel=0.06)
            inner = slice(1, -1)
            assert arc.normal[inner] == pytest.approx(expected[inner], rel=0.01)

    def test_belt_keeps_its_length(self, paper_runs: Any, kf: float) -> None:
        run = paper_runs[kf]
        arcs = np.mean(run.driven_arc.tension) + np.mean(run.driver_arc.tension)
        mean = (2.0 * sum(tensions(run)) + arcs) / 6.0
        assert mean == pytest.approx(INSTALLED, rel=5e-3)

    def test_drive_loses_what_creep_costs(self, paper_runs: Any, kf: float) -> None:
        run = paper_runs[kf]
        given_power = tail(run.driver_torque) * SPEED
        received = tail(run.driven_torque) * tail(run.driven_speed)
        creep = 1.0 - equilibrium_speed(make_drive(kf), *tensions(run)) / SPEED
        assert given_power - received == pytest.approx(creep * given_power, rel=0.02)


# --- Mechanics -------------------------------------------------------------------------------


def test_friction_torques_balance_load_and_each_other(coarse_run: FiniteElementRun) -> None:
    assert tail(coarse_run.driven_torque) == pytest.approx(TORQUE, rel=1e-3)
    assert tail(coarse_run.driver_torque) == pytest.approx(TORQUE, rel=1e-3)


def test_friction_of_the_distribution_is_the_torque(coarse_run: FiniteElementRun) -> None:
    arc = coarse_run.driven_arc
    total = np.mean(arc.friction) * math.pi * RADIUS
    assert total * RADIUS == pytest.approx(TORQUE, rel=0.01)


def test_standstill_holds_tension_and_is_quiet() -> None:
    still = History([0.0, 0.1], [0.0, 0.0], [0.0, 0.0])
    run = simulate(make_drive(), still, INSTALLED, COARSE)
    settled = run.time > 0.02
    for tension in (run.to_driver_tension, run.to_driven_tension):
        assert tension[settled] == pytest.approx(INSTALLED, rel=1e-3)
    assert np.max(np.abs(run.driven_speed)) < 1e-3
    assert np.max(np.abs(run.driver_torque[settled])) < 0.01
    assert run.driven_arc.normal[2:-2] == pytest.approx(INSTALLED / RADIUS, rel=1e-3)


def test_reversed_torque_swaps_the_roles(coarse_run: FiniteElementRun) -> None:
    drive = make_drive()
    run = simulate(drive, ramp(0.6, -TORQUE), INSTALLED, COARSE)
    tight, slack = tensions(run)
    assert tail(run.to_driven_tension) == tight
    assert (tight, slack) == pytest.approx(tensions(coarse_run), rel=0.01)
    expected = SPEED**2 / equilibrium_speed(drive, tight, slack)
    assert tail(run.driven_speed) == pytest.approx(expected, abs=0.02)
    assert tail(run.driver_torque) == pytest.approx(-TORQUE, rel=1e-3)
    assert np.mean(run.driven_arc.friction) < 0.0 < np.mean(run.driver_arc.friction)


def test_reversed_rotation_mirrors_the_drive(coarse_run: FiniteElementRun) -> None:
    run = simulate(make_drive(), ramp(0.6, -TORQUE, -SPEED), INSTALLED, COARSE)
    assert run.driven_speed == pytest.approx(-coarse_run.driven_speed, abs=1e-6)
    assert run.to_driven_tension == pytest.approx(coarse_run.to_driver_tension, rel=1e-6)
    for mirrored, arc in (
        (run.driven_arc, coarse_run.driven_arc),
        (run.driver_arc, coarse_run.driver_arc),
    ):
        peak = np.max(np.abs(arc.friction))
        assert mirrored.friction == pytest.approx(arc.friction, abs=1e-6 * peak)


def test_reversal_on_the_run_leaves_no_memory() -> None:
    there_and_back = History(
        [0.0, 0.1, 0.35, 0.65], [60.0, 60.0, -60.0, -60.0], [20.0, 20.0, -20.0, -20.0]
    )
    only_back = History([0.0, 0.3], [-60.0, -60.0], [-20.0, -20.0])
    turned = simulate(make_drive(), there_and_back, INSTALLED, COARSE)
    straight = simulate(make_drive(), only_back, INSTALLED, COARSE)
    assert tail(turned.driven_speed) == pytest.approx(tail(straight.driven_speed), abs=0.05)
    assert tensions(turned) == pytest.approx(tensions(straight), rel=0.01)


def test_overload_slips_and_saturates_at_the_capacity() -> None:
    """On fixed centres T_H + T_L has risen by then, and with it the capacity, to 78 N m."""
    drive = make_drive()
    run = simulate(drive, ramp(0.45, 90.0, rise=0.2), INSTALLED, COARSE, average_over=0.02)
    sliding = (run.driven_speed < 100.0) & (run.time > 0.2)
    assert np.any(sliding)
    assert run.driven_speed[-1] < 0.0
    lift = drive.belt.mass_per_length * (SPEED * RADIUS) ** 2
    tight, slack = np.mean(run.tight_tension[sliding]), np.mean(run.slack_tension[sliding])
    mean = 0.5 * (tight + slack) - lift
    capacity = 2.0 * mean * math.tanh(0.5 * drive.driven.traction_limit)
    assert tight - slack == pytest.approx(capacity, rel=0.02)


def advance_freely(mesh: Mesh, state: State, steps: int) -> None:
    """Constant speed and torque, nothing observed."""
    idle = Profile(*(np.empty(0) for _ in Profile._fields))
    advance(mesh, state, np.full(steps, SPEED), np.full(steps, TORQUE), 8, idle, idle)


def nodes_held(mesh: Mesh, state: State) -> np.ndarray:
    x, y = state.x[:-1], state.y[:-1]
    on_driven = np.hypot(x, y) < mesh.driven.radius
    return on_driven | (np.hypot(x - mesh.driver.centre, y) < mesh.driver.radius)


def test_friction_springs_are_relaxed_off_the_pulleys() -> None:
    mesh = build_mesh(make_drive(), INSTALLED, COARSE)
    state = initial_state(make_drive(), mesh, INSTALLED, SPEED)
    state.stretch[:] = 1e-6
    advance_freely(mesh, state, 8)
    held = nodes_held(mesh, state)
    assert 50 < np.count_nonzero(held) < 70
    assert np.all(state.stretch[held] != 0.0)
    for values in (state.stretch, state.normal, state.friction):
        assert np.all(values[~held] == 0.0)


def test_friction_keeps_within_coulombs_limit() -> None:
    drive = make_drive()
    mesh = build_mesh(drive, INSTALLED, COARSE)
    state = initial_state(drive, mesh, INSTALLED, SPEED)
    advance_freely(mesh, state, 16_000)
    limit = drive.driven.friction_coefficient * state.normal
    share = np.abs(state.friction[nodes_held(mesh, state)]) / limit[nodes_held(mesh, state)]
    assert np.max(share) == pytest.approx(1.0, rel=1e-12)
    assert np.min(share) < 0.01


def test_slack_element_does_not_push() -> None:
    mesh = build_mesh(make_drive(), INSTALLED, COARSE)
    state = initial_state(make_drive(), mesh, INSTALLED, 0.0)
    on_span = int(np.argmin(np.abs(state.x - 0.5 * mesh.driver.centre)))
    state.x[on_span] += 0.5 * (state.x[on_span + 1] - state.x[on_span])
    advance_freely(mesh, state, 8)
    assert np.min(state.tension) == 0.0


def test_more_elements_come_closer_to_equilibrium() -> None:
    drive = make_drive()
    driven, driver = [], []
    for n in (15, 30, 60):
        run = simulate(drive, ramp(0.5, TORQUE), INSTALLED, Discretisation(n), average_over=0.1)
        errors = profile_errors(drive, run)
        driven.append(errors[0])
        driver.append(errors[1])
    # of second order on the driven pulley; the driver, whose speed is imposed, rings a little
    assert driven[0] > 2.0 * driven[1] > 4.0 * driven[2]
    assert driver[0] > 2.0 * max(driver[1:])
    assert max(driven[2], driver[2]) < 0.01


@pytest.mark.parametrize(("r1", "r2"), [(RADIUS, RADIUS), (0.1, 0.05), (0.05, 0.1)])
@pytest.mark.parametrize("torque", [TORQUE, -TORQUE])
def test_soft_contact_creeps_as_in_equilibrium_on_a_coarse_mesh(
    r1: float, r2: float, torque: float
) -> None:
    # Friction grows all along the arcs, so where a node begins and ends to be held counts.
    drive = make_drive(1e7, r1, r2)
    torque *= 0.3 * r1 / RADIUS
    damped = Discretisation(40, penalty_ratio=4.0, axial_damping=1.4)
    run = simulate(drive, ramp(0.6, torque), INSTALLED, damped)
    creep = 1.0 - tail(run.driven_speed) * r1 / (SPEED * r2)
    tight, slack = tensions(run)
    power = 1.0 if torque > 0.0 else -1.0
    expected = solve_equilibrium(drive, (tight - slack) * r1 * power, 0.5 * (tight + slack), SPEED)
    assert creep == pytest.approx(float(expected.slip), rel=0.01)


@pytest.mark.parametrize(("r1", "r2"), [(0.1, 0.05), (0.05, 0.1)])
def test_unequal_pulleys_creep_as_in_equilibrium(r1: float, r2: float) -> None:
    drive = make_drive(r1=r1, r2=r2)
    torque = 300.0 * r1
    run = simulate(drive, ramp(0.5, torque), INSTALLED, Discretisation(40))
    tight, slack = tensions(run)
    assert (tight - slack) * r1 == pytest.approx(torque, rel=5e-3)
    expected = equilibrium_speed(drive, tight, slack)
    assert tail(run.driven_speed) == pytest.approx(expected, rel=1e-4)
    assert max(profile_errors(drive, run)) < 0.01


def test_start_at_speed_ends_where_a_ramp_does(coarse_run: FiniteElementRun) -> None:
    loaded = ramp(0.5, TORQUE)
    flying = History(loaded.time, np.full(np.size(loaded.time), SPEED), loaded.load_torque)
    run = simulate(make_drive(), flying, INSTALLED, COARSE)
    assert run.driven_speed[0] == pytest.approx(SPEED, rel=1e-3)
    assert tail(run.driven_speed) == pytest.approx(tail(coarse_run.driven_speed), abs=0.03)


# --- Geometry and the run itself -------------------------------------------------------------


@settings(derandomize=True, deadline=None)
@given(
    r1=st.floats(0.01, 0.5),
    r2=st.floats(0.01, 0.5),
    gap=st.floats(0.01, 2.0),
)
def test_open_belt_is_tangent_and_closes(r1: float, r2: float, gap: float) -> None:
    distance = r1 + r2 + gap
    wrap1, wrap2, span = open_belt(r1, r2, distance)
    assert wrap1 + wrap2 == pytest.approx(2.0 * math.pi)
    normal = math.pi - 0.5 * wrap1
    outlet = np.array([r1 * math.cos(normal), r1 * math.sin(normal)])
    inlet = np.array([distance + r2 * math.cos(normal), r2 * math.sin(normal)])
    assert math.hypot(*(inlet - outlet)) == pytest.approx(span)
    assert (inlet - outlet) @ outlet == pytest.approx(0.0, abs=1e-9)


def test_belt_starts_closed_and_evenly_tensioned() -> None:
    drive = make_drive(r1=0.1, r2=0.06)
    mesh = build_mesh(drive, INSTALLED, Discretisation(60))
    state = initial_state(drive, mesh, INSTALLED, SPEED)
    lengths = np.hypot(np.diff(state.x), np.diff(state.y))
    strain = INSTALLED / drive.belt.axial_stiffness
    assert lengths / mesh.rest_length - 1.0 == pytest.approx(strain, abs=0.1 * strain)
    assert np.hypot(state.vx, state.vy) == pytest.approx(SPEED * 0.06)
    assert state.driven_speed[0] * 0.1 == pytest.approx(SPEED * 0.06)


def test_series_and_distributions_have_their_shapes() -> None:
    done = []
    run = simulate(
        make_drive(),
        History([1.0, 1.05], [SPEED, SPEED], [0.0, 10.0]),
        INSTALLED,
        COARSE,
        sampling_interval=0.005,
        progress=lambda now, total: done.append((now, total)),
    )
    assert run.time == pytest.approx(1.0 + 0.005 * (np.arange(10) + 0.5))
    assert run.driver_speed == pytest.approx(SPEED)
    assert run.tight_tension == pytest.approx(
        np.maximum(run.to_driver_tension, run.to_driven_tension)
    )
    assert len(done) == 10
    assert done[-1] == pytest.approx((0.05, 0.05))
    assert run.elements == 180
    for arc in (run.driven_arc, run.driver_arc):
        assert isinstance(arc, ArcDistribution)
        assert all(np.all(np.isfinite(values)) for values in arc)
        assert 0.0 < arc.angle[0] < arc.angle[-1] < math.pi
        assert 25 <= arc.angle.size <= 30


def test_result_does_not_depend_on_how_it_is_sampled() -> None:
    history = History([0.0, 0.04], [SPEED, SPEED], [0.0, TORQUE])
    mesh = build_mesh(make_drive(), INSTALLED, COARSE)
    interval = 80.0 * mesh.time_step
    runs = [
        simulate(make_drive(), history, INSTALLED, COARSE, sampling_interval=k * interval)
        for k in (1, 4)
    ]
    seldom = runs[1].driven_speed
    often = runs[0].driven_speed[: 4 * seldom.size].reshape(-1, 4).mean(axis=1)
    assert seldom == pytest.approx(often, rel=1e-9)


# --- What is refused -------------------------------------------------------------------------

STILL = History([0.0, 0.01], [0.0, 0.0], [0.0, 0.0])


@pytest.mark.parametrize("tension", [0.0, -1.0, math.nan])
def test_belt_without_tension_is_refused(tension: float) -> None:
    with pytest.raises(DriveError, match="installed tension"):
        simulate(make_drive(), STILL, tension)


def test_massless_belt_is_refused() -> None:
    with pytest.raises(DriveError, match="mass per length"):
        simulate(make_drive().without_inertia(), STILL, INSTALLED)


@pytest.mark.parametrize(("speed", "why"), [(1.2e4, "critical speed"), (-900.0, "lifts off")])
def test_too_fast_a_belt_is_refused(speed: float, why: str) -> None:
    fast = History([0.0, 0.01], [0.0, speed], [0.0, 0.0])
    with pytest.raises(DriveError, match=why):
        simulate(make_drive(), fast, INSTALLED)


def test_wraps_that_are_not_an_open_belts_are_refused() -> None:
    drive = make_drive()
    crossed = replace(drive, driver=replace(drive.driver, wrap_angle=3.5))
    with pytest.raises(DriveError, match=r"open belt.*3\.14159"):
        simulate(crossed, STILL, INSTALLED)


def test_overlapping_pulleys_are_refused() -> None:
    with pytest.raises(DriveError, match="overlap"):
        simulate(replace(make_drive(), span_length=0.1), STILL, INSTALLED)
    with pytest.raises(DriveError, match="overlap"):
        open_belt(0.1, 0.1, 0.2)


def test_span_of_few_elements_is_refused() -> None:
    near = replace(make_drive(), span_length=2.0 * RADIUS + 0.01)
    with pytest.raises(DriveError, match="more elements"):
        simulate(near, STILL, INSTALLED, Discretisation(6))


@pytest.mark.parametrize(
    ("rows", "why"),
    [
        (([0.0, 0.0], [0.0, 0.0], [0.0, 0.0]), "does not increase after 0 s"),
        (([0.0, 1.0, 0.5], [0.0] * 3, [0.0] * 3), "does not increase after 1 s"),
        (([0.0, 1.0], [0.0, math.nan], [0.0, 0.0]), "NaN"),
        (([0.0, 1.0], [0.0, 0.0], [0.0, math.inf]), "NaN or infinity"),
        (([0.0, 1.0], [0.0], [0.0, 0.0]), "three rows"),
        (([0.0], [0.0], [0.0]), "three rows"),
    ],
)
def test_impossible_history_is_refused(rows: Any, why: str) -> None:
    with pytest.raises(DriveError, match=why):
        History(*rows)


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ({"elements_per_half_pulley": 3}, "too coarse"),
        ({"penalty_ratio": 0.0}, "penalty ratio"),
        ({"axial_damping": 0.0}, r"axial_damping is 0; .* >= 0\.05"),
        ({"contact_damping": -0.1}, "contact_damping"),
        ({"span_damping": math.nan}, "span_damping"),
    ],
)
def test_impossible_discretisation_is_refused(changed: dict[str, Any], why: str) -> None:
    with pytest.raises(DriveError, match=why):
        Discretisation(**changed)


@pytest.mark.parametrize(
    ("duration", "interval", "n", "why"),
    [
        (0.01, 1e-3, 10_000, "elements exceed"),
        (0.01, 0.1, 30, "less than one sampling interval"),
        (20.0, 1e-5, 30, "samples exceed"),
        (20.0, 20.0, 30, "shorter interval"),
        (900.0, 1e-2, 100, "shorter history"),
    ],
)
def test_too_large_a_run_is_refused(duration: float, interval: float, n: int, why: str) -> None:
    history = History([0.0, duration], [0.0, 0.0], [0.0, 0.0])
    with pytest.raises(DriveError, match=why):
        simulate(make_drive(), history, INSTALLED, Discretisation(n), sampling_interval=interval)
