"""Tables 1 and 2, and the numbers behind what the paper leaves open, as markdown.

Those that hold finite element results take them as measured numbers, by the names of
`simulation.CASES`.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from belt_ros.figures import angles, evidence, example, paper, stiffness
from belt_ros.figures.simulation import PAPERS, SOFT_CONTACTS, Measured
from belt_ros.mechanics import Kinematics, Role

_Numbers = Mapping[str, Measured]

_LOADS = (250.0, 300.0, 400.0, 600.0, 800.0, 1000.0)  # T_H [N]


def markdown(header: Sequence[str], rows: Iterable[Sequence[str]], *, numbers: bool = True) -> str:
    """Return a markdown table; with `numbers` all but the first column stand right."""
    rule = ["---", *["---:" if numbers else "---"] * (len(header) - 1)]
    return "\n".join("| " + " | ".join(line) + " |" for line in (header, rule, *rows)) + "\n"


def table_1() -> str:
    """Table 1, with the constants of Table 2."""
    return (
        "\n".join(
            "| " + " | ".join(row) + " |"
            for row in (
                ("", "quantity", "printed", "here"),
                ("---",) * 4,
                *((row.symbol, row.name, row.printed, row.here) for row in paper.TABLE_1),
            )
        )
        + "\n"
    )


def power(value: float, digits: int = 1) -> str:
    """Return a number as 2.8e7: `digits` behind the point, no zeros in the exponent."""
    mantissa, exponent = f"{value:.{digits}e}".split("e")
    return f"{mantissa}e{int(exponent)}"


class Row(NamedTuple):
    """A row of Table 2: decimals of a number computed and of a number printed."""

    name: str
    here: int
    printed: int


ROWS = (
    Row("T_L [N]", 1, 1),
    Row("T_H [N]", 1, 1),
    Row("ω₁ [rad/s]", 2, 1),
    Row("driven θ* [rad]", 3, 2),
    Row("driven slip arc [rad]", 3, 2),
    Row("driver θ* [rad]", 3, 2),
    Row("driver slip arc [rad]", 3, 2),
    Row("T_o [N]", 1, 1),
)


def column(
    friction_stiffness: float, slack: float, tight: float, mass: float, kinematics: Kinematics
) -> paper.Column:
    """Return a column of Table 2 as the closed form has it, between given tensions."""
    ends = friction_stiffness, slack, tight, mass
    driven, driver = (example.solve(role, *ends) for role in Role)
    return paper.Column(
        friction_stiffness,
        slack,
        tight,
        example.driven_speed(*ends, kinematics=kinematics),
        float(driven.transition_angle),
        paper.WRAP_ANGLE - float(driven.transition_angle),
        float(driver.transition_angle),
        paper.WRAP_ANGLE - float(driver.transition_angle),
        float(example.initial_tension(*ends)),
        float(driven.inlet_strain_gradient),
    )


def as_in_paper(printed: paper.Column, friction_stiffness: float | None = None) -> paper.Column:
    """Return a printed column computed anew, without inertia and with linear kinematics."""
    kf = printed.friction_stiffness if friction_stiffness is None else friction_stiffness
    ends = printed.slack_tension, printed.tight_tension
    return column(kf, *ends, mass=0.0, kinematics=Kinematics.LINEAR)


def with_inertia(printed: paper.Column) -> paper.Column:
    """Return a printed column computed anew as this package does by default."""
    ends = printed.slack_tension, printed.tight_tension
    kf = printed.friction_stiffness
    return column(kf, *ends, mass=paper.MASS_PER_LENGTH, kinematics=Kinematics.EXACT)


def table_2(measured: _Numbers) -> str:
    """Table 2: printed, closed form without and with inertia, finite elements."""
    return "\n".join(
        f"k_f = {power(printed.friction_stiffness)} N/m²:\n\n{_table_2(printed, measured[name])}"
        for printed, name in zip(paper.TABLE_2, PAPERS, strict=True)
    )


def _table_2(printed: paper.Column, simulated: Measured) -> str:
    """Return one printed column of Table 2 beside what becomes of it here."""
    columns = {"m = 0": as_in_paper(printed), "with inertia": with_inertia(printed)}
    if printed is paper.TABLE_2[0]:
        bound = stiffness.least_stiffness()
        columns = {f"m = 0, k_f = {power(bound, 4)}": as_in_paper(printed, bound), **columns}
    rows = []
    for row, number, finite, *here in zip(
        ROWS,
        printed[1:-1],
        _simulated(simulated),
        *(c[1:-1] for c in columns.values()),
        strict=True,
    ):
        cells = [f"{value:.{row.here}f}" for value in (*here, finite)]
        rows.append([row.name, f"{number:.{row.printed}f}", *cells])
    gradients = [power(values.inlet_gradient) for values in columns.values()]
    known = power(printed.inlet_gradient) if printed.inlet_gradient else "≈ 0"
    rows.append(["du/ds(0)", known, *gradients, "nan"])
    header = ["", "printed", *columns, "finite elements"]
    return markdown(header, ([cell.replace("nan", "–") for cell in row] for row in rows))


def _simulated(m: Measured) -> tuple[float, ...]:
    """Return the rows of Table 2 that a simulation has."""
    wrap = paper.WRAP_ANGLE
    return (
        m.slack_tension,
        m.tight_tension,
        m.driven_speed,
        m.driven_transition,
        wrap - m.driven_transition,
        m.driver_transition,
        wrap - m.driver_transition,
        math.nan,
    )


def limits() -> str:
    """Tight tensions at which the friction zones of figure 10 come and go."""
    names = (
        "driven pulley: elastic creep only up to T_H [N]",
        "driver pulley: elastic creep only up to T_H [N]",
        "both: slip everywhere from T_H [N]",
    )
    rows = zip(
        names, angles.PRINTED, angles.limits(), angles.limits(paper.MASS_PER_LENGTH), strict=True
    )
    header = ("", "printed", "m = 0", "with inertia")
    return markdown(header, ([name, *(f"{value:.0f}" for value in row)] for name, *row in rows))


def driven_speeds(measured: _Numbers) -> str:
    """Return omega1 of all routes, finite elements with the paper's contact stiffness included."""
    header = (
        "k_f [N/m²]",
        "printed ω₁ [rad/s]",
        "equilibrium at printed tensions",
        "finite elements",
        "equilibrium at their tensions",
        "finite elements, 150 kN/m a node",
    )
    rows = []
    for printed, name, soft in zip(paper.TABLE_2, PAPERS, SOFT_CONTACTS, strict=True):
        m = measured[name]
        here = as_in_paper(printed).driven_speed
        speeds = here, m.driven_speed, m.closed_form_speed, measured[soft].driven_speed
        rows.append(
            [
                power(printed.friction_stiffness),
                f"{printed.driven_speed:.1f}",
                *(f"{speed:.3f}" for speed in speeds),
            ]
        )
    return markdown(header, rows)


def torque_balance(measured: _Numbers) -> str:
    """Return (T_H - T_L) R, printed and simulated, beside what momentum asks of 45 N m."""
    needed = paper.TORQUE / (1.0 - paper.INERTIA_FORCE / paper.AXIAL_STIFFNESS)
    rows = []
    for printed, name in zip(paper.TABLE_2, PAPERS, strict=True):
        m = measured[name]
        rows.append(
            [
                power(printed.friction_stiffness),
                f"{(printed.tight_tension - printed.slack_tension) * paper.RADIUS:.2f}",
                f"{(m.tight_tension - m.slack_tension) * paper.RADIUS:.4f}",
                f"{needed:.4f}",
                f"{m.driven_torque:.4f}",
            ]
        )
    header = (
        "k_f [N/m²]",
        "printed (T_H − T_L) R [N m]",
        "finite elements",
        "45 N m / (1 − m v²/EA)",
        "torque on the driven pulley, finite elements",
    )
    return markdown(header, rows)


def inertia(measured: _Numbers) -> str:
    """Return how the friction of finite elements fits the closed form with and without inertia."""
    rows = []
    for name in PAPERS:
        m = measured[name]
        rows.append(
            [
                power(m.friction_stiffness),
                f"{m.friction_rms_without_inertia:.1f}",
                f"{m.friction_rms:.1f}",
                f"{m.friction_peak:.0f}",
                f"{m.best_inertia_force:.2f}",
                f"{m.driven_transition:.3f}, {m.driver_transition:.3f}",
                ", ".join(f"{angle:.3f}" for angle in m.closed_form_transitions),
                ", ".join(f"{angle:.3f}" for angle in _without_inertia(m)),
            ]
        )
    header = (
        "k_f [N/m²]",
        "rms, m = 0 [N/m]",
        "rms, with inertia [N/m]",
        "peak friction [N/m]",
        "m v² that fits best [N]",
        "θ* simulated, driven, driver [rad]",
        "θ* with inertia",
        "θ* with m = 0",
    )
    return markdown(header, rows)


def _without_inertia(m: Measured) -> list[float]:
    ends = m.friction_stiffness, m.slack_tension, m.tight_tension, 0.0
    return [float(example.solve(role, *ends).transition_angle) for role in Role]


def softer_contact(measured: _Numbers) -> str:
    """Return what a contact softer than kf_min carries, in the closed form and simulated."""
    bound = stiffness.least_stiffness()
    ends = stiffness.TENSIONS
    rows = [
        [
            f"closed form, {share:g} k_f,min",
            power(share * bound, 2),
            f"{(ends[1] - ends[0]) * paper.RADIUS:.2f}",
            f"{float(np.max(evidence.utilisation(share))):.3f}",
        ]
        for share in evidence.SHARES
    ]
    m = measured["below kf_min"]
    rows.append(
        [
            "finite elements",
            power(m.friction_stiffness, 2),
            f"{(m.tight_tension - m.slack_tension) * paper.RADIUS:.2f}",
            f"{m.driven_utilisation:.3f}",
        ]
    )
    header = ("driven pulley", "k_f [N/m²]", "(T_H − T_L) R [N m]", "greatest f/(μn)")
    return markdown(header, rows)


def least_stiffness_against_load() -> str:
    """Return kf_min of the driven arc at T_L of section 5: the more it carries, the less it is."""
    rows = []
    for tight in _LOADS:
        bound = example.least_sliding_stiffness(paper.SLACK_TENSION, tight, mass=0.0)
        pull = tight - paper.SLACK_TENSION
        rows.append([f"{tight:.0f}", f"{pull * paper.RADIUS:.1f}", power(bound, 2)])
    return markdown(("T_H [N]", "(T_H − T_L) R [N m]", "k_f,min [N/m²]"), rows)
