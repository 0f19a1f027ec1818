"""A replay's summary for the terminal."""

from rich.table import Table

from belt_ros.replay.summary import Extreme, FinalQuantity, Summary

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


def summary_table(summary: Summary) -> Table:
    """Return the final estimates with their 95 % intervals."""
    table = Table(title=f"{summary.drive} at the end of {summary.bag}", title_justify="left")
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
            {"learned": "data", "at_prior": "prior only"}.get(known, ""),
        )
    return table


def summary_lines(summary: Summary) -> list[str]:
    """Return what happened on the way, a line each."""
    lines = [
        f"{summary.accepted} of {summary.messages} messages on {summary.topic} used, "
        f"{summary.duration:.3f} s"
    ]
    rejected = [f"{count} {reason}" for reason, count in summary.rejected.items() if count]
    if rejected:
        lines.append("not used: " + ", ".join(rejected).replace("_", " "))
    if summary.resets:
        lines.append(f"time jumped back: the estimator began anew {summary.resets} times")
    if summary.unobserved:
        lines.append(f"no data for {summary.unobserved:.3f} s of it")
    lines.append(f"worst margin {_extreme(summary.worst_margin)}")
    lines.append(f"greatest slip {_extreme(summary.greatest_slip)}")
    lines.append(f"greatest slip beyond creep {_extreme(summary.greatest_excess_slip)}")
    lines.append(f"phases: {_shares(summary.time_in_phase)}")
    if summary.alarms_raised:
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
