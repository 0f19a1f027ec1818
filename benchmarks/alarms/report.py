"""Tables of the campaign, as Markdown."""

import math
from collections.abc import Sequence

import numpy as np

from belt_ros.estimation import Condition
from benchmarks.alarms.cases import MEASURED, Case, case_of
from benchmarks.alarms.hours import CONDITIONS, GREATEST, Hours, truly_lost
from benchmarks.alarms.ramps import OF_THE_BELT, Ramp
from benchmarks.alarms.raw_slip import THRESHOLDS
from benchmarks.estimation.cells import BELTS
from benchmarks.estimation.report import verdicts

_STIFF = 0.5  # mu/(R lambda) below which a contact counts as stiff
_NO_CLAIM = "stiff, tension not known better than before (no claim)"
_HOURS = 24.0
_WARNED = 0.99  # of the ramps, at least
_LOST = (Condition.TRACTION_LOST, Condition.TENSION_LOST, Condition.FRICTION_LOST)


def softness(case: Case) -> float:
    """Return mu/(R lambda), the angle over which contact yields elastically, of the prior."""
    belt = BELTS[case.belt]
    return belt.friction / (belt.radius * math.sqrt(case.stiffness / belt.axial_stiffness))


def verdict_lines(ramps: Sequence[Ramp], hours: Sequence[Hours]) -> list[str]:
    """Return the table of what was to be reached."""
    lines = []
    for name, group in _groups(_slipped(ramps)).items():
        if group and name != _NO_CLAIM:
            warned = sum(row.warned < row.slipped for row in group)
            target = f"ramps of 2 s and longer warned of in {_WARNED:.0%}: {name}"
            lines.append((target, _share(group), warned >= _WARNED * len(group)))
    if hours:
        length = sum(row.duration for row in hours) / 3600.0
        false = sum(sum(false_alarms(row).values()) for row in hours)
        runs = sum(any(false_alarms(row).values()) for row in hours)
        reached = f"{false} in {length:.1f} h, {runs} of {len(hours)} runs"
        target = f"24 h of varying load up to {GREATEST:.0%} of true capacity: no false alarm"
        lines.append((target, reached, false == 0 and length >= _HOURS))
    return verdicts(lines)


def _slipped(ramps: Sequence[Ramp]) -> list[Ramp]:
    return [row for row in ramps if math.isfinite(row.slipped)]


def ramp_sections(ramps: Sequence[Ramp], hours: Sequence[Hours]) -> list[str]:
    """Return the tables of warned ramps."""
    slipped = _slipped(ramps)
    return [
        "## Warned before gross slip",
        "",
        f"{len(slipped)} ramps from 30 to 120 % of the true capacity, in 2, 4 and 8 s by turns, up "
        "to the sample at which gross slip truly begins. Warned: an alarm on margin, gross slip "
        "or traction rose on the ramp and was on then. Lead: from then to gross slip; 0 where "
        "there was no warning. Learned: share of the runs in which the estimator said so when the "
        "ramp began. Raw: speed ratio, low-passed with 0.2 s, at a threshold that raised as many "
        "false alarms under the varying load below, of the same belt and kf.",
        "",
        *_summary(slipped),
        "",
        *_by_case(slipped, hours),
        "",
    ]


def _groups(rows: Sequence[Ramp]) -> dict[str, list[Ramp]]:
    soft = [row for row in rows if softness(case_of(row.case)) >= _STIFF]
    stiff = [row for row in rows if softness(case_of(row.case)) < _STIFF]
    others = [row for row in stiff if case_of(row.case).knowledge != MEASURED]
    return {
        f"compliant and elastic contact, mu/(R lambda) >= {_STIFF:g}": soft,
        "stiff, tension measured to 5 %": [
            row for row in stiff if case_of(row.case).knowledge == MEASURED
        ],
        "stiff, tension learned from slip": [row for row in others if row.learned],
        _NO_CLAIM: [row for row in others if not row.learned],
    }


def _summary(rows: Sequence[Ramp]) -> list[str]:
    lines = [
        "| | runs | warned | of 2 s ramps | lead median [s] | lead 5 % [s] | held back |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for name, group in _groups(rows).items():
        if group:
            quick = [row for row in group if row.ramp <= 2.0]
            leads = _leads(group)
            lines.append(
                f"| {name} | {len(group)} | {_share(group)} | {_share(quick)} | "
                f"{np.median(leads):.2f} | {np.quantile(leads, 0.05):.2f} | "
                f"{sum(row.held_back for row in group)} |"
            )
    return lines


def _by_case(rows: Sequence[Ramp], hours: Sequence[Hours]) -> list[str]:
    lines = [
        "| belt | kf [N/m2] | mu/(R lambda) | tension | learned | runs | warned | lead median [s] "
        "| lead 5 % [s] | raw threshold | raw warned | earlier by, median [s] |",
        "| --- " * 12 + "|",
    ]
    for name in sorted({row.case for row in rows}, key=_order):
        case, group = case_of(name), [row for row in rows if row.case == name]
        leads = _leads(group)
        learned = sum(row.learned for row in group) / len(group)
        lines.append(
            f"| {case.belt} | {case.stiffness:.1e} | {softness(case):.2f} | {case.knowledge} | "
            f"{learned:.0%} | {len(group)} | {_share(group)} | {np.median(leads):.2f} | "
            f"{np.quantile(leads, 0.05):.2f} | {_against_raw(case, group, hours)} |"
        )
    return lines


def _order(name: str) -> tuple[str, float, str]:
    case = case_of(name)
    return case.belt, case.stiffness, case.knowledge


def _leads(rows: Sequence[Ramp]) -> list[float]:
    leads = [row.slipped - row.warned for row in rows]
    return [max(lead, 0.0) if math.isfinite(lead) else 0.0 for lead in leads]


def _share(rows: Sequence[Ramp]) -> str:
    if not rows:
        return "-"
    warned = sum(row.warned < row.slipped for row in rows)
    return f"{warned / len(rows):.1%} ({len(rows) - warned} missed)"


def _against_raw(case: Case, rows: Sequence[Ramp], hours: Sequence[Hours]) -> str:
    of_drive = [
        row
        for row in hours
        if (case_of(row.case).belt, case_of(row.case).stiffness) == (case.belt, case.stiffness)
    ]
    if not of_drive:
        return "- | - | -"
    allowed = sum(any(false_alarms(row).values()) for row in of_drive)
    greatest = sorted((row.greatest_raw_slip for row in of_drive), reverse=True)
    over = greatest[allowed] if allowed < len(greatest) else 0.0
    place = int(np.searchsorted(THRESHOLDS, over, side="right"))
    if place >= THRESHOLDS.size:
        return "none | - | -"
    raw = [row._replace(warned=row.crossed[place]) for row in rows]
    gains = np.subtract(_leads(rows), _leads(raw))
    return f"{THRESHOLDS[place]:.2%} | {_share(raw)} | {np.median(gains):.2f}"


def false_alarms(row: Hours) -> dict[Condition, int]:
    """Return what was raised although nothing was wrong.

    Lost traction is rightly raised where the belt truly carries less than was told.
    """
    right = _LOST if truly_lost(row) else ()
    counts = dict(zip(CONDITIONS, row.raised, strict=True))
    return {each: count for each, count in counts.items() if each not in right}


def hours_sections(rows: Sequence[Hours]) -> list[str]:
    """Return the table of alarms under varying load."""
    lines = [
        "## Varying load up to 60 % of the true capacity",
        "",
        "Levels of 3 to 60 % for 2 to 20 s each, at 20 Hz; all five kf by turns, tension known as "
        "by the prior. False: raised although nothing was wrong. Traction rightly: the belt drawn "
        "truly carried less than 80 % of what the estimator was told.",
        "",
        "| belt | hours | of the belt, false | of sensors, false | traction rightly | runs with "
        "any false |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for belt in BELTS:
        group = [row for row in rows if case_of(row.case).belt == belt]
        if not group:
            continue
        false = [false_alarms(row) for row in group]
        of_belt = sum(
            count
            for each in false
            for condition, count in each.items()
            if condition in (*OF_THE_BELT, Condition.EXCESS_SLIP)
        )
        total = sum(sum(each.values()) for each in false)
        right = sum(sum(row.raised) for row in group) - total
        lines.append(
            f"| {belt} | {sum(row.duration for row in group) / 3600.0:.1f} | {of_belt} | "
            f"{total - of_belt} | {right} | {sum(any(each.values()) for each in false)} of "
            f"{len(group)} |"
        )
    worst = [
        f"* {row.case}, run {row.seed}: "
        + ", ".join(
            f"{count} {condition.name.lower()}"
            for condition, count in false_alarms(row).items()
            if count
        )
        for row in rows
        if any(false_alarms(row).values())
    ]
    return [*lines, "", *worst, ""]
