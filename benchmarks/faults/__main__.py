"""Play faults to the node over real DDS, and judge what it says of them.

The rows of a fault take the place of those of the same fault in the results files; the page is made
of all that these hold.
"""

import argparse
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from benchmarks.estimation import store
from benchmarks.faults.cases import Case
from benchmarks.faults.judge import Verdict, judged
from benchmarks.faults.margins import Crossing, crossings
from benchmarks.faults.report import CASES, page
from benchmarks.faults.run import play
from benchmarks.faults.timeline import timeline
from benchmarks.graph.program import die_together
from benchmarks.graph.results import row_format


def run(case: Case) -> tuple[Verdict, list[Crossing]]:
    """Play a fault and judge it."""
    record = play(case)
    heard = timeline(case, record)
    verdict = judged(case, record, heard)
    sys.stderr.write(f"{case.name}: {'good' if verdict.good else verdict}\n")
    return verdict, crossings(case, heard)


def keep(path: Path, rows: Sequence[Any], kind: Any) -> list[Any]:
    """Write rows in the place of those of the same cases; return all, in the page's order."""
    form = row_format(kind)
    renewed = {row.case for row in rows}
    kept = [row for row in store.load(path, form) if row.case not in renewed]
    everything = [row for row in (*kept, *rows) if row.case in CASES]
    everything.sort(key=lambda row: tuple(CASES).index(row.case))
    path.unlink(missing_ok=True)
    store.append(path, everything, form)
    return everything


def main() -> None:
    """Run what is asked for; write rows and page."""
    die_together()
    asked = _arguments()
    names = asked.faults.split(",") if asked.faults else list(CASES)
    unknown = sorted(set(names) - set(CASES))
    if unknown:
        raise SystemExit(f"there is no {', '.join(unknown)}; there are {', '.join(CASES)}")
    with ThreadPoolExecutor(asked.together) as pool:
        results = list(pool.map(run, (CASES[name] for name in names)))
    verdicts = keep(asked.out / "faults.csv", [verdict for verdict, _ in results], Verdict)
    found = [row for _, rows in results for row in rows]
    crossed = keep(asked.out / "faults_margins.csv", found, Crossing)
    text = page(verdicts, crossed)
    (asked.out / "faults.md").write_text(text, encoding="utf-8")
    print(text)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.faults", description=__doc__)
    parser.add_argument("--faults", default="", help="names, with commas between them; all if none")
    parser.add_argument("--together", type=int, default=2, help="runs at the same time")
    parser.add_argument("--out", type=Path, default=store.RESULTS, help="folder of the results")
    return parser.parse_args()


if __name__ == "__main__":
    main()
