"""Tables in Markdown, and what all campaigns say alike."""

import os
import platform
from collections.abc import Sequence
from datetime import datetime, timezone
from importlib.metadata import version
from typing import Protocol

from benchmarks.estimation.judged import INTERVALS, Row
from benchmarks.estimation.statistics import Held, by_case, held

_ELEMENTS_HELD = 0.9  # of the instants of each trajectory, at least
_LABELS = {"tight_tension": "T_H", "slack_tension": "T_L", "ln_kf": "ln kf"}


def label(quantity: str) -> str:
    """Return a quantity's name in tables."""
    return _LABELS.get(quantity, quantity)


class _Measured(Protocol):
    """A row that says of which code it is."""

    @property
    def sources(self) -> str:
        """Digest of the code."""


def made_with(
    command: str,
    rows: Sequence[_Measured],
    package: str = "estimation",
    libraries: Sequence[str] = ("numpy", "numba", "filterpy"),
) -> str:
    """Return date, versions, machine class and the code that was measured."""
    packages = ", ".join(f"{name} {version(name)}" for name in libraries)
    sources = sorted({row.sources for row in rows})
    mixed = " **Rows of different code are mixed.**" if len(sources) > 1 else ""
    return (
        f"{datetime.now(timezone.utc):%Y-%m-%d}, Python {platform.python_version()}, {packages}, "
        f"{os.cpu_count()} cores of {platform.machine()}; code {', '.join(sources)}.{mixed} "
        f"`{f'python -m benchmarks.{package} {command}'.rstrip()}`"
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


def verdicts(lines: Sequence[tuple[str, str, bool]]) -> list[str]:
    """Return a table of what was to be reached, what was, and whether that is enough."""
    return table(
        ["to reach", "reached", ""],
        [[target, reached, "yes" if met else "**no**"] for target, reached, met in lines],
        texts=3,
    )


def elements_sections(rows: list[Row]) -> list[str]:
    """Return the finite element campaign's tables."""
    found = {name: held(group) for name, group in by_case(rows).items()}
    lines = [coverage_line("all", held(rows))]
    lines += [coverage_line(name, each) for name, each in found.items()]
    return [*_elements_verdicts(found), "", *table(["trajectory", *COVERAGE_HEAD], lines)]


def _elements_verdicts(found: dict[str, Held]) -> list[str]:
    lines = []
    for quantity in INTERVALS:
        least, name = min((each.coverage[quantity], name) for name, each in found.items())
        target = f"{label(quantity)} held in at least {_ELEMENTS_HELD:.0%} on every trajectory"
        below = sum(each.coverage[quantity] < _ELEMENTS_HELD for each in found.values())
        reached = f"{least:.0%} on {name}" + (f"; {below} of {len(found)} below" if below else "")
        lines.append((target, reached, below == 0))
    return verdicts(lines)
