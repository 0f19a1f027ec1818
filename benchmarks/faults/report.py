"""The page of the fault suite."""

import math
from collections.abc import Sequence

from benchmarks.estimation.report import made_with, table, verdicts
from benchmarks.faults import belt, sensors
from benchmarks.faults.judge import Verdict
from benchmarks.faults.margins import ALLOWED, FALSE, HELD, LEVELS, Crossing, totals

CASES = {case.name: case for case in (*belt.FAULTS, *belt.LOADS, *sensors.FAULTS)}
_LIBRARIES = ("numpy", "numba", "ros-rclpy", "ros-fastdds")
_REMARKS = {
    "tension_in_6_s": "At a load that stands still, 25 % of the tension changes slip by 7 % of its "
    "value. An error of the creep model by 3 % and of kf by 7 %, both within what is allowed for, "
    "explain as much; slip tells only as it grows on the way to gross slip. The margin's deviation "
    "does not say so.",
}
_CHECKS = ("in time", "right alarm", "cleared", "latched", "finite", "alive")


def page(rows: Sequence[Verdict], crossed: Sequence[Crossing]) -> str:
    """Return the page of all results."""
    good = sum(row.good for row in rows)
    parts = [
        "# Faults over real DDS",
        "",
        "Rig, node and recorder are processes of one machine, each run in a ROS domain of its own, "
        "in real time. Times are those of the stamps, which are the estimator's; where joint "
        "states as a whole are late, those of arrival. Latency: by how much the recorder heard of "
        "an alarm after that, at most; it grows where others want the processors. Cleared: within "
        "the off-delay and 1 s after the cause is gone. Latched: until ~/acknowledge, and then no "
        "more. Every name of lost traction counts as one alarm.",
        "",
        *verdicts([("all faults as they should be", f"{good} of {len(rows)}", good == len(rows))]),
        "",
        *_faults(rows),
        "",
        *(f"* {row.case}: {_REMARKS[row.case]}" for row in _missed(rows) if row.case in _REMARKS),
        "",
        "## What is right, and why by then",
        "",
        *_reasons(rows),
        "",
        "## Low margin and gross slip against the truth, over all runs",
        "",
        *_against_truth(crossed),
        "",
        *_by_run(crossed),
        "",
        made_with("", rows, "faults", _LIBRARIES),
    ]
    return "\n".join(parts) + "\n"


def _missed(rows: Sequence[Verdict]) -> list[Verdict]:
    return [row for row in rows if not row.good]


def _faults(rows: Sequence[Verdict]) -> list[str]:
    head = [
        "fault",
        *_CHECKS,
        "raised, after [s]",
        "cleared [s]",
        "turned away",
        "states",
        "latency [s]",
    ]
    lines = [
        [
            row.case,
            *("yes" if met else "**no**" for met in row[3:9]),
            row.raised or "nothing",
            "" if math.isnan(row.clearing) else f"{row.clearing:.2f}",
            str(row.rejected),
            f"{row.states:.1%}",
            f"{row.latency:.2f}",
        ]
        for row in rows
    ]
    return table(head, lines, texts=len(_CHECKS) + 2)


def _reasons(rows: Sequence[Verdict]) -> list[str]:
    head = ["fault", "what happens", "right", "within [s]", "because"]
    lines = []
    for case in (CASES[row.case] for row in rows):
        right = case.right
        names = ", ".join(sorted(each.name.lower() for each in right.accepted))
        within = f"{right.within:g}" if right.accepted else ""
        lines.append([case.name, case.what, names or "silence", within, right.why])
    return table(head, lines, texts=len(head))


def _against_truth(crossed: Sequence[Crossing]) -> list[str]:
    lines = []
    for level in LEVELS:
        total = totals([row for row in crossed if row.level == level.name])
        held = total.held / total.due if total.due else math.nan
        false = total.false / total.free if total.free else math.nan
        in_time = f"{total.in_time} of {total.crossings}"
        lines += [
            (
                f"{level.name}: raised within its on-delay and {ALLOWED:g} s",
                f"{in_time}, slowest {total.slowest:.2f} s",
                total.in_time == total.crossings,
            ),
            (
                f"{level.name}: held {HELD:.0%} of the time that it should be",
                f"{held:.1%} of {total.due:.0f} s",
                held >= HELD,
            ),
            (
                f"{level.name}: false less than {FALSE:.0%} of the time",
                f"{false:.2%} of {total.free:.0f} s",
                false < FALSE,
            ),
        ]
    return verdicts(lines)


def _by_run(crossed: Sequence[Crossing]) -> list[str]:
    """Return the runs in which a threshold was crossed, or an alarm false."""
    head = ["run", "level", "crossed", "in time", "slowest [s]", "due [s]", "held [s]", "false [s]"]
    lines = [
        [
            row.case,
            row.level,
            str(row.crossings),
            str(row.in_time),
            "" if math.isnan(row.slowest) else f"{row.slowest:.2f}",
            f"{row.due:.2f}",
            f"{row.held:.2f}",
            f"{row.false:.2f}",
        ]
        for row in crossed
        if row.crossings or row.false
    ]
    return table(head, lines, texts=2)
