"""The grid campaign: what was to be reached, tables, one line a cell, and pictures."""

import csv
import io

import numpy as np
from matplotlib.figure import Figure

from benchmarks.estimation.cells import BELTS, NOISES, PEAKS
from benchmarks.estimation.judged import INTERVALS, Row
from benchmarks.estimation.maps import cell_maps
from benchmarks.estimation.report import COVERAGE_HEAD, coverage_line, label, table, verdicts
from benchmarks.estimation.statistics import (
    BAND,
    LEAST,
    NEES_BAND,
    Held,
    by_case,
    held,
    likeness,
    nominal_coverages,
    scores,
    share_within,
)

_WORST = 8
_ENOUGH = 0.95  # of the cells in the band of coverage
_ENOUGH_NEES = 0.90


def grid_sections(rows: list[Row]) -> list[str]:
    """Return the grid campaign's tables."""
    cells = _cells(rows)
    return [
        _counts(cells, rows),
        "",
        *_verdicts(cells),
        "",
        *_by_quantity(cells, rows),
        "",
        *_pooled(rows),
        "",
        f"The {_WORST} cells of least coverage:",
        "",
        *_worst(cells),
    ]


def near_sections(rows: list[Row]) -> list[str]:
    """Return the tables of loads that are shares of the true capacity; nothing is asked of them."""
    return [_counts(_cells(rows), rows), "", *_pooled(rows)]


def near_files(rows: list[Row]) -> dict[str, Figure | str]:
    """Return one line a cell as a file."""
    return {"estimation_near_cells.csv": _cells_file(_cells(rows))}


def grid_files(rows: list[Row]) -> dict[str, Figure | str]:
    """Return one line a cell as a file, and the pictures."""
    cells = _cells(rows)
    return {
        "estimation_grid_cells.csv": _cells_file(cells),
        "estimation_coverage.png": cell_maps(
            "Share of 95 % intervals that hold the truth [%]",
            {
                label(quantity): {name: cell.coverage[quantity] for name, cell in cells.items()}
                for quantity in INTERVALS
            },
            centre=0.95,
            limits=(0.85, 1.0),
            band=BAND,
            percent=True,
        ),
        "estimation_nees.png": cell_maps(
            "Mean normalised error squared of ln T, ln kf, ln mu, a degree of freedom (1 is right)",
            {"NEES": {name: cell.nees for name, cell in cells.items()}},
            centre=1.0,
            limits=(0.5, 2.0),
            band=NEES_BAND,
            percent=False,
            colours="RdBu_r",
        ),
    }


def _cells(rows: list[Row]) -> dict[str, Held]:
    return {name: held(group) for name, group in by_case(rows).items()}


def _counts(cells: dict[str, Held], rows: list[Row]) -> str:
    fewest = min(cell.runs for cell in cells.values())
    instants = len({row.time for row in rows})
    return f"{len(cells)} cells of at least {fewest} runs, {instants} instants each."


def _verdicts(cells: dict[str, Held]) -> list[str]:
    low, high = BAND
    lines = []
    for quantity in INTERVALS:
        coverages = [cell.coverage[quantity] for cell in cells.values()]
        share, least = share_within(coverages), min(coverages)
        lines.append(
            (
                f"{label(quantity)}: coverage {low:.0%} to {high:.0%} in {_ENOUGH:.0%} of the "
                f"cells, none under {LEAST:.0%}",
                f"{share:.0%} of the cells, least {least:.1%}",
                share >= _ENOUGH and least >= LEAST,
            )
        )
    share = share_within((cell.nees for cell in cells.values()), NEES_BAND)
    target = "mean NEES a degree of freedom {} to {} in {:.0%} of the cells"
    lines.append(
        (
            target.format(*NEES_BAND, _ENOUGH_NEES),
            f"{share:.0%} of the cells",
            share >= _ENOUGH_NEES,
        )
    )
    return verdicts(lines)


def _by_quantity(cells: dict[str, Held], rows: list[Row]) -> list[str]:
    runs = min(cell.runs for cell in cells.values())
    instants = len({row.time for row in rows})
    lines = []
    for quantity in INTERVALS:
        coverages = np.array([cell.coverage[quantity] for cell in cells.values()])
        worst = list(cells)[int(np.argmin(coverages))]
        alike = likeness(rows, quantity)
        nominal = nominal_coverages(runs, instants, alike)
        z = scores(rows, (quantity,))
        lines.append(
            [
                label(quantity),
                worst,
                f"{np.min(coverages):.1%}",
                f"{np.mean(coverages < BAND[0] - 1e-9):.0%}",
                f"{share_within(coverages):.0%}",
                f"{np.mean(coverages > BAND[1] + 1e-9):.0%}",
                f"{share_within(nominal):.0%}",
                f"{np.std(nominal):.1%}",
                f"{alike:.2f}",
                f"{np.nanmean(z):+.2f}",
                f"{np.sqrt(np.nanmean(z**2)):.2f}",
                f"{z.flat[int(np.nanargmax(np.abs(z)))]:+.1f}",
            ]
        )
    head = [
        *("quantity", "worst cell", "least", "cells under", "in band", "over"),
        *("in band if exact", "a cell's +/-", "alike", "mean z", "rms z", "worst z"),
    ]
    return [
        'The tolerance. "In band if exact" is simulated: intervals that are right, as many runs '
        "and instants a cell as here, the instants of a run as alike as they are here (the "
        'correlation of z between them, in the column "alike"). "A cell\'s +/-" is the standard '
        "deviation of a cell's coverage by chance alone.",
        "",
        *table(head, lines, texts=2),
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


def _worst(cells: dict[str, Held]) -> list[str]:
    names = sorted(cells, key=lambda name: cells[name].together)[:_WORST]
    return table(["cell", *COVERAGE_HEAD], [coverage_line(name, cells[name]) for name in names])


def _cells_file(cells: dict[str, Held]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    head = ["cell", "runs", *(f"{name}_coverage" for name in INTERVALS)]
    writer.writerow([*head, *(f"{name}_mean_z" for name in INTERVALS), "nees", "median_nees"])
    for name, cell in cells.items():
        values = [*cell.coverage.values(), *cell.mean_score.values(), cell.nees, cell.median_nees]
        writer.writerow([name, cell.runs, *(f"{value:.4g}" for value in values)])
    return text.getvalue()
