"""The page: headline, pictures and tables, in the order in which they are read."""

import datetime as dt

from belt_ros.report.alarm_section import alarm_section
from belt_ros.report.headline import Fact, facts, moment, sentences, verdict
from belt_ros.report.labels import LABELS
from belt_ros.report.markup import Html, document, join, section, table, tag
from belt_ros.report.payload import payload
from belt_ros.report.quality_section import quality_section
from belt_ros.report.rounding import duration, plain
from belt_ros.report.study import Study

_STYLES = ("uPlot.min.css", "report.css")
_SCRIPTS = (
    "uPlot.iife.min.js",
    "numbers.js",
    "results.js",
    "elements.js",
    "zoom.js",
    "axes.js",
    "time_chart.js",
    "alarm_lanes.js",
    "load_chart.js",
    "page.js",
)
_ANSWERS = (
    "slip",
    "margin",
    "capacity_torque",
    "mean_tension",
    "tight_tension",
    "slack_tension",
    "friction_stiffness",
    "friction_coefficient",
    "ratio_bias",
    "accumulated_slip",
)
_YEAR_2000 = 946_684_800.0  # [s]; stamps before count from the start of a simulation
_CHART_IDS = ("slip", "tension", "stiffness", "margin", "torque")


def render(study: Study) -> str:
    """Return the page."""
    summary = study.summary
    title = f"{summary.text('drive')}: {summary.text('bag')}"
    body = tag(
        "main",
        _head(study, title),
        _over_time(study),
        _load(study),
        alarm_section(study),
        _comparison(study),
        _estimates(study),
        quality_section(study),
        _foot(study),
    )
    return document(title, body, payload(study), _STYLES, _SCRIPTS)


def _head(study: Study, title: str) -> Html:
    boxes = join(_box(fact) for fact in facts(study))
    said = join(tag("li", sentence) for sentence in sentences(study))
    note = study.summary.text("note")
    return tag(
        "header",
        tag("p", _when(study), class_="when"),
        tag("h1", title),
        tag("p", verdict(study), class_=f"verdict {study.summary.text('worst_severity')}"),
        tag("p", note, class_="note") if note else "",
        tag("dl", boxes, class_="facts"),
        tag("ul", said),
    )


def _box(fact: Fact) -> Html:
    detail = tag("dd", fact.detail, class_="detail")
    return tag("div", tag("dt", fact.name), tag("dd", fact.value), detail)


def _when(study: Study) -> str:
    summary = study.summary
    length = duration(summary.number("duration"))
    start = summary.number("start_ns") * 1e-9
    if start < _YEAR_2000:
        return f"Belt report, {length}"
    try:
        begun = dt.datetime.fromtimestamp(start, dt.timezone.utc)
    except (OverflowError, ValueError, OSError):
        return f"Belt report, {length}"
    return f"Belt report, {length} from {begun:%Y-%m-%d %H:%M:%S} UTC"


def _over_time(study: Study) -> Html:
    modes = [("filtered", "as known at the time")]
    if study.smoothed is not None:
        modes += [("smoothed", "with hindsight"), ("both", "both")]
    buttons = join(
        tag("button", label, type="button", data_mode=mode, aria_pressed="false")
        for mode, label in modes
    )
    tools = tag(
        "div",
        tag("span", buttons, class_="modes", role="group", aria_label="which estimate is drawn")
        if len(modes) > 1
        else "",
        tag("button", "whole run", type="button", id="whole"),
        class_="tools",
    )
    hint = (
        "Bands are 95 % intervals. Drag, pinch or press + and − to zoom, double-click for the "
        "whole run; point at a curve for its numbers, which stand below it. Shaded: alarms."
    )
    decimated = (
        ""
        if study.filtered.every_row
        else (
            " The run is longer than a page can hold: each curve shows the least and the greatest "
            "value of every stretch, finer about alarms."
        )
    )
    charts = join(tag("div", id=f"chart-{name}", class_="chart") for name in _CHART_IDS)
    lanes = tag("div", id="chart-alarms", class_="chart")
    return section(
        "time", "Over time", tag("p", hint + decimated, class_="hint"), tools, charts, lanes
    )


def _load(study: Study) -> Html:
    picture = study.picture
    text = (
        "Each cell is a load and slip at which the drive ran: the stronger the longer, its colour "
        "telling when. Lines are what the model says of this belt, with 95 % bands; a belt cannot "
        "carry more than its capacity, the upright line."
    )
    if picture.beyond:
        text += (
            f" {picture.beyond:,} of {picture.moving:,} measurements lie outside of the picture "
            "(gross slip, starts and stops)."
        )
    chart = tag("div", id="chart-load", class_="chart tall")
    return section("load", "Load against slip", tag("p", text, class_="hint"), chart)


def _comparison(study: Study) -> Html:
    if study.baseline is None:
        return Html("")
    rows = []
    for pair in study.compared:
        label = LABELS[pair.name]
        verdict_ = tag("strong", pair.verdict) if pair.significant else pair.verdict
        rows.append(
            (
                f"{label.text}, {pair.note}",
                label.shown(*pair.before),
                label.shown(*pair.now),
                pair.difference,
                verdict_,
            )
        )
    other = study.baseline.summary
    name = f"{other.text('drive')}: {other.text('bag')}"
    text = (
        f"Baseline: {name}. Errors are standard deviations, and are taken as independent. "
        "“Significantly” is what chance alone does in less than one case of a hundred. The error "
        "of a slip holds how much it varied at that load."
    )
    warning = ""
    if other.group("config").raw().get("drive") != study.summary.group("config").raw().get("drive"):
        warning = tag("p", "The baseline was computed for another description of the drive.")
    headings = ("quantity", "baseline", "this run", "difference", "changed?")
    found = table("This run and the baseline", headings, rows)
    return section(
        "baseline", "Against the baseline", tag("p", text, class_="hint"), warning, found
    )


def _estimates(study: Study) -> Html:
    told = study.summary.group("smoothed", optional=True).group("best_known", optional=True)
    final = study.summary.group("final")
    rows = []
    for name in _ANSWERS:
        label, end = LABELS[name], final.quantity(name)
        best = told.best_known(name)
        shown = f"{label.shown(best.value, best.stddev)} at {moment(best.time)}" if best else ""
        low, high = (plain(bound * label.factor) for bound in (end.low, end.high))
        interval = f"{low} to {high} {label.unit}".rstrip()
        rows.append((label.text, label.shown(end.value, end.stddev), interval, shown))
    headings = ("quantity", "at the end", "95 % interval", "when known best, with hindsight")
    return section("estimates", "Estimates", table("Estimates with their errors", headings, rows))


def _foot(study: Study) -> Html:
    versions = study.summary.group("versions").texts()
    text = ", ".join(f"{name} {version}" for name, version in versions.items())
    words = "Advisory: estimates from measured speeds and torques, no safety function."
    return tag("footer", tag("p", words), tag("p", f"Computed with {text}."))
