"""A small picture of a quantity over months: points with their errors, and the line through them.

Plain SVG with titles that show on hover, so that the page needs no script.
"""

import datetime as dt
import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from belt_ros.report.markup import Html, tag

_WIDTH, _HEIGHT = 640.0, 220.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 80.0, 10.0, 10.0, 24.0
_TICKS = 4
_SIGMAS = 1.96
_SECOND_NS = 1_000_000_000


class Point(NamedTuple):
    """One value at a time [ns], its 95 % interval, and what it is of."""

    time_ns: int
    value: float
    low: float
    high: float
    label: str
    learned: bool


class Line(NamedTuple):
    """A curve by its values at times [ns]."""

    times_ns: tuple[int, ...]
    values: tuple[float, ...]


def day(time_ns: int) -> str:
    """Return a stamp as a date (UTC)."""
    try:
        date = dt.datetime.fromtimestamp(time_ns / _SECOND_NS, tz=dt.timezone.utc)
    except (OverflowError, OSError, ValueError):
        return f"{time_ns} ns"
    return f"{date:%Y-%m-%d}"


def chart(title: str, points: Sequence[Point], line: Line | None) -> Html:
    """Return the picture; points at their prior are hollow, and do not set the scale."""
    shown = [point for point in points if math.isfinite(point.value)]
    if not shown:
        return tag("p", f"{title}: nothing known", class_="hint")
    across, up = _scales(shown, line)
    parts = [*_axes(across, up, shown)]
    if line is not None:
        path = " ".join(
            f"{across(t):.1f},{up(v):.1f}" for t, v in zip(line.times_ns, line.values, strict=True)
        )
        parts.append(
            tag("polyline", points=path, fill="none", stroke="currentColor", stroke_dasharray="5 4")
        )
    parts += [_mark(point, across, up) for point in shown]
    box = f"0 0 {_WIDTH:g} {_HEIGHT:g}"
    picture = tag(
        "svg", *parts, viewBox=box, width="100%", role="img", aria_label=title, font_size="12"
    )
    return tag("div", tag("h3", title), picture, class_="chart")


_Scale = Callable[[float], float]


def _scales(points: Sequence[Point], line: Line | None) -> tuple[_Scale, _Scale]:
    times = [point.time_ns for point in points]
    decisive = [point for point in points if point.learned] or points
    values = [bound for point in decisive for bound in (point.low, point.high)]
    if line is not None:
        values += line.values
    return (
        _scale(min(times), max(times), _LEFT + 10.0, _WIDTH - _RIGHT - 10.0),
        _scale(min(values), max(values), _HEIGHT - _BOTTOM - 5.0, _TOP + 5.0),
    )


def _scale(low: float, high: float, at_low: float, at_high: float) -> _Scale:
    if not high > low:
        return lambda _: 0.5 * (at_low + at_high)
    return lambda value: at_low + (value - low) / (high - low) * (at_high - at_low)


def _axes(across: _Scale, up: _Scale, points: Sequence[Point]) -> Iterator[Html]:
    bottom, right = _HEIGHT - _BOTTOM, _WIDTH - _RIGHT
    outline = f"M{_LEFT},{_TOP} V{bottom} H{right}"
    yield tag("path", d=outline, fill="none", stroke="currentColor", stroke_opacity="0.4")
    decisive = [point for point in points if point.learned] or points
    low = min(point.low for point in decisive)
    high = max(point.high for point in decisive)
    for value in sorted({low + (high - low) * k / _TICKS for k in range(_TICKS + 1)}):
        place = f"{up(value) + 4.0:.1f}"
        yield tag(
            "text",
            f"{value:.3g}",
            x=f"{_LEFT - 6:g}",
            y=place,
            text_anchor="end",
            fill="currentColor",
        )
    times = sorted({min(p.time_ns for p in points), max(p.time_ns for p in points)})
    anchors = ("start", "end") if len(times) > 1 else ("middle",)
    for time_ns, anchor in zip(times, anchors, strict=True):
        yield tag(
            "text",
            day(time_ns),
            x=f"{across(time_ns):.1f}",
            y=f"{_HEIGHT - 6:g}",
            text_anchor=anchor,
            fill="currentColor",
        )


def _mark(point: Point, across: _Scale, up: _Scale) -> Html:
    x, inside = across(point.time_ns), (_TOP, _HEIGHT - _BOTTOM)
    low, high = (min(max(up(bound), inside[0]), inside[1]) for bound in (point.low, point.high))
    centre = min(max(up(point.value), inside[0]), inside[1])
    known = "" if point.learned else ", at its prior"
    told = f"{point.label}, {day(point.time_ns)}: {point.value:.4g} ({point.low:.4g} to "
    return tag(
        "g",
        tag("title", f"{told}{point.high:.4g}{known})"),
        tag("path", d=f"M{x:.1f},{low:.1f} V{high:.1f}", stroke="currentColor"),
        tag(
            "circle",
            cx=f"{x:.1f}",
            cy=f"{centre:.1f}",
            r="4",
            stroke="currentColor",
            fill="currentColor" if point.learned else "none",
        ),
        opacity="1" if point.learned else "0.35",
    )


def interval_point(
    time_ns: int, value: float, stddev: float, label: str, *, learned: bool = True
) -> Point:
    """Return a point with the interval of a normal distribution."""
    reach = _SIGMAS * stddev
    return Point(time_ns, value, value - reach, value + reach, label, learned)


def log_point(
    time_ns: int, value: float, log_stddev: float, label: str, *, learned: bool = True
) -> Point:
    """Return a point with the interval of a log-normal distribution."""
    factor = math.exp(_SIGMAS * log_stddev)
    return Point(time_ns, value, value / factor, value * factor, label, learned)
