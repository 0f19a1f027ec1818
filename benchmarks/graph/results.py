"""Results in files: rows as CSV, of which the last of each case count, and a page of tables."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from benchmarks.estimation import store
from benchmarks.estimation.report import made_with, table
from benchmarks.estimation.store import Format

_LIBRARIES = ("numpy", "numba", "ros-rclpy", "ros-fastdds")


class Row(Protocol):
    """What every row of results says of itself."""

    @property
    def case(self) -> str:
        """What was run."""

    @property
    def sources(self) -> str:
        """Digest of the code that was measured."""


class Part(NamedTuple):
    """How the rows of one sub-command are kept and shown."""

    name: str
    title: str
    about: str
    row: Any  # a NamedTuple
    verdicts: Callable[[list[Any]], list[str]]
    lines: Callable[[list[Any]], tuple[list[str], list[list[str]]]]
    texts: int = 1  # columns of the table that are text


def row_format(kind: Any) -> Format[Any]:
    """Return how a NamedTuple of texts and numbers stands in a file."""
    kinds = tuple(kind.__annotations__.values())

    def fields(row: Any) -> list[str]:
        return [store.number(value) if isinstance(value, float) else str(value) for value in row]

    def row(texts: list[str]) -> Any:
        return kind(*(convert(text) for convert, text in zip(kinds, texts, strict=True)))

    return Format(kind._fields, fields, row)


def keep(part: Part, rows: Sequence[Row], folder: Path) -> str:
    """Write rows in the place of those of the same cases; return the page, written as well."""
    path = folder / f"graph_{part.name}.csv"
    form = row_format(part.row)
    renewed = {row.case for row in rows}
    kept = [row for row in store.load(path, form) if row.case not in renewed]
    path.unlink(missing_ok=True)
    store.append(path, [*kept, *rows], form)
    text = page(part, store.load(path, form))
    path.with_suffix(".md").write_text(text, encoding="utf-8")
    return text


def page(part: Part, rows: list[Any]) -> str:
    """Return the page of one sub-command."""
    head, lines = part.lines(rows)
    parts = [f"# {part.title}", "", part.about, "", *part.verdicts(rows), ""]
    parts += [*table(head, lines, part.texts), "", made_with(part.name, rows, "graph", _LIBRARIES)]
    return "\n".join(parts) + "\n"
