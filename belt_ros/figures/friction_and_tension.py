"""Figures 6 to 9: friction and tension along both arcs as the tight tension rises, T_L = 200 N.

Inertia is left out, as in the paper's section 5.
"""

from typing import Literal, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from belt_ros.figures import example, paper, style
from belt_ros.mechanics import Role
from belt_ros.mechanics.coulomb_arc import coulomb_profile

_Floats = NDArray[np.float64]
Law = Literal["Coulomb", "EPP"]

ANGLE = np.linspace(0.0, paper.WRAP_ANGLE, 541)
TIGHT_TENSIONS = np.arange(paper.TIGHT_TENSIONS[0], paper.TIGHT_TENSIONS[1] + 1.0, 600.0)


class Curves(NamedTuple):
    """Along an arc, rows for every tight tension."""

    friction: _Floats  # [N/m]
    tension: _Floats  # [N]


def curves(law: Law, role: Role) -> Curves:
    """Return friction and tension at `ANGLE` (columns) for `TIGHT_TENSIONS` (rows)."""
    tight = TIGHT_TENSIONS[:, np.newaxis]
    if law == "EPP":
        epp = example.along(
            ANGLE, role, paper.FRICTION_STIFFNESS, paper.SLACK_TENSION, tight, mass=0.0
        )
        return Curves(epp.friction, epp.tension)
    slack = np.full_like(tight, paper.SLACK_TENSION)
    inlet, outlet = (slack, tight) if role is Role.DRIVEN else (tight, slack)
    coulomb = coulomb_profile(
        role,
        paper.RADIUS,
        paper.WRAP_ANGLE,
        paper.FRICTION_COEFFICIENT,
        paper.AXIAL_STIFFNESS,
        0.0,
        paper.BELT_SPEED,
        inlet,
        outlet,
        ANGLE,
    )
    return Curves(coulomb.friction, coulomb.tension)


def draw_friction(law: Law) -> Figure:
    """Figure 6 or 7: friction per length, by its amount on either pulley."""
    number = 6 if law == "Coulomb" else 7
    return _draw(law, f"Figure {number}: friction on the belt, {law} friction", "friction")


def draw_tension(law: Law) -> Figure:
    """Figure 8 or 9: the belt's tension."""
    number = 8 if law == "Coulomb" else 9
    return _draw(law, f"Figure {number}: tension in the belt, {law} friction", "tension")


def _draw(law: Law, title: str, quantity: Literal["friction", "tension"]) -> Figure:
    figure, axes = style.panels(title, columns=2, share_y=True)
    for axis, role in zip(axes, Role, strict=True):
        values = 1e-3 * np.abs(getattr(curves(law, role), quantity))
        for row, tight, colour in zip(
            values, TIGHT_TENSIONS, style.shades(TIGHT_TENSIONS.size), strict=True
        ):
            axis.plot(np.degrees(ANGLE), row, color=colour, label=f"{tight:.0f} N")
        axis.set_title(f"{role.name.lower()} pulley")
        axis.set_xlabel("angle from the inlet θ [°]")
        axis.set_xlim(0.0, 180.0)
        axis.set_xticks(np.arange(0.0, 181.0, 30.0))
        axis.set_ylim(bottom=0.0)
    label = "friction force f [kN/m]" if quantity == "friction" else "tension T [kN]"
    axes[0].set_ylabel(label)
    handles, labels = axes[0].get_legend_handles_labels()
    axes[1].legend(
        handles[::-1],
        labels[::-1],
        title="tight tension $T_H$",
        loc="center left",
        bbox_to_anchor=(1.0, 0.5),
    )
    return figure
