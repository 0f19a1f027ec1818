"""Rows of a campaign in a CSV file, appended as they come, so that a campaign can be resumed."""

import csv
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from benchmarks.estimation.judged import QUANTITIES, Row

RESULTS = Path(__file__).resolve().parents[1] / "results"
_Row = TypeVar("_Row")


@dataclass(frozen=True)
class Format(Generic[_Row]):
    """How one kind of row stands in a file."""

    head: tuple[str, ...]
    fields: Callable[[_Row], list[str]]
    row: Callable[[list[str]], _Row]


def append(path: Path, rows: Iterable[_Row], form: Format[_Row]) -> None:
    """Append rows; begin the file if there is none."""
    new = not path.is_file()
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        if new:
            writer.writerow(form.head)
        writer.writerows(form.fields(row) for row in rows)


def load(path: Path, form: Format[_Row]) -> list[_Row]:
    """Read all rows; none where there is no file."""
    if not path.is_file():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        reader = csv.reader(file)
        if tuple(next(reader, ())) != form.head:
            raise ValueError(f"{path} has other columns than this judge writes; use --fresh")
        return [form.row(fields) for fields in reader]


def number(value: float) -> str:
    """Return a number as it stands in a file."""
    return f"{value:.4g}"


def _fields(row: Row) -> list[str]:
    about = (row.method, row.case, str(row.seed), str(row.time), f"{row.microseconds:.0f}")
    return [*about, row.sources, *map(number, (row.nees, *row.errors, *row.stddevs))]


def _row(fields: list[str]) -> Row:
    method, case, seed, time, microseconds, sources, *numbers = fields
    nees, *values = map(float, numbers)
    count = len(QUANTITIES)
    about = (method, case, int(seed), float(time), float(microseconds), sources)
    return Row(*about, tuple(values[:count]), tuple(values[count:]), nees)


ROWS = Format(
    (
        *("method", "case", "seed", "time", "microseconds", "sources", "nees"),
        *(f"{name}_error" for name in QUANTITIES),
        *(f"{name}_stddev" for name in QUANTITIES),
    ),
    _fields,
    _row,
)
