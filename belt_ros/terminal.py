"""What the `belt` command prints: summaries, ratings and the table of parameters."""

import math
from pathlib import Path
from textwrap import indent

from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from belt_ros.diagnostic_rows import REJECTION_ADVICE, words
from belt_ros.estimation import Rejection
from belt_ros.mechanics import DriveError
from belt_ros.mechanics.materials import BeltMaterial, SurfaceState
from belt_ros.mechanics.materials.tables import tables
from belt_ros.node_tables import ALL_PARAMETERS, WHILE_UNCONFIGURED
from belt_ros.parameter_table import Parameter
from belt_ros.rating import Rating
from belt_ros.replay.summary import Extreme, FinalQuantity, Summary
from belt_ros.settings import DriveSettings

_STRAINED = 0.15  # strain beyond that of elastic belts, which are at home at some 6 %
_PARAMETER_INDENT = 4 * " "  # of what stands under ros__parameters
_WIDEST_NAME = 24  # characters that are kept on one line
_MANY = 0.5  # share of the messages that, turned away for one reason, asks for advice
_SHOWN = (
    "slip",
    "excess_slip",
    "margin",
    "mean_tension",
    "tight_tension",
    "slack_tension",
    "friction_stiffness",
    "friction_coefficient",
)
_KNOWLEDGE = {
    "mean_tension": "tension",
    "friction_stiffness": "friction_stiffness",
    "friction_coefficient": "friction_coefficient",
}


def print_summary(summary: Summary, out: Path) -> None:
    """Print what a replay amounts to, and where its results are."""
    console = Console(highlight=False)
    if summary.note:
        console.print(summary.note, style="yellow", markup=False)
    for line in _summary_lines(summary):
        console.print(line, markup=False)
    console.print(_summary_table(summary))
    console.print(f"results in {out}", markup=False)


def _summary_table(summary: Summary) -> Table:
    table = Table(title=Text(f"{summary.drive} at the end of {summary.bag}"), title_justify="left")
    table.add_column("quantity")
    table.add_column("estimate", justify="right")
    table.add_column("95 % interval", justify="right")
    table.add_column("unit")
    table.add_column("known from")
    for name in _SHOWN:
        final = summary.final[name]
        known = summary.knowledge.get(_KNOWLEDGE.get(name, ""), "")
        table.add_row(
            name.replace("_", " "),
            _number(final.value),
            _interval(final),
            final.unit,
            {"learned": "data", "at_prior": "prior"}.get(known, ""),
        )
    return table


def _summary_lines(summary: Summary) -> list[str]:
    lines = [
        f"{summary.accepted} of {summary.messages} messages on {summary.topic} used, "
        f"{summary.duration:.3f} s"
    ]
    rejected = [f"{count} {reason}" for reason, count in summary.rejected.items() if count]
    if rejected:
        lines.append("not used: " + ", ".join(rejected).replace("_", " "))
        reason = max(Rejection, key=lambda each: summary.rejected.get(each.name.lower(), 0))
        if summary.rejected[reason.name.lower()] > _MANY * summary.messages:
            lines.append(f"{words(reason)}: {REJECTION_ADVICE[reason]}")
    if summary.resets:
        lines.append(f"time jumped back: the estimator began anew {summary.resets} times")
    if summary.unobserved:
        lines.append(f"no data for {summary.unobserved:.3f} s of it")
    lines.append(f"worst margin {_extreme(summary.worst_margin)}")
    lines.append(f"greatest slip {_extreme(summary.greatest_slip)}")
    lines.append(f"greatest slip beyond creep {_extreme(summary.greatest_excess_slip)}")
    lines.append(f"phases: {_shares(summary.time_in_phase)}")
    if summary.alarms:
        lines.append(
            f"alarms: {summary.alarms_raised} raised, worst {summary.worst_severity}; "
            f"{_shares(summary.time_in_severity)}"
        )
    else:
        lines.append("alarms: none")
    return lines


def _number(value: float) -> str:
    return f"{value:.4g}"


def _interval(final: FinalQuantity) -> str:
    return f"{_number(final.low)} to {_number(final.high)}"


def _extreme(extreme: Extreme | None) -> str:
    if extreme is None:
        return "not known"
    return f"{extreme.value:.2%} +/- {extreme.stddev:.2%} at {extreme.time:.3f} s"


def _shares(times: dict[str, float]) -> str:
    parts = [f"{name.replace('_', ' ')} {time:.3f} s" for name, time in times.items() if time]
    return ", ".join(parts) or "none"


def print_rating(settings: DriveSettings, rating: Rating) -> None:
    """Print what the mechanics says of a drive at its prior."""
    prior, console = settings.prior, Console(highlight=False)
    speed = rating.critical_speed
    fastest = f"{_number(speed)} m/s" if math.isfinite(speed) else "none, the belt has no mass"
    console.print(f"{settings.name}: the description is complete and consistent", markup=False)
    strain = prior.tension / settings.drive.belt.axial_stiffness
    if strain > _STRAINED:
        console.print(
            f"strained by {strain:.0%} at {prior.tension:g} N, which no belt bears: check "
            "prior.tension and belt.axial_stiffness",
            style="yellow",
        )
    console.print(f"critical belt speed: {fastest}")
    console.print(
        f"torque capacity at {prior.tension:g} N: {_number(rating.capacity)} N m, 95 % interval "
        f"{_number(rating.capacity_low)} to {_number(rating.capacity_high)} N m"
    )
    table = Table(title="steady state, running slowly", title_justify="left")
    for heading in ("load", "torque [N m]", "creep", "95 % of kf", "tight [N]", "slack [N]"):
        table.add_column(heading, justify="right")
    for point in rating.loads:
        table.add_row(
            f"{point.load:.0%}",
            _number(point.torque),
            f"{point.creep:.3%}",
            f"{point.creep_low:.3%} to {point.creep_high:.3%}",
            _number(point.tight_tension),
            _number(point.slack_tension),
        )
    console.print(table)


_WIDE = 120  # columns of a terminal, for a table of six
_PARAMETER_HEADINGS = ("parameter", "unit", "default", "range", "while running", "meaning")


def _default(value: object) -> str:
    if value is None:
        return "required"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float | int) else str(value)


def _parameter_row(parameter: Parameter) -> tuple[str, ...]:
    shown = _default(parameter.default)
    bounds = ", ".join(parameter.choices)
    if math.isfinite(parameter.low) and math.isfinite(parameter.high):
        bounds = f"{parameter.low:g} to {parameter.high:g}"
    changeable = "fixed" if parameter.fixed else "may change"
    if parameter.name.startswith("prior."):
        changeable = "at configure"
    elif parameter.name in WHILE_UNCONFIGURED:
        changeable = "while unconfigured"
    return parameter.name, parameter.unit, shown, bounds, changeable, parameter.meaning


def print_parameters() -> None:
    """Print the table of parameters; where the terminal is too narrow for it, a list."""
    console = Console(highlight=False)
    rows = [_parameter_row(parameter) for parameter in ALL_PARAMETERS.values()]
    if console.width < _WIDE:
        for name, unit, default, bounds, changeable, meaning in rows:
            console.print(f"{name} [{unit}]" if unit else name, style="bold", markup=False)
            told = (default, bounds, changeable)
            console.print(Padding(Text("; ".join(filter(None, told))), (0, 0, 0, 2)))
            console.print(Padding(Text(meaning), (0, 0, 0, 2)))
        return
    table = Table()
    for heading in _PARAMETER_HEADINGS:
        table.add_column(heading, overflow="fold", no_wrap=heading == "parameter")
    for row in rows:
        table.add_row(*map(Text, row))
    console.print(table)


def markdown_parameters() -> str:
    """Return the table of parameters as Markdown."""
    lines = [_markdown_row(_PARAMETER_HEADINGS), _markdown_row(("---",) * 6)]
    for parameter in ALL_PARAMETERS.values():
        name, *rest = _parameter_row(parameter)
        lines.append(_markdown_row((f"`{name}`", *rest)))
    return "\n".join(lines)


def _markdown_row(cells: tuple[str, ...]) -> str:
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def print_material_table(name: str) -> None:
    """Print one of the tables of belts, laggings and grooves, and what its marks mean."""
    (found,) = (table for table in tables() if table.name == name)
    shown = Table()
    for place, heading in enumerate(found.header):
        widest = max(len(row[place]) for row in found.rows)
        whole = place == 0 and widest <= _WIDEST_NAME
        shown.add_column(heading.replace("[", r"\["), overflow="fold", no_wrap=whole)
    for row in found.rows:
        shown.add_row(*(cell.replace("[", r"\[") for cell in row))
    console = Console(highlight=False)
    console.print(shown)
    console.print("low / typical / high; * not every source of it was seen in print")


def material_yaml(
    material: BeltMaterial, size: float, lagging: str, state: str, diameter: float | None
) -> str:
    """Return a belt's typical figures as the part of a drive's YAML that they fill.

    They are indented as they are there, under `ros__parameters`.

    Raises
    ------
    DriveError
        For an unknown lagging or state, or a size that cannot be.
    """
    try:
        surface = SurfaceState(state)
    except ValueError:
        known = ", ".join(one.value for one in SurfaceState)
        raise DriveError(f"state is {state!r}; it must be one of {known}") from None
    material.size.check(size)
    made = material.belt(size)
    lines = [
        f"# {material.title}; {size:g} {material.size.value}, on {lagging}, {surface.value}.",
        "# Typical figures: replace by the manufacturer's or by measured ones where you have them.",
        "belt:",
        f"  axial_stiffness: {made.axial_stiffness:#.4g}    # N",
        f"  mass_per_length: {made.mass_per_length:#.4g}    # kg/m",
        "prior:",
    ]
    prior = material.prior(size, lagging, surface, diameter)
    lines += [f"  {name}: {value:#.4g}" for name, value in prior._asdict().items()]
    return indent("\n".join(lines), _PARAMETER_INDENT)
