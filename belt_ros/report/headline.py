"""What happened, in the words of a maintenance engineer."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from belt_ros.replay.quantities import FinalQuantity
from belt_ros.report.labels import LABELS
from belt_ros.report.rounding import SPACE, count, duration, plain
from belt_ros.report.study import Study

_ENOUGH = 0.5  # share of the messages without which a run says nothing of itself


class Fact(NamedTuple):
    """One box of the headline."""

    name: str
    value: str
    detail: str


def moment(seconds: float) -> str:
    """Return a time in the run, as exact as its pictures are read."""
    if seconds < 1000.0:
        return f"{seconds:.2f}{SPACE}s"
    whole = math.floor(seconds)
    clock = f"{whole // 3600}:{whole % 3600 // 60:02d}:{whole % 60:02d}"
    return f"{clock}{SPACE}h"


def verdict(study: Study) -> str:
    """Return one sentence that says what matters most."""
    summary = study.summary
    phases = summary.group("time_in_phase").numbers()
    slipped, lost = phases.get("gross_slip", 0.0), phases.get("lost", 0.0)
    accepted, messages = summary.count("accepted"), summary.count("messages")
    if accepted < _ENOUGH * messages:
        return (
            f"Only {accepted:,} of {messages:,} messages could be used: look at the data quality "
            "first."
        )
    if slipped > 0.0:
        return f"The belt slipped on a pulley for {duration(slipped)}."
    if lost > 0.0:
        return (
            f"Sensors and model did not fit for {duration(lost)}: look at the data quality first."
        )
    if study.totals:
        names = " and ".join(total.condition for total in study.totals[:3])
        return f"The belt did not slip, but there were alarms: {names}."
    if summary.count("alarms_raised"):
        return "The belt did not slip, but there were alarms."
    return "The belt did not slip, and there was no alarm."


def sentences(study: Study) -> Iterator[str]:
    """Yield what there is to say, the most important first."""
    yield from _events(study)
    yield from _belt(study)
    if study.baseline is not None:
        yield _changes(study)
    yield _data(study)


def _events(study: Study) -> Iterator[str]:
    summary = study.summary
    slip = summary.extreme("greatest_slip")
    if slip is not None:
        shown = LABELS["slip"].shown(slip.value, slip.stddev)
        yield f"The greatest slip was {shown} at {moment(slip.time)}."
    for total in study.totals:
        times = {1: "once", 2: "twice"}.get(total.times, f"{total.times} times")
        first = "" if total.first is None else f"first at {moment(total.first)}, "
        yield (
            f"{total.condition.capitalize()}: raised {times}, {first}{duration(total.seconds)} in "
            f"all, at worst {'an' if total.severity == 'alarm' else 'a'} {total.severity}."
        )


def _belt(study: Study) -> Iterator[str]:
    summary = study.summary
    told = summary.group("smoothed", optional=True).group("best_known", optional=True)
    knowledge = summary.group("knowledge").texts()
    for name, key, noun in (
        ("mean_tension", "tension", "Tension"),
        ("friction_stiffness", "friction_stiffness", "Friction stiffness kf"),
    ):
        final = summary.group("final").quantity(name)
        learned = knowledge.get(key) == "learned"
        source = "learned from the data" if learned else "told by the data on one side at most"
        yield f"{noun} at the end: {_shown(name, final)} ({source})."
        best = told.best_known(name)
        if best is not None and best.stddev < 0.7 * final.stddev:
            yield f"With hindsight it was known best at {moment(best.time)}: {_shown(name, best)}."


def _shown(name: str, quantity: FinalQuantity) -> str:
    return LABELS[name].shown(quantity.value, quantity.stddev)


def _changes(study: Study) -> str:
    changed = [pair for pair in study.compared if pair.significant and pair.name != "margin"]
    if not changed:
        return "Against the baseline nothing has changed that the data can tell."
    parts = [f"{LABELS[pair.name].text} ({pair.note}) by {pair.difference}" for pair in changed]
    return f"Significantly changed since the baseline: {'; '.join(parts)}."


def _data(study: Study) -> str:
    summary, quality = study.summary, study.quality
    accepted, messages = summary.count("accepted"), summary.count("messages")
    unobserved = summary.number("unobserved")
    text = f"{accepted:,} of {messages:,} messages were used; {count(quality.gaps, 'gap')}"
    if quality.gaps:
        text += f", {duration(unobserved)} without data"
    resets = summary.count("resets")
    if resets:
        text += f"; the estimator began anew {count(resets, 'time')}"
    return text + "."


def facts(study: Study) -> tuple[Fact, ...]:
    """Return the boxes of the headline."""
    summary = study.summary
    worst = summary.extreme("worst_margin")
    margin = Fact("worst margin", "not known", "")
    if worst is not None:
        shown = LABELS["margin"].shown(worst.value, worst.stddev)
        margin = Fact("worst margin", shown, f"at {moment(worst.time)}")
    alarms = sum(total.times for total in study.totals) or summary.count("alarms_raised")
    severity = summary.text("worst_severity")
    return (
        margin,
        Fact("alarms", str(alarms) if alarms else "none", f"worst: {severity}" if alarms else ""),
        _belt_fact(study, "mean_tension", "tension"),
        _belt_fact(study, "friction_stiffness", "friction stiffness kf"),
        _data_fact(study),
    )


def _belt_fact(study: Study, name: str, text: str) -> Fact:
    """Show what is known best; a belt at rest at the end of a bag is not."""
    summary = study.summary
    best = (
        summary.group("smoothed", optional=True).group("best_known", optional=True).best_known(name)
    )
    if best is not None:
        return Fact(text, _shown(name, best), f"known best, at {moment(best.time)}")
    return Fact(text, _shown(name, summary.group("final").quantity(name)), "at the end")


def _data_fact(study: Study) -> Fact:
    summary = study.summary
    messages = summary.count("messages")
    share = summary.count("accepted") / messages if messages else 0.0
    shown = "100 %" if share == 1.0 else f"{math.floor(1000.0 * share) / 10.0:.1f} %"
    detail = duration(summary.number("duration"))
    if study.quality.period:
        detail += f" at {plain(1.0 / study.quality.period, 3)} Hz"
    return Fact("data used", shown, detail)
