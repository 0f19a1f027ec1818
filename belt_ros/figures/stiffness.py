"""Figures 11 to 13: inlet tension T_o and inlet strain du/ds(0) against the friction stiffness.

The driven arc, between the tensions of Table 2's first column; inertia is left out. Below kf_min
(Eqs. 57-60) the curves go on, though the paper's do not: see `evidence`.
"""

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from belt_ros.figures import example, paper, style
from belt_ros.mechanics import Role

_Floats = NDArray[np.float64]

TENSIONS = paper.TABLE_2[0].slack_tension, paper.TABLE_2[0].tight_tension
_SOFTEST, _STIFF, _STIFFEST = 1e7, 1e8, 8.1e9


def initial_tension(friction_stiffness: ArrayLike) -> _Floats:
    """Return T_o [N] at kf [N/m2]."""
    return example.initial_tension(friction_stiffness, *TENSIONS, mass=0.0)


def inlet_gradient(friction_stiffness: ArrayLike) -> _Floats:
    """Return du/ds(0) [-] at kf [N/m2]."""
    return example.solve(Role.DRIVEN, friction_stiffness, *TENSIONS, 0.0).inlet_strain_gradient


def least_stiffness() -> float:
    """Return kf_min [N/m2]."""
    return example.least_sliding_stiffness(*TENSIONS, mass=0.0)


def draw_initial_tension() -> Figure:
    """Figure 11."""
    figure, (axis,) = style.panels("Figure 11: the stiffer the contact, the closer $T_o$ to $T_L$")
    _curve(axis, initial_tension)
    axis.axhline(TENSIONS[0], color=style.GREY, lw=1.0, ls=":", label="slack tension $T_L$")
    printed = paper.TABLE_2[0]
    axis.plot(
        printed.friction_stiffness, printed.initial_tension, "kx", ms=8.0, mew=1.6, label="Table 2"
    )
    axis.set_ylabel("initial tension $T_o$ [N]")
    axis.legend(loc="lower right")
    return figure


def draw_inlet_gradient() -> Figure:
    """Figure 12."""
    figure, (axis,) = style.panels("Figure 12: the strain with which the belt meets the pulley")
    _curve(axis, lambda kf: 1e4 * inlet_gradient(kf))
    kf, printed = _printed(2)
    axis.plot(kf, 1e4 * printed, "kx", ms=8.0, mew=1.6, label="Table 2")
    axis.set_ylim(bottom=0.0)
    axis.set_ylabel("initial incremental strain du/ds(0) [10⁻⁴]")
    axis.legend(loc="upper right")
    return figure


def draw_inlet_gradient_detail() -> Figure:
    """Figure 13."""
    figure, axes = style.panels("Figure 13: small at large stiffness, and never zero", columns=2)
    kf, printed = _printed(2)
    near = np.linspace(_STIFF, 3.0 * _STIFF, 300)
    axes[0].plot(1e-8 * near, 1e6 * inlet_gradient(near), color=style.BLUE)
    axes[0].plot(1e-8 * kf[1], 1e6 * printed[1], "kx", ms=8.0, mew=1.6, label="Table 2")
    axes[0].set_xlabel("friction stiffness $k_f$ [10⁸ N/m²]")
    axes[0].set_ylabel("du/ds(0) [10⁻⁶]")
    axes[0].set_ylim(bottom=0.0)
    far = np.geomspace(_STIFF, _STIFFEST, 300)
    axes[1].loglog(far, inlet_gradient(far), color=style.BLUE)
    axes[1].plot(kf[1], printed[1], "kx", ms=8.0, mew=1.6, label="Table 2")
    axes[1].set_xlabel("friction stiffness $k_f$ [N/m²], logarithmic")
    axes[1].set_ylabel("du/ds(0) [-], logarithmic")
    for axis in axes:
        axis.legend()
    return figure


def _printed(count: int) -> tuple[_Floats, _Floats]:
    """Return kf and du/ds(0) of the first columns of Table 2."""
    columns = paper.TABLE_2[:count]
    return (
        np.array([column.friction_stiffness for column in columns]),
        np.array([column.inlet_gradient for column in columns]),
    )


def _curve(axis: Axes, quantity: Callable[[ArrayLike], _Floats]) -> None:
    """Draw a quantity from below kf_min to where it no longer changes."""
    bound = least_stiffness()
    soft = np.geomspace(_SOFTEST, bound, 200)
    stiff = np.geomspace(bound, 3.0 * _STIFF, 300)
    axis.semilogx(stiff, quantity(stiff), color=style.BLUE, label="creep, then slip")
    axis.semilogx(soft, quantity(soft), "--", color=style.VERMILLION, label="elastic creep only")
    axis.axvline(bound, color=style.GREY, lw=1.0)
    axis.annotate(
        f"$k_{{f,min}}$ = {1e-7 * bound:.3f}·10⁷ N/m²",
        (bound, 0.5),
        xycoords=("data", "axes fraction"),
        xytext=(5, 0),
        textcoords="offset points",
        color=style.GREY,
    )
    axis.set_xlabel("friction stiffness $k_f$ [10⁷ N/m²], logarithmic")
    axis.set_xlim(_SOFTEST, 3.0 * _STIFF)
    axis.set_xticks([1e7, 2e7, 5e7, 1e8, 2e8, 3e8], labels=["1", "2", "5", "10", "20", "30"])
    axis.minorticks_off()
