"""What a bag says of its belt, on a terminal."""

from rich.console import Console
from rich.table import Table
from rich.text import Text

from belt_ros.identify.result import Identified, Interval

_SHOWN = {
    "tension": "tension",
    "friction_stiffness": "kf",
    "friction_coefficient": "mu",
    "ratio_bias": "ratio bias",
    "capacity": "capacity",
}
_CORRELATED = ("tension", "kf", "mu", "ratio bias")


def print_identified(identified: Identified, console: Console | None = None) -> None:
    """Print intervals, correlation, how well the model fits, and what the data do not say."""
    console = console or Console(highlight=False)
    goodness = identified.goodness
    console.print(
        f"{goodness.loads} steady loads, up to {identified.greatest_torque:.4g} N m; sum of "
        f"squares {goodness.squares:.3g} (about {goodness.loads} is expected, chance of more "
        f"{goodness.probability:.2g})",
        markup=False,
        soft_wrap=True,
    )
    table = Table(title=Text(f"{identified.drive} by {identified.bag}"), title_justify="left")
    for heading in ("quantity", "value", "95 % interval", "prior", "unit", "known from"):
        table.add_column(heading, justify="left" if heading == "quantity" else "right")
    for name, label in _SHOWN.items():
        table.add_row(label, *_cells(getattr(identified, name)))
    console.print(table)
    strong = [
        f"{_CORRELATED[row]} and {_CORRELATED[column]} {identified.correlation[row, column]:+.2f}"
        for row in range(4)
        for column in range(row)
    ]
    console.print(f"correlation: {', '.join(strong)}", markup=False, soft_wrap=True)
    for warning in identified.warnings:
        console.print(warning, style="yellow", markup=False, soft_wrap=True)


def _cells(interval: Interval) -> tuple[str, ...]:
    return (
        f"{interval.value:.4g}",
        f"{interval.low:.4g} to {interval.high:.4g}",
        f"{interval.prior_low:.4g} to {interval.prior_high:.4g}",
        interval.unit,
        "data" if interval.told else "prior only",
    )
