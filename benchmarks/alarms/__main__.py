"""Judge the alarms: do they warn before the belt slips, and only then?

Runs are appended to results files, and what these hold is not run again; --fresh begins anew. The
page is made from all that they hold; --runs 0 makes just that.
"""

import argparse
from pathlib import Path

from benchmarks.alarms import hours, ramps
from benchmarks.alarms.report import hours_sections, ramp_sections, verdict_lines
from benchmarks.estimation import campaign, report, store

_RAMPS, _HOURS = 200, 32  # runs of a case, and of a belt: 3 times 32 of 900 s are 24 h


def main() -> None:
    """Run what is missing; write the page."""
    asked = _arguments()
    of_ramps, of_hours = (asked.out / f"alarm_{name}.csv" for name in ("ramps", "hours"))
    if asked.fresh:
        of_ramps.unlink(missing_ok=True)
        of_hours.unlink(missing_ok=True)
    steep = _RAMPS if asked.runs is None else asked.runs
    long = _HOURS if asked.hours is None else asked.hours
    ramp_rows = campaign.run(
        ramps.jobs(steep, asked.cases), of_ramps, asked.workers, "ramps", ramps.FORM
    )
    hour_rows = campaign.run(
        hours.jobs(long, asked.cases), of_hours, asked.workers, "hours", hours.FORM
    )
    if not ramp_rows or not hour_rows:
        raise SystemExit("there are no results yet; ask for runs")
    made_with = report.made_with(f"--runs {steep}", [*ramp_rows, *hour_rows], "alarms")
    body = [
        "# Warning before slip",
        "",
        *verdict_lines(ramp_rows, hour_rows),
        "",
        *ramp_sections(ramp_rows, hour_rows),
        *hours_sections(hour_rows),
        made_with,
    ]
    text = "\n".join(body) + "\n"
    (asked.out / "alarms.md").write_text(text, encoding="utf-8")
    print(text)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.alarms", description=__doc__)
    parser.add_argument("--runs", type=int, help="ramps of each case")
    parser.add_argument("--hours", type=int, help="runs of 15 minutes of each belt")
    parser.add_argument("--cases", default="", help="only cases whose name contains this")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--fresh", action="store_true", help="forget what was run before")
    parser.add_argument("--out", type=Path, default=store.RESULTS, help="folder of the results")
    return parser.parse_args()


if __name__ == "__main__":
    main()
