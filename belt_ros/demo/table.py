"""The live table: what the node says, how sure it is, and what is true where that is known."""

import math
from typing import Any

from rich.table import Table
from rich.text import Text

_PHASES = (
    "unknown",
    "standstill",
    "running",
    "reverse",
    "regenerating",
    "GROSS SLIP",
    "LOST",
)
_SEVERITIES = (("normal", "green"), ("WARNING", "yellow"), ("ALARM", "red"), ("TRIP", "bold red"))
# name, label, unit, factor to that unit, format
ROWS = (
    ("slip", "slip", "%", 100.0, ".3f"),
    ("excess_slip", "slip beyond creep", "%", 100.0, ".3f"),
    ("tight_tension", "tight tension", "N", 1.0, ".0f"),
    ("slack_tension", "slack tension", "N", 1.0, ".0f"),
    ("transmitted_torque", "torque", "N m", 1.0, ".2f"),
    ("friction_stiffness", "friction stiffness kf", "MN/m2", 1e-6, ".2f"),
    ("margin", "margin to slip", "%", 100.0, ".1f"),
)


def live_table(state: Any, truth: Any | None, alarm: Any | None, elapsed: float) -> Table:
    """Return one picture of the drive as a table."""
    table = Table(title=Text(f"{state.drive_name}  {elapsed:5.1f} s  {_PHASES[state.phase]}"))
    table.add_column("", min_width=22)
    table.add_column("estimate", justify="right", min_width=10)
    table.add_column("+/-", justify="right", min_width=8)
    if truth is not None:
        table.add_column("truth", justify="right", min_width=10)
    table.add_column("", min_width=6)
    for name, label, unit, factor, form in ROWS:
        cells = [
            label,
            format(getattr(state, name) * factor, form),
            format(getattr(state, f"{name}_stddev") * factor, form),
        ]
        if truth is not None:
            cells.append(format(getattr(truth, name) * factor, form))
        table.add_row(*cells, unit)
    table.caption = alarm_text(alarm)
    return table


def alarm_text(alarm: Any | None) -> Text:
    """Return the alarm as one line, coloured by its severity."""
    if alarm is None:
        return Text("alarm: none yet")
    word, style = _SEVERITIES[alarm.severity]
    return Text(f"alarm: {word}  {alarm.message if alarm.active else ''}", style=style)


def plain_line(state: Any, alarm: Any | None, elapsed: float) -> str:
    """Return the same in one line, for output that is no terminal."""
    word = "none" if alarm is None else _SEVERITIES[alarm.severity][0]
    return (
        f"{elapsed:5.1f} s  {_PHASES[state.phase]:<13}"
        f"slip {state.slip:8.3%} +/- {state.slip_stddev:.3%}  "
        f"tensions {state.tight_tension:4.0f} / {state.slack_tension:4.0f} "
        f"+/- {state.tight_tension_stddev:3.0f} N  "
        f"kf {state.friction_stiffness:.2e} (x/ {factor(state):.2f})  "
        f"margin {state.margin:4.0%} +/- {state.margin_stddev:.0%}  alarm {word}"
    )


def factor(state: Any) -> float:
    """Return the factor by which kf may be off, one standard deviation."""
    return math.exp(min(state.friction_stiffness_log_stddev, 20.0))
