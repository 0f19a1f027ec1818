"""The finite element belt comes to EPP equilibrium: on the paper's drive, softer and unequal."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from finite_elements import (
    INSTALLED,
    RADIUS,
    SPEED,
    TORQUE,
    equilibrium_arc,
    equilibrium_speed,
    make_drive,
    ramp,
    tail,
    tensions,
)

from belt_ros.mechanics import BeltDrive, Pulley, Role, Tensioning, solve_equilibrium
from belt_ros.mechanics.finite_element import FiniteElementRun, simulate
from belt_ros.mechanics.finite_element_mesh import Discretisation

PAPER_STIFFNESSES = (2.8e7, 2e8, 8.1e9)


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


def test_more_elements_come_closer_to_equilibrium() -> None:
    drive = make_drive()
    driven, driver = [], []
    for n in (15, 30, 60):
        damped = Discretisation(n, penalty_ratio=4.0, axial_damping=1.4)
        run = simulate(drive, ramp(0.5, TORQUE), INSTALLED, damped, average_over=0.1)
        errors = profile_errors(drive, run)
        driven.append(errors[0])
        driver.append(errors[1])
    assert driven[0] > 2.0 * driven[1] > 4.0 * driven[2]  # of second order
    assert driver[0] > 2.0 * driver[1] > 2.0 * 1.3 * driver[2]  # its speed is imposed: it rings
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
