"""Where the paper is inconsistent: its belt's inertia, and its least friction stiffness."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from belt_ros.figures import example, paper, stiffness, style
from belt_ros.figures.simulation import LIFTS, Simulated, friction_misfit
from belt_ros.mechanics import Role

_Floats = NDArray[np.float64]

SHARES = (0.25, 0.5, 1.0, 2.0)  # of kf_min
_ANGLE = np.linspace(0.0, paper.WRAP_ANGLE, 361)
_DASHES = ("-", "--", "-.", ":")


def utilisation(share: float) -> _Floats:
    """Friction over the Coulomb limit [-] along the driven arc, at a `share` of kf_min.

    Between the tensions of Table 2's first column, without inertia.
    """
    kf = share * stiffness.least_stiffness()
    arc = example.along(_ANGLE, Role.DRIVEN, kf, *stiffness.TENSIONS, 0.0)
    return np.asarray(arc.friction / (paper.FRICTION_COEFFICIENT * arc.normal_force))


def draw_inertia(*simulated: Simulated) -> Figure:
    """Show how well the closed form fits finite element friction, against the m v^2 it is given."""
    figure, (axis,) = style.panels("Inertia: the friction that simulation finds wants m v² in")
    colours = (style.BLUE, style.VERMILLION, style.GREEN)
    for one, colour, dash in zip(simulated, colours, _DASHES, strict=False):
        m = one.measured
        ends = m.friction_stiffness, m.slack_tension, m.tight_tension
        misfit = [friction_misfit(one.run, *ends, lift) for lift in LIFTS]
        label = f"$k_f$ = {style.stiffness(m.friction_stiffness)}"
        axis.semilogy(LIFTS, misfit, dash, color=colour, label=label)
    axis.axvline(paper.INERTIA_FORCE, color=style.GREY, lw=1.0)
    axis.annotate(
        f" m v² of Tables 1 and 2, {paper.INERTIA_FORCE:.2f} N",
        (paper.INERTIA_FORCE, 0.95),
        xycoords=("data", "axes fraction"),
        color=style.GREY,
    )
    axis.set_xlim(LIFTS[0], LIFTS[-1])
    axis.set_xlabel("m v² in the closed form [N]; 0 is the paper's example")
    axis.set_ylabel("rms deviation of friction [N/m]")
    axis.legend(loc="lower left")
    return figure


def draw_softer_contact(simulated: Simulated) -> Figure:
    """Show that a contact softer than kf_min carries the same tensions within Coulomb's limit."""
    figure, axes = style.panels(
        "Softer than $k_{f,min}$: the driven belt creeps and stays within Coulomb's limit",
        columns=2,
        share_y=True,
        size=(8.6, 4.2),
    )
    _draw_shares(axes[0])
    m = simulated.measured
    arc = simulated.run.driven_arc
    closed = example.along(
        _ANGLE,
        Role.DRIVEN,
        m.friction_stiffness,
        m.slack_tension,
        m.tight_tension,
        paper.MASS_PER_LENGTH,
    )
    for name, friction, limit, where, dots in (
        ("closed form", closed.friction, closed.normal_force, _ANGLE, False),
        ("finite elements", arc.friction, arc.normal, arc.angle, True),
    ):
        share = friction / (paper.FRICTION_COEFFICIENT * limit)
        line = (
            {"ls": "none", "marker": "o", "ms": 4.0, "mfc": "none", "markevery": 2}
            if dots
            else {"lw": 1.4}
        )
        colour = style.VERMILLION if dots else style.BLUE
        axes[1].plot(np.degrees(where), share, color=colour, label=name, **line)
    axes[1].set_title(
        f"simulated, {style.stiffness(m.friction_stiffness)}: "
        f"{(m.tight_tension - m.slack_tension) * paper.RADIUS:.2f} N m carried"
    )
    for axis in axes:
        axis.axhline(1.0, color=style.GREY, lw=1.0)
        axis.set_xlim(0.0, 180.0)
        axis.set_xticks(np.arange(0.0, 181.0, 30.0))
        axis.set_xlabel("angle from the driven inlet θ [°]")
        axis.legend(loc="upper left", bbox_to_anchor=(0.0, 0.94))
    axes[0].set_ylim(0.0, 1.08)
    axes[0].set_ylabel("friction over Coulomb's limit f/(μn) [-]")
    return figure


def _draw_shares(axis: Axes) -> None:
    colours = (style.BLUE, style.GREEN, style.VERMILLION, style.PURPLE)
    for share, colour, dash in zip(SHARES, colours, _DASHES, strict=True):
        label = f"{share:g} $k_{{f,min}}$"
        axis.plot(np.degrees(_ANGLE), utilisation(share), dash, color=colour, label=label)
    axis.set_title("closed form, tensions of Table 2, column 1")
