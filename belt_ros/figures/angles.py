"""Figure 10: elastic creep arc and slip arc of both pulleys against the tight tension, T_L = 200 N.

Inertia is left out, as in the paper's section 5.
"""

from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from belt_ros.figures import example, paper, style
from belt_ros.mechanics import Role

_Floats = NDArray[np.float64]


class Angles(NamedTuple):
    """Against the tight tension [N], arrays of one shape."""

    tight_tension: _Floats
    driven_transition: _Floats  # theta* [rad]
    driver_transition: _Floats


class Limits(NamedTuple):
    """Tight tensions [N] at which the friction zones of figure 10 come and go."""

    driven_creep: float  # up to which the driven belt creeps elastically everywhere
    driver_creep: float
    full_slip: float  # from which both slide everywhere


PRINTED = Limits(paper.DRIVEN_CREEP_LIMIT, paper.DRIVER_CREEP_LIMIT, paper.FULL_SLIP)


def limits(mass: float = 0.0) -> Limits:
    """Return the limits that the closed form gives for a belt of `mass` [kg/m]."""
    return Limits(
        example.tight_tension_at_onset(Role.DRIVEN, mass),
        example.tight_tension_at_onset(Role.DRIVER, mass),
        example.tight_tension_at_full_slip(mass),
    )


def curves(points: int = 400) -> Angles:
    """Return transition angles from T_L up to full slip."""
    # From just above T_L, where nothing is pulled, to just below gross slip, dense at both ends.
    share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, points + 2)[1:-1])
    greatest = example.tight_tension_at_full_slip(0.0)
    tight = paper.SLACK_TENSION * (greatest / paper.SLACK_TENSION) ** share
    state = paper.FRICTION_STIFFNESS, paper.SLACK_TENSION, tight, 0.0
    return Angles(
        tight,
        example.solve(Role.DRIVEN, *state).transition_angle,
        example.solve(Role.DRIVER, *state).transition_angle,
    )


def draw() -> Figure:
    """Figure 10."""
    figure, (axis,) = style.panels("Figure 10: where elastic creep ends and slip begins")
    found, here = curves(), limits()
    for name, angle, colour in (
        ("driven", found.driven_transition, style.BLUE),
        ("driver", found.driver_transition, style.VERMILLION),
    ):
        degrees = np.degrees(angle)
        axis.plot(found.tight_tension, degrees, color=colour, label=f"transition angle θ*, {name}")
        axis.plot(
            found.tight_tension, 180.0 - degrees, "--", color=colour, label=f"slip arc, {name}"
        )
    heights = (180.0, 180.0, 0.0)
    axis.plot(
        here, heights, "ko", ms=5.0, clip_on=False, zorder=5, label=_numbers("limits here", here)
    )
    axis.plot(
        PRINTED,
        heights,
        "kx",
        ms=8.0,
        mew=1.6,
        clip_on=False,
        zorder=6,
        label=_numbers("printed", PRINTED),
    )
    axis.set_xscale("log")
    axis.set_xlim(200.0, 10000.0)
    axis.set_xticks([200, 300, 500, 1000, 2000, 4000, 8675])
    axis.xaxis.set_major_formatter("{x:.0f}")
    axis.minorticks_off()
    axis.set_ylim(0.0, 180.0)
    axis.set_yticks(np.arange(0.0, 181.0, 30.0))
    axis.set_xlabel("tight tension $T_H$ [N], logarithmic")
    axis.set_ylabel("angle [°]")
    axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def _numbers(name: str, values: Limits) -> str:
    return f"{name}: {values.driver_creep:.0f}, {values.driven_creep:.0f}, {values.full_slip:.0f} N"
