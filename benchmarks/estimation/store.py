"""Rows of a campaign in a CSV file, appended as they come, so that a campaign can be resumed."""

import csv
from collections.abc import Iterable
from pathlib import Path

from benchmarks.estimation.judged import QUANTITIES, Row

RESULTS = Path(__file__).resolve().parents[1] / "results"
_ABOUT = ("method", "case", "seed", "time", "microseconds", "sources")
_HEAD = (
    *_ABOUT,
    *(f"{name}_error" for name in QUANTITIES),
    *(f"{name}_stddev" for name in QUANTITIES),
)


def append(path: Path, rows: Iterable[Row]) -> None:
    """Append rows; begin the file if there is none."""
    new = not path.is_file()
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        if new:
            writer.writerow(_HEAD)
        for row in rows:
            numbers = (f"{value:.4g}" for value in (*row.errors, *row.stddevs))
            about = (row.method, row.case, row.seed, row.time, f"{row.microseconds:.0f}")
            writer.writerow([*about, row.sources, *numbers])


def load(path: Path) -> list[Row]:
    """Read all rows; none where there is no file."""
    if not path.is_file():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        reader = csv.reader(file)
        if tuple(next(reader, ())) != _HEAD:
            raise ValueError(f"{path} has other columns than this judge writes; use --fresh")
        return [_row(fields) for fields in reader]


def _row(fields: list[str]) -> Row:
    method, case, seed, time, microseconds, sources, *numbers = fields
    values = tuple(float(number) for number in numbers)
    count = len(QUANTITIES)
    about = (method, case, int(seed), float(time), float(microseconds), sources)
    return Row(*about, values[:count], values[count:])
