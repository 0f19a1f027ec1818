"""Campaigns as Markdown tables."""

import os
import platform
from collections.abc import Sequence
from datetime import datetime, timezone
from importlib.metadata import version

import numpy as np

from benchmarks.estimation.cells import BELTS, NOISES, PEAKS, STIFFNESSES, Cell
from benchmarks.estimation.judged import INTERVALS, Row
from benchmarks.estimation.statistics import (
    BAND,
    Held,
    by_case,
    held,
    scores,
    share_at_nominal,
    share_within,
)

_LABELS = {"tight_tension": "T_H", "slack_tension": "T_L", "ln_kf": "ln kf"}
_WORST = 12


def label(quantity: str) -> str:
    """Return a quantity's name in tables."""
    return _LABELS.get(quantity, quantity)


def made_with(command: str, rows: Sequence[Row]) -> str:
    """Return date, versions, machine class and the code that was judged."""
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "numba", "filterpy"))
    sources = sorted({row.sources for row in rows})
    mixed = " **Rows of different code are mixed.**" if len(sources) > 1 else ""
    return (
        f"{datetime.now(timezone.utc):%Y-%m-%d}, Python {platform.python_version()}, {packages}, "
        f"{os.cpu_count()} cores of {platform.machine()}; code {', '.join(sources)}.{mixed} "
        f"`python -m benchmarks.estimation {command}`"
    )


def table(head: Sequence[str], lines: Sequence[Sequence[str]], texts: int = 1) -> list[str]:
    """Return a Markdown table whose first `texts` columns are text, the others numbers."""
    rule = ["---"] * texts + ["---:"] * (len(head) - texts)
    return [f"| {' | '.join(line)} |" for line in (head, rule, *lines)]


def coverage_line(name: str, found: Held) -> list[str]:
    """Return one line of a coverage table."""
    return [
        name,
        *(f"{found.coverage[quantity]:.0%}" for quantity in INTERVALS),
        f"{found.together:.1%}",
        f"{found.tolerance:.1%}",
        f"{found.mean_score['margin']:+.2f}",
        f"{found.nees:.2f}",
        f"{found.median_nees:.2f}",
        str(found.runs),
    ]


COVERAGE_HEAD = [
    *(label(quantity) for quantity in INTERVALS),
    "all",
    "+/-",
    "margin's mean z",
    "NEES/dof",
    "its median",
    "runs",
]


def grid_sections(rows: list[Row]) -> list[str]:
    """Return the grid campaign's tables."""
    cells = {name: held(group) for name, group in by_case(rows).items()}
    return [
        *_pooled(rows),
        "",
        *_cell_summary(cells, rows),
        "",
        f"Coverage of all five together, {'/'.join(NOISES)} noise:",
        "",
        *_pivot(cells),
        "",
        f"The {_WORST} cells of least coverage:",
        "",
        *_worst(cells),
    ]


def _pooled(rows: list[Row]) -> list[str]:
    """Coverage by belt, by noise, by peak load and of all."""
    parts = [("all", "")]
    parts += [(f"{belt} belt", f"{belt} ") for belt in BELTS]
    parts += [(f"load {peak:.0%}", f"load {peak:.0%}") for peak in PEAKS]
    parts += [(f"{noise} noise", f" {noise}") for noise in NOISES]
    lines = []
    for name, text in parts:
        if chosen := [row for row in rows if text in row.case]:
            lines.append(coverage_line(name, held(chosen)))
    return table(["runs of", *COVERAGE_HEAD], lines)


def _cell_summary(cells: dict[str, Held], rows: list[Row]) -> list[str]:
    judged = len(rows) // len(cells)
    nominal = share_at_nominal(judged)
    lines = []
    for quantities in (*((quantity,) for quantity in INTERVALS), INTERVALS):
        coverage = {
            name: sum(cell.coverage[quantity] for quantity in quantities) / len(quantities)
            for name, cell in cells.items()
        }
        worst = min(coverage, key=lambda name: coverage[name])
        z = scores(rows, quantities)
        lines.append(
            [
                label(quantities[0]) if len(quantities) == 1 else "all five",
                worst,
                f"{coverage[worst]:.0%}",
                f"{share_within(coverage.values()):.0%}",
                f"{np.mean(z):+.2f}",
                f"{np.sqrt(np.mean(z**2)):.2f}",
                f"{z.flat[int(np.argmax(np.abs(z)))]:+.1f}",
            ]
        )
    return [
        f"{judged} judged values of each quantity a cell. Were the intervals right and the values "
        f"independent, {nominal:.0%} of the cells would have a coverage of {BAND[0]:.0%} to "
        f"{BAND[1]:.0%} in one quantity.",
        "",
        *table(
            ["quantity", "worst cell", "least", "cells in band", "mean z", "rms z", "worst z"],
            lines,
            texts=2,
        ),
    ]


def _pivot(cells: dict[str, Held]) -> list[str]:
    lines = []
    for belt in BELTS:
        for stiffness in STIFFNESSES:
            names = [
                [Cell(belt, stiffness, peak, noise).name for noise in NOISES] for peak in PEAKS
            ]
            if any(name in cells for pair in names for name in pair):
                shares = ["/".join(_share(cells, name) for name in pair) for pair in names]
                lines.append([belt, f"{stiffness:.1e}", *shares])
    return table(["belt", "kf [N/m2]", *(f"{peak:.0%}" for peak in PEAKS)], lines)


def _share(cells: dict[str, Held], name: str) -> str:
    return f"{cells[name].together:.0%}" if name in cells else "-"


def _worst(cells: dict[str, Held]) -> list[str]:
    names = sorted(cells, key=lambda name: cells[name].together)[:_WORST]
    return table(["cell", *COVERAGE_HEAD], [coverage_line(name, cells[name]) for name in names])


def elements_sections(rows: list[Row]) -> list[str]:
    """Return the finite element campaign's tables."""
    lines = [coverage_line("all", held(rows))]
    lines += [coverage_line(name, held(group)) for name, group in by_case(rows).items()]
    return table(["trajectory", *COVERAGE_HEAD], lines)
