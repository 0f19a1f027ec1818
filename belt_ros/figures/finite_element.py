"""Figures 14 to 16: contact forces of the finite element belt against the closed form."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from belt_ros.figures import example, paper, style
from belt_ros.figures.simulation import Measured, Simulated, arcs, residuals
from belt_ros.mechanics import Role

_NUMBERS = {2.8e7: 14, 2e8: 15, 8.1e9: 16}
_TITLES = {
    14: "a contact at $k_{f,min}$",
    15: "a contact of medium stiffness",
    16: "a stiff contact",
}
_START = {Role.DRIVEN: 0.0, Role.DRIVER: 180.0}  # of the angle drawn [deg]
_FINE = np.linspace(0.0, paper.WRAP_ANGLE, 721)


def draw(simulated: Simulated) -> Figure:
    """Figure 14, 15 or 16, whichever the friction stiffness makes it."""
    number = _NUMBERS[simulated.measured.friction_stiffness]
    figure, (forces, errors) = style.panels(
        f"Figure {number}: contact forces, {_TITLES[number]} "
        f"($k_f$ = {style.stiffness(simulated.measured.friction_stiffness)})",
        rows=2,
        size=(8.0, 5.6),
        share_x=True,
        heights=(2.0, 1.0),
    )
    _draw_forces(forces, simulated)
    _draw_errors(errors, simulated)
    for axis in (forces, errors):
        axis.axvline(180.0, color=style.GREY, lw=1.0)
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    errors.set_xlim(0.0, 360.0)
    errors.set_xticks(np.arange(0.0, 361.0, 45.0))
    errors.set_xlabel("angle θ [°]: driven pulley from 0°, driver from 180°")
    return figure


def _ends(measured: Measured) -> tuple[float, float, float]:
    return measured.friction_stiffness, measured.slack_tension, measured.tight_tension


def _draw_forces(axis: Axes, simulated: Simulated) -> None:
    for role, arc in arcs(simulated.run):
        closed = example.along(_FINE, role, *_ends(simulated.measured), paper.MASS_PER_LENGTH)
        first = role is Role.DRIVEN
        for name, line, dots, colour in (
            ("normal", closed.normal_force, arc.normal, style.GREEN),
            ("friction", closed.friction, arc.friction, style.BLUE),
        ):
            axis.plot(
                np.degrees(arc.angle) + _START[role],
                1e-3 * dots,
                "o",
                ms=3.8,
                mfc="none",
                mec=colour,
                mew=0.8,
                markevery=2,
                label=f"{name}, finite elements" if first else None,
            )
            axis.plot(
                np.degrees(_FINE) + _START[role],
                1e-3 * line,
                color="black",
                lw=1.0,
                label="closed form" if first and name == "friction" else None,
            )
    axis.set_ylabel("force per length [kN/m]")


def _draw_errors(axis: Axes, simulated: Simulated) -> None:
    """Draw what the closed form misses of the friction, with and without inertia."""
    inner = 0.0
    for role, arc in arcs(simulated.run):
        for lift, label, dash, colour in (
            (paper.INERTIA_FORCE, "with inertia", "-", style.BLUE),
            (0.0, "without", "--", style.VERMILLION),
        ):
            missed = residuals(role, arc, *_ends(simulated.measured), lift)
            inner = max(inner, float(np.max(np.abs(missed[1:-1]))))
            axis.plot(
                np.degrees(arc.angle) + _START[role],
                missed,
                dash,
                color=colour,
                lw=1.2,
                label=label if role is Role.DRIVEN else None,
            )
    axis.set_ylim(-1.1 * inner, 1.1 * inner)
    axis.set_ylabel("friction, finite\nelements less\nclosed form [N/m]")
