"""One HTML page over all bags: drives ranked by worst margin, their trends, every bag."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from belt_ros.appearing import appearing
from belt_ros.estimation import Quantity
from belt_ros.estimation.estimate import log_spread
from belt_ros.fleet.chart import Line, Point, chart, day, interval_point, log_point
from belt_ros.fleet.records import Row
from belt_ros.fleet.trends import MONTH, DriveTrend, Trend
from belt_ros.report.markup import Html, document, join, table, tag

PAGE_NAME = "fleet.html"
_SIGMAS = 1.96
_MOST_BAGS = 2000  # in the page; the table has them all
_ON_A_LINE = 33  # places at which a curve is drawn
_SECONDS = 1e-9


def write_page(folder: Path, rows: Sequence[Row], trends: Sequence[DriveTrend]) -> Path:
    """Write the page in one go; return where it is."""
    place = folder / PAGE_NAME
    with appearing(place) as part:
        part.write_text(render(rows, trends), encoding="utf-8")
    return place


def render(rows: Sequence[Row], trends: Sequence[DriveTrend]) -> str:
    """Return the page. It loads nothing and runs nothing."""
    failed = sum(trend.failed for trend in trends)
    told = f"{failed} of {len(rows)} results (one for each drive in each bag) failed"
    hours = sum(trend.hours for trend in trends)
    bags = len({row.bag for row in rows})
    title = f"{len(trends)} belt drives, {bags} bags"
    body = tag(
        "main",
        tag("h1", title),
        tag("p", f"{hours:.4g} hours recorded, {told}", class_="when"),
        _ranking(trends),
        *(_drive(trend, [row for row in rows if row.drive == trend.drive]) for trend in trends),
        _failures(rows),
        _bags(rows),
    )
    return document(title, body, "null", ["report.css"], [])


def _ranking(trends: Sequence[DriveTrend]) -> Html:
    headings = (
        "Drive", "Worst margin", "Alarms", "Tension lost in 1000 h", "kf in a month", "Hours",
        "Bags", "Without result",
    )  # fmt: skip
    rows = [
        (
            trend.drive,
            _share(trend.worst_margin),
            trend.alarms,
            _newtons(trend.loss_per_1000_h),
            _monthly(trend.kf),
            f"{trend.hours:.4g}",
            trend.bags,
            trend.failed,
        )
        for trend in trends
    ]
    return tag(
        "section",
        tag("h2", "Drives, the worst margin first"),
        tag(
            "p",
            "Intervals are 95 %. Trends are straight lines through what each bag has taught, "
            "weighted by its error; bags that taught nothing are left out. The 1000 h are calendar "
            "time.",
            class_="hint",
        ),
        table("Drives", headings, rows),
    )


def _share(quantity: Quantity) -> str:
    if not math.isfinite(quantity.value):
        return "not known"
    return f"{quantity.value:.1%} ± {_SIGMAS * quantity.stddev:.1%}"


def _newtons(loss: Quantity | None) -> str:
    if loss is None:
        return "not known"
    return f"{loss.value:.3g} ± {_SIGMAS * loss.stddev:.2g} N"


def _monthly(kf: Trend | None) -> str:
    if kf is None:
        return "not known"
    return f"{kf.slope:+.2%} ± {_SIGMAS * kf.slope_stddev:.2%}"


def _drive(trend: DriveTrend, rows: Sequence[Row]) -> Html:
    good = [row for row in rows if not row.error]
    return tag(
        "section",
        tag("h2", trend.drive),
        chart("Mean tension [N]", [*_tensions(good)], _line(trend.tension, good)),
        chart(
            "Friction stiffness kf [N/m²]", [*_stiffnesses(good)], _line(trend.kf, good, log=True)
        ),
        chart("Worst margin of each bag [-]", [*_margins(good)], None),
    )


def _name(row: Row) -> str:
    return Path(row.bag).name


def _tensions(rows: Sequence[Row]) -> Iterator[Point]:
    for row in rows:
        yield interval_point(
            row.start_ns, row.tension, row.tension_stddev, _name(row), learned=row.tension_learned
        )


def _stiffnesses(rows: Sequence[Row]) -> Iterator[Point]:
    for row in rows:
        spread = log_spread(Quantity(row.kf, row.kf_stddev))
        yield log_point(row.start_ns, row.kf, spread, _name(row), learned=row.kf_learned)


def _margins(rows: Sequence[Row]) -> Iterator[Point]:
    for row in rows:
        yield interval_point(row.start_ns, row.worst_margin, row.worst_margin_stddev, _name(row))


def _line(trend: Trend | None, rows: Sequence[Row], *, log: bool = False) -> Line | None:
    if trend is None:
        return None
    last_ns = max(row.start_ns for row in rows)
    times = np.linspace(trend.start_ns, last_ns, _ON_A_LINE)
    values = trend.level + trend.slope * (times - trend.start_ns) * _SECONDS / MONTH
    drawn = np.exp(values) if log else values
    return Line(tuple(int(time) for time in times), tuple(drawn.tolist()))


def _failures(rows: Sequence[Row]) -> Html:
    failed = [row for row in rows if row.error]
    if not failed:
        return Html("")
    told = [(_name(row), row.drive, row.error) for row in failed]
    return tag(
        "section", tag("h2", "Without a result"), table("Errors", ("Bag", "Drive", "Why"), told)
    )


def _bags(rows: Sequence[Row]) -> Html:
    good = sorted((row for row in rows if not row.error), key=lambda row: row.worst_margin)
    headings = (
        "Bag", "Drive", "Start", "Hours", "Worst margin", "Tension [N]", "kf [N/m²]", "Alarms",
        "Used", "Remark",
    )  # fmt: skip
    told = [
        (
            _name(row),
            row.drive,
            day(row.start_ns),
            f"{row.hours:.3g}",
            _share(Quantity(row.worst_margin, row.worst_margin_stddev)),
            _known(row.tension, row.tension_stddev, learned=row.tension_learned),
            _known(row.kf, row.kf_stddev, learned=row.kf_learned),
            row.alarm_names or "none",
            f"{row.accepted_share:.1%}",
            row.note,
        )
        for row in good[:_MOST_BAGS]
    ]
    left = f" The first {_MOST_BAGS}; fleet.csv has all." if len(good) > _MOST_BAGS else ""
    heading = join([tag("h2", "Bags, the worst margin first"), tag("p", left, class_="hint")])
    return tag("section", heading, table("Bags", headings, told))


def _known(value: float, stddev: float, *, learned: bool) -> str:
    return f"{value:.4g} ± {stddev:.2g}" if learned else "at its prior"
