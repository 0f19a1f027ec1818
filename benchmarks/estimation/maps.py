"""One number for each cell of the grid, as coloured tables: belts and noises by kf and load."""

import itertools

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from belt_ros.figures.style import panels, sheet
from benchmarks.estimation.cells import BELTS, NOISES, PEAKS, STIFFNESSES, Cell


def cell_maps(
    title: str,
    rows: dict[str, dict[str, float]],
    *,
    centre: float,
    limits: tuple[float, float],
    band: tuple[float, float],
    percent: bool,
    colours: str = "RdBu",
) -> Figure:
    """Draw a row of maps for each entry of `rows`; cells outside `band` are framed.

    Parameters
    ----------
    title : str
    rows : dict
        Values by name of the row and name of the cell.
    centre : float
        Of the colours, white.
    limits : tuple of float
        At which colours are deepest.
    band : tuple of float
    percent : bool
        Write values as percentages, rather than with two digits.
    colours : str
        Name of a colour map; the first of its colours are those of low values.
    """
    columns = list(itertools.product(BELTS, NOISES))
    with sheet():
        figure, axes = panels(
            title,
            len(rows),
            len(columns),
            size=(2.0 * len(columns) + 0.8, 1.9 * len(rows) + 1.0),
            share_x=True,
            share_y=True,
        )
        norm = TwoSlopeNorm(centre, *limits)
        for number, place in enumerate(axes):
            row, column = divmod(number, len(columns))
            name, values = list(rows.items())[row]
            belt, noise = columns[column]
            _map(place, belt, noise, values, norm, band, colours, percent=percent)
            if row == 0:
                place.set_title(f"{belt}, {noise} noise")
            if column == 0:
                place.set_ylabel(f"{name}\nkf [N/m²]")
            if row == len(rows) - 1:
                place.set_xlabel("peak load / told capacity")
        _explain(figure, band, percent=percent)
    return figure


def _map(
    place: Axes,
    belt: str,
    noise: str,
    values: dict[str, float],
    norm: TwoSlopeNorm,
    band: tuple[float, float],
    colours: str,
    *,
    percent: bool,
) -> None:
    """Draw one map, kf upwards and load to the right."""
    shown = np.array(
        [
            [values.get(Cell(belt, kf, peak, noise).name, np.nan) for peak in PEAKS]
            for kf in STIFFNESSES
        ]
    )
    place.imshow(
        np.clip(shown, norm.vmin, norm.vmax), colours, norm=norm, origin="lower", aspect="auto"
    )
    for (row, column), value in np.ndenumerate(shown):
        if np.isnan(value):
            continue
        text = f"{100.0 * value:.0f}" if percent else f"{value:.2f}"
        deep = abs(float(norm(value)) - 0.5) > 0.35
        colour = "white" if deep else "black"
        place.text(column, row, text, ha="center", va="center", fontsize=7.5, color=colour)
        if not band[0] - 1e-9 <= value <= band[1] + 1e-9:
            place.add_patch(Rectangle((column - 0.46, row - 0.46), 0.92, 0.92, fill=False, lw=1.2))
    place.set_xticks(range(len(PEAKS)), [f"{peak:.0%}" for peak in PEAKS], fontsize=7.5)
    place.set_yticks(range(len(STIFFNESSES)), [f"{kf:.1e}" for kf in STIFFNESSES], fontsize=7.5)
    place.grid(visible=False)
    place.tick_params(length=0)


def _explain(figure: Figure, band: tuple[float, float], *, percent: bool) -> None:
    low, high = (f"{edge:.0%}" if percent else f"{edge:g}" for edge in band)
    figure.supxlabel(f"Framed: outside {low} to {high}.", fontsize=8.5)
