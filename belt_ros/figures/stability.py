"""Figure 5: the first three modes of a driven arc about its equilibrium, Eqs. 61-69.

The paper says "a typical drive". Here it is that of Table 1 under the torque of Table 2.
"""

import numpy as np
from matplotlib.figure import Figure

from belt_ros.figures import example, paper, style
from belt_ros.mechanics.stability import Modes, drive_modes


def modes() -> Modes:
    """Return the first three modes of the driven arc."""
    drive = example.drive(paper.FRICTION_STIFFNESS)
    return drive_modes(drive, paper.TORQUE, example.INSTALLED_TENSION, paper.DRIVER_SPEED).driven


def draw() -> Figure:
    """Figure 5."""
    figure, (axis,) = style.panels("Figure 5: how the belt on the driven pulley vibrates")
    found = modes()
    angle = np.linspace(0.0, paper.WRAP_ANGLE, 361)
    lines = (("-", style.BLUE), ("--", style.VERMILLION), ("-.", style.GREEN))
    rows = zip(found.shapes(angle), found.frequencies, lines, strict=True)
    for number, (shape, omega, (dash, colour)) in enumerate(rows, start=1):
        label = f"mode {number}: {omega.real:,.0f} rad/s,\ndecays at {omega.imag:,.0f} 1/s"
        axis.plot(paper.RADIUS * angle, shape.real, dash, color=colour, label=label)
    length = paper.RADIUS * paper.WRAP_ANGLE
    transition = found.zones[0].length * length
    axis.axvline(transition, color=style.GREY, lw=1.0)
    for zone, side, shift in (("elastic creep", "right", -6), ("slip", "left", 6)):
        axis.annotate(
            zone,
            (transition, 1.06),
            xytext=(shift, 0),
            textcoords="offset points",
            color=style.GREY,
            ha=side,
        )
    axis.set_xlim(0.0, length)
    axis.set_ylim(-1.05, 1.18)
    axis.set_xlabel("arc length from the inlet s [m]")
    axis.set_ylabel("eigenfunction, real part [-]")
    axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), labelspacing=1.0)
    return figure
