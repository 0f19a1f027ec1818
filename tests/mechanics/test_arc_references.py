"""One pulley arc, against boundary value solutions and the limits in the paper's Figure 10."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from arcs import Floats

from belt_ros.mechanics import ArcSolution, DriveError, Role, solve_arc

REPOSITORY = Path(__file__).resolve().parents[2]
OWN = REPOSITORY / "tests" / "data" / "epp_reference.csv"
SHARED = REPOSITORY.parent / "shared" / "reference"

# --- Reference solutions ---------------------------------------------------------------------


def read(path: Path) -> dict[str, list[str]]:
    if not path.exists():
        pytest.skip(f"{path.name} is not beside this clone")
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: [row[name] for row in rows] for name in rows[0]}


def numbers(table: dict[str, list[str]], name: str) -> Floats:
    return np.array([float(value) for value in table[name]])


def solved_table(table: dict[str, list[str]], columns: list[str]) -> ArcSolution:
    roles = [Role.DRIVEN if role == "driven" else Role.DRIVER for role in table[columns[0]]]
    return solve_arc(roles, *(numbers(table, name) for name in columns[1:]))


SHARED_COLUMNS = [
    "role",
    "radius_m",
    "wrap_rad",
    "friction_coefficient",
    "kf_n_per_m2",
    "axial_stiffness_n",
    "mass_per_length_kg_per_m",
    "inlet_speed_m_per_s",
    "inlet_tension_n",
    "outlet_tension_n",
]


def test_agrees_with_own_boundary_value_solutions_to_the_digits_written() -> None:
    # Twelve digits are written, so 5e-12 is rounding; 4.6e-12 in u'(0) was reached.
    table = read(OWN)
    solution = solved_table(table, list(table)[:10])
    zones = numbers(table, "zones")
    assert len(zones) == 75
    np.testing.assert_allclose(
        solution.inlet_strain_gradient, numbers(table, "inlet_gradient"), rtol=1e-11
    )
    np.testing.assert_allclose(
        solution.transition_angle, numbers(table, "slide_from_rad"), rtol=1e-11
    )
    np.testing.assert_allclose(
        solution.restick_angle, numbers(table, "restick_from_rad"), rtol=1e-11
    )
    np.testing.assert_array_equal(solution.elastic_only, zones == 1)
    np.testing.assert_array_equal(np.isnan(solution.restick_angle), zones < 3)


def test_agrees_with_shared_boundary_value_solutions() -> None:
    table = read(SHARED / "epp_single_pulley.csv")
    solution = solved_table(table, SHARED_COLUMNS)
    np.testing.assert_allclose(
        solution.inlet_strain_gradient, numbers(table, "inlet_strain_gradient"), rtol=1e-8
    )
    np.testing.assert_allclose(
        solution.transition_angle, numbers(table, "transition_angle_rad"), rtol=0, atol=1e-9
    )
    np.testing.assert_array_equal(solution.elastic_only, numbers(table, "elastic_only") == 1)


def test_agrees_with_shared_integrations_that_restick() -> None:
    table = read(SHARED / "epp_restick.csv")
    solution = solved_table(table, SHARED_COLUMNS)
    np.testing.assert_allclose(
        solution.inlet_strain_gradient, numbers(table, "inlet_strain_gradient"), rtol=1e-8
    )
    for angle, name in (
        (solution.transition_angle, "transition_angle_rad"),
        (solution.restick_angle, "restick_angle_rad"),
    ):
        np.testing.assert_allclose(angle, numbers(table, name), rtol=0, atol=1e-9)


# --- The paper's limits ----------------------------------------------------------------------


def paper_arc(role: Role, tight: float) -> ArcSolution:
    tensions = (200.0, tight) if role is Role.DRIVEN else (tight, 200.0)
    return solve_arc(role, 0.08125, math.pi, 1.2, 8.1e7, 80068.0, 0.0, 9.75, *tensions)


@pytest.mark.parametrize(("role", "limit"), [(Role.DRIVEN, 373.0), (Role.DRIVER, 293.0)])
def test_figure_10_elastic_creep_alone_up_to_its_limit(role: Role, limit: float) -> None:
    assert paper_arc(role, limit - 0.5).elastic_only
    assert not paper_arc(role, limit + 0.5).elastic_only


@pytest.mark.parametrize("role", list(Role))
def test_figure_10_full_slip_at_8675_newton(role: Role) -> None:
    assert float(paper_arc(role, 8675.0).transition_angle) < 1e-3
    with pytest.raises(DriveError, match="gross slip"):
        paper_arc(role, 8676.0)
