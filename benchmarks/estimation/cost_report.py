"""The cost campaign as tables."""

from collections.abc import Sequence
from statistics import median

from benchmarks.estimation.cost import LIMITS, METHODS, SETTLED, STEP, Cost
from benchmarks.estimation.report import table, verdicts


def cost_sections(rows: list[Cost]) -> list[str]:
    """Return the cost campaign's tables."""
    lines = []
    members = {row.case: row.members for row in rows if row.members >= 0}
    for method, case in dict.fromkeys((row.method, row.case) for row in rows):
        group = [row for row in rows if (row.method, row.case) == (method, case)]
        lines.append(
            [
                case,
                method,
                str(members.get(case, "-")),
                f"{median(row.own for row in group):.0f}",
                f"{median(row.mean for row in group):.0f}",
                f"{median(row.stock for row in group):.0f}",
                f"{_ratio(group):.2f}",
                f"{min(row.own / row.stock for row in group):.2f} to "
                f"{max(row.own / row.stock for row in group):.2f}",
            ]
        )
    head = [
        *("drive", "what", "members", "median [us]", "mean [us]", "filterpy [us]"),
        *("ratio", "of repeats"),
    ]
    return [*_verdicts(rows), "", *table(head, lines, texts=2)]


def _verdicts(rows: list[Cost]) -> list[str]:
    lines = []
    for part, limit in LIMITS.items():
        for method in METHODS:
            found = [row for row in rows if row.method == method and row.case.endswith(part)]
            for what, ratio in (("median", _ratio), ("mean", _mean_ratio)):
                if found and (ratio is _ratio or (part, method) == (SETTLED, STEP)):
                    worst = max(ratio(group) for group in _by_case(found))
                    target = f"{part}, {method}, {what}: at most {limit:g} times filterpy's step"
                    lines.append((target, f"{worst:.2f} on the costliest drive", worst <= limit))
    return verdicts(lines)


def _by_case(rows: list[Cost]) -> list[list[Cost]]:
    return [[r for r in rows if r.case == case] for case in dict.fromkeys(r.case for r in rows)]


def _ratio(group: Sequence[Cost]) -> float:
    return median(row.own / row.stock for row in group)


def _mean_ratio(group: Sequence[Cost]) -> float:
    return median(row.mean / row.stock for row in group)
