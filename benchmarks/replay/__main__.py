"""Measure how bags are replayed: `python -m benchmarks.replay [speed] [cores] [memory]`.

The rows of a case take the place of those of the same case in the results file; the page is made
of all that the file holds.
"""

import argparse
import tempfile
from pathlib import Path

from benchmarks.estimation import store
from benchmarks.estimation.store import RESULTS, Format
from benchmarks.replay.measure import Figure, cores, memory, speed
from benchmarks.replay.report import page

_ALL = ("speed", "cores", "memory")
ROWS = Format(
    Figure._fields,
    lambda row: [row.case, row.what, store.number(row.value), row.sources],
    lambda texts: Figure(texts[0], texts[1], float(texts[2]), texts[3]),
)


def keep(rows: list[Figure], folder: Path) -> str:
    """Write rows in the place of those of the same cases; return the page, written as well."""
    path = folder / "replay.csv"
    renewed = {row.case for row in rows}
    kept = [row for row in store.load(path, ROWS) if row.case not in renewed]
    path.unlink(missing_ok=True)
    store.append(path, [*kept, *rows], ROWS)
    text = page(store.load(path, ROWS))
    path.with_suffix(".md").write_text(text, encoding="utf-8")
    return text


def main() -> None:
    """Measure what is asked for, and write it."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.replay", description=__doc__)
    parser.add_argument("what", nargs="*", help=f"of {', '.join(_ALL)}; by default all")
    parser.add_argument("--count", type=int, default=20_000, help="samples in a bag")
    parser.add_argument("--fleet-count", type=int, default=60_000, help="in each bag of a fleet")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--out", type=Path, default=RESULTS, help="folder of the results")
    asked = parser.parse_args()
    what = asked.what or _ALL
    if not set(what) <= set(_ALL):
        parser.error(f"there are {', '.join(_ALL)}")
    rows: list[Figure] = []
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        if "speed" in what:
            rows += speed(place / "speed", asked.count, asked.turns)
        if "cores" in what:
            rows += cores(place / "cores", asked.fleet_count)
        if "memory" in what:
            rows += memory(place / "memory", asked.count)
    print(keep(rows, asked.out))


if __name__ == "__main__":
    main()
