"""Judge the estimator: a grid of drives, finite element plants, and other estimators beside it.

Runs are appended to a results file, and what it holds is not run again; --fresh begins anew.
"""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from benchmarks.estimation import campaign, elements, grid, peers, peers_report, report, store
from benchmarks.estimation.campaign import Job
from benchmarks.estimation.judged import Row


class Campaign(NamedTuple):
    """What one sub-command does."""

    name: str
    title: str
    about: str
    runs: int  # of each cell, unless asked otherwise
    jobs: Callable[[int, str], list[Job]]
    sections: Callable[[list[Row]], list[str]]


CAMPAIGNS = (
    Campaign(
        "grid",
        "The estimator on a grid of kf and load",
        "Three belts, five kf, four peak loads (shares of the true capacity), two levels of noise. "
        "A run is 10 s at 100 Hz of a drive drawn from the priors (ln T 0.3, ln kf 0.7, ln mu "
        "0.05, creep error 3 %, ratio bias 2e-4) that wanders as the drift parameters say, judged "
        "at 3.7, 6.7 and 9.9 s. The estimator's model is the rig's. That the load is a share of "
        "the true capacity is what no estimator is told, so exact inference need not hold 95 % in "
        "every cell, near capacity least of all; the particles in estimation_peers.md are the "
        "measure. z: error over stated deviation; +/-: 95 %, taking all instants of a run as one.",
        6,
        grid.jobs,
        report.grid_sections,
    ),
    Campaign(
        "elements",
        "The estimator on finite element plants",
        "The belt is simulated node by node (40 elements on half a pulley) between fixed centres, "
        "6 s at 200 Hz, judged at 2.1, 3.9 and 5.9 s; a run is one draw of the priors about the "
        "truth and of the noise.",
        8,
        elements.jobs,
        report.elements_sections,
    ),
    Campaign(
        "peers",
        "The estimator beside others",
        "The same draws for all, some cells of the grid. Processor time of one core; a step "
        "includes reading quantities and deviations off the filter, but for the particles. "
        "Extended, unscented and particle filter have the estimator's state, process and rules for "
        "the load's noise; the tension is settled for them.",
        1,
        peers.jobs,
        peers_report.sections,
    ),
)


def main() -> None:
    """Run one campaign, and write its tables."""
    asked = _arguments()
    chosen = next(each for each in CAMPAIGNS if each.name == asked.campaign)
    runs = chosen.runs if asked.runs is None else asked.runs
    path: Path = asked.out / f"estimation_{chosen.name}.csv"
    if asked.fresh:
        path.unlink(missing_ok=True)
    rows = campaign.run(chosen.jobs(runs, asked.cells), path, asked.workers, chosen.name)
    rows = [row for row in rows if asked.cells in row.case]
    if not rows:
        raise SystemExit(f"no cell's name contains {asked.cells!r}")
    text = [
        f"# {chosen.title}",
        "",
        chosen.about,
        "",
        *chosen.sections(rows),
        "",
        report.made_with(chosen.name, rows),
    ]
    if not asked.cells:
        path.with_suffix(".md").write_text("\n".join(text) + "\n", encoding="utf-8")
    print("\n".join(text))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.estimation", description=__doc__)
    parser.add_argument("campaign", choices=[each.name for each in CAMPAIGNS])
    parser.add_argument("--runs", type=int, help="runs of each cell")
    parser.add_argument("--cells", default="", help="only cells whose name contains this")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--fresh", action="store_true", help="forget what was run before")
    parser.add_argument("--out", type=Path, default=store.RESULTS, help="folder of the results")
    return parser.parse_args()


if __name__ == "__main__":
    main()
