"""The life campaign as tables and a picture."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from belt_ros.figures.style import BLUE, VERMILLION, panels, sheet
from benchmarks.estimation.judged import INTERVALS
from benchmarks.estimation.life import Life
from benchmarks.estimation.life_scripts import SCRIPTS
from benchmarks.estimation.report import label, table

_Floats = NDArray[np.float64]
_NAMES = [label(quantity) for quantity in INTERVALS]


def life_sections(rows: list[Life]) -> list[str]:
    """Return the life campaign's tables."""
    phases = _by_phase(rows)
    watched = {name: group[0].watched for name, group in phases.items()}
    return [
        *table(
            ["phase", "what happens"],
            [[script.name, script.about] for script in SCRIPTS if script.name in phases],
            texts=2,
        ),
        "",
        "Share of the instants through the phase at which the truth lies within the 95 % "
        'interval; the time after the phase until everything is right; "never": not by the end of '
        "the run.",
        "",
        *table(
            [
                *("phase", *_NAMES, "sd of slip", "right again: median [s]", "95th percentile [s]"),
                *("never", "NaN", "turned away", "LOST", "restarts", "runs"),
            ],
            [_line(name, group, watched[name]) for name, group in phases.items()],
        ),
    ]


def life_files(rows: list[Life]) -> dict[str, Figure | str]:
    """Return the picture."""
    return {"estimation_life.png": _draw(_by_phase(rows))}


def _by_phase(rows: list[Life]) -> dict[str, list[Life]]:
    groups = {script.name: [row for row in rows if row.case == script.name] for script in SCRIPTS}
    return {name: group for name, group in groups.items() if group}


def _coverage(group: list[Life]) -> _Floats:
    """By quantity (5,); NaN where there was nothing to judge."""
    judged = sum(row.judged for row in group)
    held = np.sum([row.held for row in group], axis=0)
    return held / judged if judged else np.full(len(INTERVALS), np.nan)


def _line(name: str, group: list[Life], watched: float) -> list[str]:
    times = [row.right_after for row in group]
    widths = [row.slip_width for row in group if np.isfinite(row.slip_width)]
    return [
        name,
        *("-" if np.isnan(share) else f"{share:.0%}" for share in _coverage(group)),
        f"{np.median(widths):.2g}" if widths else "-",
        _percentile(times, 0.5, watched),
        _percentile(times, 0.95, watched),
        str(sum(map(bool, np.isnan(times)))),
        str(sum(row.not_numbers for row in group)),
        str(sum(row.rejected for row in group)),
        str(sum(row.lost for row in group)),
        str(sum(row.resets for row in group)),
        str(len(group)),
    ]


def _percentile(times: list[float], share: float, watched: float) -> str:
    """Return the least time by which this share of all runs is right again."""
    ordered = np.sort(np.where(np.isnan(times), np.inf, times))
    value = ordered[int(np.ceil(share * len(ordered))) - 1]
    return f"{value:.2f}" if np.isfinite(value) else f"> {watched:.1f}"


def _draw(phases: dict[str, list[Life]]) -> Figure:
    with sheet():
        figure, (left, right) = panels(
            "The life of a drive", 1, 2, size=(11.0, 0.36 * len(phases) + 1.5), share_y=True
        )
        _draw_coverage(left, phases)
        _draw_times(right, phases)
        left.set_yticks(range(len(phases)), list(phases))
    return figure


def _draw_coverage(place: Axes, phases: dict[str, list[Life]]) -> None:
    shares = np.array([_coverage(group) for group in phases.values()])
    norm = TwoSlopeNorm(0.95, 0.5, 1.15)  # 100 % is pale: it is no fault here
    place.imshow(np.clip(shares, 0.5, 1.0), "RdBu", norm=norm, aspect="auto")
    for (row, column), share in np.ndenumerate(shares):
        text = "–" if np.isnan(share) else f"{share:.0%}"
        colour = "white" if share < 0.6 else "black"
        place.text(column, row, text, ha="center", va="center", color=colour, fontsize=8.5)
    place.set_title("through the phase: share of 95 % intervals that hold")
    place.set_xticks(range(len(_NAMES)), _NAMES)
    place.grid(visible=False)
    place.tick_params(length=0)


def _draw_times(place: Axes, phases: dict[str, list[Life]]) -> None:
    for row, group in enumerate(phases.values()):
        times = np.array([life.right_after for life in group])
        heights = row + np.linspace(-0.28, 0.28, len(group))
        right = np.isfinite(times)
        place.plot(times[right], heights[right], ".", color=BLUE, ms=4.0)
        ends = np.full(int(np.sum(~right)), group[0].watched)
        place.plot(ends, heights[~right], "x", color=VERMILLION, ms=4.0)
    place.set_title("after it: time until all five hold (x: not by the end of the run)")
    place.set_xlabel("s")
