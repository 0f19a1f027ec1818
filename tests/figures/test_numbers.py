"""The curves' data against what the paper prints."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from belt_ros.figures import angles, evidence, example, paper, simulation, stability, stiffness
from belt_ros.figures import friction_and_tension as arcs
from belt_ros.figures.tables import as_in_paper, with_inertia
from belt_ros.mechanics import Role

MEASURED = simulation.from_document(
    json.loads(
        (Path(__file__).resolve().parents[2] / "docs/figures/finite_element.json").read_text()
    )
)


# --- Tables ----------------------------------------------------------------------------------


@pytest.mark.parametrize("printed", paper.TABLE_2[1:], ids=["2e8", "8.1e9"])
def test_table_2_comes_out_without_inertia(printed: paper.Column) -> None:
    here = as_in_paper(printed)
    for name in ("driven_transition", "driven_slip_arc", "driver_transition", "driver_slip_arc"):
        assert round(getattr(here, name), 2) == getattr(printed, name), name
    assert round(here.initial_tension, 1) == printed.initial_tension
    assert here.inlet_gradient == pytest.approx(printed.inlet_gradient, abs=5e-9)


def test_first_column_comes_out_at_the_unrounded_kf_min() -> None:
    printed = paper.TABLE_2[0]
    bound = stiffness.least_stiffness()
    assert bound == pytest.approx(2.7678e7, rel=2e-5)
    assert round(bound, -6) == printed.friction_stiffness
    here = as_in_paper(printed, bound * (1.0 - 1e-9))
    assert here.driven_transition == math.pi
    assert round(here.driver_transition, 2) == printed.driver_transition
    assert round(here.driver_slip_arc, 2) == printed.driver_slip_arc
    assert round(here.initial_tension, 1) == printed.initial_tension
    assert here.inlet_gradient == pytest.approx(printed.inlet_gradient, abs=5e-6)


def test_first_column_slides_at_the_printed_stiffness() -> None:
    here = as_in_paper(paper.TABLE_2[0])
    assert here.driven_transition == pytest.approx(3.125, abs=5e-4)
    assert here.driven_slip_arc == pytest.approx(0.017, abs=5e-4)
    assert here.initial_tension == pytest.approx(146.6, abs=0.05)


def test_inertia_moves_every_angle_of_table_2_off_the_printed_one() -> None:
    expected = ((3.078, 2.298), (2.115, 2.039), (1.892, 1.890))
    for printed, (driven, driver) in zip(paper.TABLE_2, expected, strict=True):
        here = with_inertia(printed)
        assert here.driven_transition == pytest.approx(driven, abs=1e-3)
        assert here.driver_transition == pytest.approx(driver, abs=1e-3)
        assert round(here.driven_transition, 2) != printed.driven_transition
        assert round(here.driver_transition, 2) != printed.driver_transition


def test_equilibrium_speeds_are_within_a_tenth_of_the_printed_one() -> None:
    speeds = [as_in_paper(printed).driven_speed for printed in paper.TABLE_2]
    assert speeds == pytest.approx([119.13, 119.16, 119.18], abs=5e-3)
    assert speeds == pytest.approx([p.driven_speed for p in paper.TABLE_2], abs=0.1)


def test_printed_tensions_do_not_balance_the_torque() -> None:
    moments = [(p.tight_tension - p.slack_tension) * paper.RADIUS for p in paper.TABLE_2]
    assert moments == pytest.approx([45.2, 45.6, 44.6], abs=0.05)
    assert moments == pytest.approx([paper.TORQUE] * 3, rel=0.015)


# --- Figures ---------------------------------------------------------------------------------


def test_modes_of_figure_5_are_held_at_the_inlet_and_decay() -> None:
    modes = stability.modes()
    assert modes.is_stable
    assert np.all(modes.frequencies.imag > 0.0)
    assert np.all(np.diff(modes.frequencies.real) > 0.0)
    shapes = modes.shapes(np.linspace(0.0, math.pi, 721))
    assert np.abs(shapes[:, 0]) == pytest.approx(0.0, abs=1e-12)
    slope_at_outlet = np.abs(shapes[:, -1] - shapes[:, -2])
    assert np.all(slope_at_outlet < 1e-3 * np.abs(shapes[:, 1] - shapes[:, 0]).max() * 721)


@pytest.mark.parametrize("law", ["Coulomb", "EPP"])
@pytest.mark.parametrize("role", Role)
def test_tension_of_figures_8_and_9_runs_from_span_to_span(law: arcs.Law, role: Role) -> None:
    tension = arcs.curves(law, role).tension
    slack, tight = (0, -1) if role is Role.DRIVEN else (-1, 0)
    assert tension[:, slack] == pytest.approx(200.0)
    assert tension[:, tight] == pytest.approx(arcs.TIGHT_TENSIONS)
    assert arcs.TIGHT_TENSIONS[[0, -1]] == pytest.approx(paper.TIGHT_TENSIONS)


@pytest.mark.parametrize("law", ["Coulomb", "EPP"])
@pytest.mark.parametrize("role", Role)
def test_friction_of_figures_6_and_7_is_the_change_of_tension(law: arcs.Law, role: Role) -> None:
    """A step of Coulomb friction is off by at most half an interval in the trapezoidal rule."""
    curves = arcs.curves(law, role)
    step = arcs.ANGLE[1] - arcs.ANGLE[0]
    total = (
        (curves.friction[:, 1:] + curves.friction[:, :-1]).sum(axis=1) * 0.5 * step * paper.RADIUS
    )
    half = 0.5 * step * paper.RADIUS * np.abs(curves.friction).max(axis=1)
    assert np.all(np.abs(total - role * (arcs.TIGHT_TENSIONS - 200.0)) <= half)


@pytest.mark.parametrize("role", Role)
def test_coulomb_friction_jumps_and_epp_friction_does_not(role: Role) -> None:
    def greatest_step(law: arcs.Law) -> np.ndarray:
        friction = np.abs(arcs.curves(law, role).friction)
        return np.abs(np.diff(friction, axis=1)).max(axis=1) / friction.max(axis=1)

    least = 0.04 if role is Role.DRIVEN else 0.9  # mu T/R at T_L of T_H, at T_H of T_H
    adhesion = np.abs(arcs.curves("Coulomb", role).friction[:, 0])
    assert np.all(adhesion == 0.0)
    assert np.all(greatest_step("Coulomb") > least)
    assert np.all(greatest_step("EPP") < 0.03)


def test_limits_of_figure_10_are_near_the_printed_ones() -> None:
    here = angles.limits()
    assert here == pytest.approx((373.0, 293.0, 8675.0), abs=0.5)
    assert here.driven_creep == pytest.approx(paper.DRIVEN_CREEP_LIMIT, rel=0.02)
    assert here.driver_creep == pytest.approx(paper.DRIVER_CREEP_LIMIT, rel=0.06)
    assert here.full_slip == pytest.approx(paper.FULL_SLIP, rel=2e-4)


@pytest.mark.parametrize(("mass", "off"), [(0.0, 1e-6), (paper.MASS_PER_LENGTH, 1e-4)])
@pytest.mark.parametrize("role", Role)
def test_limits_of_creep_part_the_regimes(role: Role, mass: float, off: float) -> None:
    """With inertia a lone arc goes by its own inlet speed, a drive by one speed: 1e-4 apart."""
    limit = example.tight_tension_at_onset(role, mass)
    for factor, creeps in ((1.0 - off, True), (1.0 + off, False)):
        arc = example.solve(role, paper.FRICTION_STIFFNESS, 200.0, limit * factor, mass)
        assert bool(arc.elastic_only) is creeps


def test_printed_limits_of_creep_contradict_each_other() -> None:
    def product(limits: angles.Limits) -> float:
        return (2.0 - limits.driver_creep / 200.0) * limits.driven_creep / 200.0

    assert product(angles.limits()) == pytest.approx(1.0, abs=2e-3)
    assert product(angles.PRINTED) == pytest.approx(0.855, abs=1e-6)


def test_driven_creep_arc_of_figure_10_is_the_larger() -> None:
    curves = angles.curves()
    assert np.all(np.diff(curves.driven_transition) <= 0.0)
    assert np.all(np.diff(curves.driver_transition) <= 0.0)
    assert np.all(curves.driven_transition >= curves.driver_transition - 1e-9)
    assert curves.driven_transition[-1] < math.radians(1.0)


def test_initial_tension_of_figure_11_converges_to_the_slack_one() -> None:
    values = stiffness.initial_tension(np.geomspace(1e7, 8.1e9, 50))
    assert np.all(np.diff(values) >= 0.0)
    assert values[-1] == pytest.approx(156.2, abs=1e-9)


def test_strain_of_figures_12_and_13_falls_and_is_never_zero() -> None:
    values = stiffness.inlet_gradient(np.geomspace(1e7, 8.1e9, 50))
    assert np.all(np.diff(values) < 0.0)
    assert 0.0 < values[-1] < 1e-24


# --- Where the paper is inconsistent ---------------------------------------------------------


def test_softer_contact_stays_within_the_coulomb_limit() -> None:
    greatest = [float(np.max(evidence.utilisation(share))) for share in (0.25, 0.5, 1.0)]
    assert greatest[0] < greatest[1] < greatest[2]
    assert greatest == pytest.approx([0.592, 0.745, 1.0], abs=5e-4)


def test_softer_contact_is_simulated_to_carry_the_torque() -> None:
    soft = MEASURED["below kf_min"]
    assert soft.friction_stiffness < 0.51 * stiffness.least_stiffness()
    assert soft.driven_torque == pytest.approx(paper.TORQUE, rel=1e-3)
    assert soft.driven_utilisation < 0.8
    assert soft.driven_transition == pytest.approx(math.pi, rel=1e-6)


def test_table_1_is_below_the_minimum_for_part_of_figure_10() -> None:
    bounds = [
        example.least_sliding_stiffness(200.0, tight, mass=0.0) for tight in (300.0, 372.0, 374.0)
    ]
    assert bounds[0] > bounds[1] > paper.FRICTION_STIFFNESS > bounds[2]


def test_coulomb_slip_arc_is_near_the_printed_one() -> None:
    printed = paper.TABLE_2[2]
    slip = math.log(printed.tight_tension / printed.slack_tension) / paper.FRICTION_COEFFICIENT
    assert slip == pytest.approx(1.24, abs=0.01)


@pytest.mark.parametrize("name", simulation.PAPERS)
def test_simulated_friction_wants_inertia(name: str) -> None:
    m = MEASURED[name]
    assert m.friction_rms < 0.005 * m.friction_peak
    assert m.friction_rms_without_inertia > 15.0 * m.friction_rms
    assert m.best_inertia_force == pytest.approx(paper.INERTIA_FORCE, abs=0.5)


@pytest.mark.parametrize("name", simulation.PAPERS)
def test_simulated_transitions_are_those_with_inertia(name: str) -> None:
    m = MEASURED[name]
    simulated = m.driven_transition, m.driver_transition
    assert simulated == pytest.approx(m.closed_form_transitions, abs=0.01)
    for role, angle in zip(Role, simulated, strict=True):
        ends = m.friction_stiffness, m.slack_tension, m.tight_tension
        without = float(example.solve(role, *ends, 0.0).transition_angle)
        assert without - angle > 0.03


@pytest.mark.parametrize("name", simulation.PAPERS)
def test_simulated_tensions_balance_the_torque(name: str) -> None:
    m = MEASURED[name]
    needed = paper.TORQUE / (1.0 - paper.INERTIA_FORCE / paper.AXIAL_STIFFNESS)
    assert (m.tight_tension - m.slack_tension) * paper.RADIUS == pytest.approx(needed, rel=5e-5)
    assert m.tight_tension + m.slack_tension == pytest.approx(868.0, abs=3.0)
    assert m.driven_speed == pytest.approx(m.closed_form_speed, abs=2e-3)


@pytest.mark.slow
def test_simulation_repeats_what_is_on_file() -> None:
    fresh = simulation.run_case(simulation.CASES["medium"]).measured
    filed = MEASURED["medium"]
    for name in (
        "slack_tension",
        "tight_tension",
        "driven_speed",
        "driven_transition",
        "driver_transition",
        "friction_rms_without_inertia",
    ):
        assert getattr(fresh, name) == pytest.approx(getattr(filed, name), rel=1e-3), name
    assert fresh.friction_rms == pytest.approx(filed.friction_rms, rel=0.05)
