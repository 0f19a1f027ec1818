"""How the figures look: one size of type, colours that the colour-blind can tell apart."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

# Okabe and Ito's palette
BLUE = "#0072b2"
VERMILLION = "#d55e00"
GREEN = "#009e73"
PURPLE = "#a2508a"
GREY = "#707070"

_SHEET = {
    "axes.grid": True,
    "axes.labelsize": 10.0,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 10.0,
    "figure.constrained_layout.use": True,
    "figure.titlesize": 11.5,
    "font.size": 9.5,
    "grid.alpha": 0.3,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
}
_DPI = 110


@contextmanager
def sheet() -> Iterator[None]:
    """Draw in this style, whatever the user's own settings are."""
    with style.context(["default", _SHEET]):
        yield


def panels(
    title: str,
    rows: int = 1,
    columns: int = 1,
    *,
    size: tuple[float, float] = (8.0, 4.2),
    share_y: bool = False,
    share_x: bool = False,
    heights: tuple[float, ...] | None = None,
) -> tuple[Figure, list[Axes]]:
    """Return an empty figure of `size` [inch] and its axes, row by row."""
    figure = Figure(figsize=size)
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    ratios = {} if heights is None else {"height_ratios": heights}
    axes = figure.subplots(
        rows, columns, squeeze=False, sharex=share_x, sharey=share_y, gridspec_kw=ratios
    )
    return figure, list(axes.flat)


def stiffness(value: float) -> str:
    """Return a friction stiffness [N/m2] as mathematical text with its unit."""
    digits, exponent = f"{value:.1e}".split("e")
    return f"${digits} \\times 10^{{{int(exponent)}}}$ N/m²"


def shades(count: int) -> NDArray[np.float64]:
    """Return colours (count, 4) from dark to light that grade a quantity."""
    return np.asarray(mpl.colormaps["viridis"](np.linspace(0.0, 0.88, count)))


def save(figure: Figure, path: Path) -> None:
    """Write a PNG that depends on nothing but the drawing."""
    figure.savefig(path, dpi=_DPI, metadata={"Software": None})
