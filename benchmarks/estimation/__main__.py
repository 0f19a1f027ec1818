"""Judge the estimator: grid, life, finite element plants, cost, and other estimators beside it.

Runs are appended to a results file, and what it holds is not run again; --fresh begins anew.
Tables, pictures and the page of results are made from all that the file holds; --runs 0 makes just
them.
"""

import argparse
from pathlib import Path

from matplotlib.figure import Figure

from belt_ros.figures.style import save
from benchmarks.estimation import campaign, page, report, store
from benchmarks.estimation.campaign import Keyed
from benchmarks.estimation.campaigns import CAMPAIGNS, Campaign


def main() -> None:
    """Run one campaign; write its tables, its pictures and its part of the page."""
    asked = _arguments()
    chosen = next(each for each in CAMPAIGNS if each.name == asked.campaign)
    print(_run(chosen, asked))


def _run(chosen: Campaign, asked: argparse.Namespace) -> str:
    runs = chosen.runs if asked.runs is None else asked.runs
    workers = 1 if chosen.alone else asked.workers
    out: Path = asked.out
    path = out / f"estimation_{chosen.name}.csv"
    if asked.fresh:
        path.unlink(missing_ok=True)
    rows = campaign.run(chosen.jobs(runs, asked.cells), path, workers, chosen.name, chosen.form)
    rows = [row for row in rows if asked.cells in row.case]
    if not rows:
        raise SystemExit(
            f"no cell's name contains {asked.cells!r}"
            if asked.cells
            else f"{path} holds no runs; ask for some with --runs"
        )
    body = _body(chosen, rows)
    if not asked.cells:
        _write(chosen, rows, body, out)
    return body


def _body(chosen: Campaign, rows: list[Keyed]) -> str:
    made = report.made_with(chosen.name, rows)
    return "\n".join([chosen.about, "", *chosen.sections(rows), "", made]) + "\n"


def _write(chosen: Campaign, rows: list[Keyed], body: str, out: Path) -> None:
    """Write tables and pictures; those of another folder stay away from the documentation."""
    name = f"estimation_{chosen.name}.md"
    (out / name).write_text(f"# {chosen.title}\n\n{body}", encoding="utf-8")
    ours = out == store.RESULTS
    shown = ""
    for file, made in chosen.files(rows).items():
        if isinstance(made, Figure):
            save(made, (page.IMAGES if ours else out) / file)
            shown += f"![{made.get_suptitle()}](images/{file})\n\n"
        else:
            (out / file).write_text(made, encoding="utf-8")
    if ours:
        page.renew(page.PAGE, name, shown + body)


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
