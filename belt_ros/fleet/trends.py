"""How belts change over months: lines through what each bag has told, weighted by its errors."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from belt_ros.estimation import Quantity
from belt_ros.estimation.estimate import log_spread
from belt_ros.fleet.records import Row

_SECONDS = 1e-9
_HOUR = 3600.0
MONTH = 30.4375 * 24.0 * _HOUR
"""A twelfth of a Julian year [s]."""


@dataclass(frozen=True)
class Trend:
    """A straight line through what several bags have told.

    Attributes
    ----------
    points : int
        Bags that taught anything of the quantity.
    start_ns : int
        Time of the first of them [ns].
    level, level_stddev : float
        The line at that time.
    slope, slope_stddev : float
        Its rise in a month.
    scatter : float
        Root of chi-square per degree of freedom: 1 if the points scatter as their errors say. Where
        they scatter more, the errors of the line have been enlarged by it. NaN with two points.
    """

    points: int
    start_ns: int
    level: float
    level_stddev: float
    slope: float
    slope_stddev: float
    scatter: float


@dataclass(frozen=True)
class DriveTrend:
    """What all bags of one drive say together.

    Attributes
    ----------
    drive : str
    bags, failed : int
        Bags, and those of them that gave nothing.
    hours : float
        Recorded [h].
    worst_margin : Quantity
        The worst of all bags [-].
    worst_bag : str
    alarms : int
    tension : Trend or None
        [N] and [N/month]; None if fewer than two bags have taught anything of it.
    kf : Trend or None
        Of ln kf, so that its slope is a relative change in a month.
    loss_per_1000_h : Quantity or None
        Loss of tension in 1000 h of calendar time [N].
    """

    drive: str
    bags: int
    failed: int
    hours: float
    worst_margin: Quantity
    worst_bag: str
    alarms: int
    tension: Trend | None
    kf: Trend | None
    loss_per_1000_h: Quantity | None


class _Point(NamedTuple):
    time_ns: int
    value: float
    stddev: float


def trends(rows: Iterable[Row]) -> tuple[DriveTrend, ...]:
    """Return what all bags of each drive say together, the drive of the worst margin first."""
    by_drive: dict[str, list[Row]] = {}
    for row in rows:
        by_drive.setdefault(row.drive, []).append(row)
    found = [_drive_trend(drive, its) for drive, its in by_drive.items()]
    return tuple(sorted(found, key=_urgency))


def _urgency(trend: DriveTrend) -> tuple[float, str]:
    margin = trend.worst_margin.value
    return (math.inf if math.isnan(margin) else margin), trend.drive


def _drive_trend(drive: str, rows: Sequence[Row]) -> DriveTrend:
    good = [row for row in rows if not row.error]
    judged = [row for row in good if math.isfinite(row.worst_margin)]
    worst = min(judged, key=lambda row: row.worst_margin, default=None)
    tension = fitted(_points(good, _tension))
    unknown = Quantity(math.nan, math.nan)
    return DriveTrend(
        drive=drive,
        bags=len(rows),
        failed=len(rows) - len(good),
        hours=sum(row.hours for row in good),
        worst_margin=Quantity(worst.worst_margin, worst.worst_margin_stddev) if worst else unknown,
        worst_bag=worst.bag if worst else "",
        alarms=sum(row.alarms for row in good),
        tension=tension,
        kf=fitted(_points(good, _log_kf)),
        loss_per_1000_h=None if tension is None else _loss(tension),
    )


def _tension(row: Row) -> Quantity | None:
    return Quantity(row.tension, row.tension_stddev) if row.tension_learned else None


def _log_kf(row: Row) -> Quantity | None:
    if not row.kf_learned:
        return None
    return Quantity(math.log(row.kf), log_spread(Quantity(row.kf, row.kf_stddev)))


def _points(rows: Iterable[Row], read: Callable[[Row], Quantity | None]) -> list[_Point]:
    """Return what has been learned; at its prior, every bag would say the same thing again."""
    points = []
    for row in rows:
        quantity = read(row)
        if quantity is not None and quantity.stddev > 0.0 and math.isfinite(quantity.value):
            points.append(_Point(row.start_ns, *quantity))
    return points


def fitted(points: Sequence[_Point]) -> Trend | None:
    """Return the line of least weighted squares; None without two points at different times.

    Errors of the line are those that the points' own imply, times the root of chi-square per degree
    of freedom where that is above 1 (Particle Data Group, 10.1103/PhysRevD.110.030001, section
    5.2.2).
    """
    if len({point.time_ns for point in points}) < 2:
        return None
    start_ns = min(point.time_ns for point in points)
    months = np.array([(point.time_ns - start_ns) * _SECONDS / MONTH for point in points])
    values = np.array([point.value for point in points])
    weights = np.array([point.stddev for point in points]) ** -2.0
    total = weights.sum()
    centre = weights @ months / total
    spread = weights @ (months - centre) ** 2
    mean = weights @ values / total
    slope = weights @ ((months - centre) * values) / spread
    residuals = values - mean - slope * (months - centre)
    freedom = len(points) - 2
    scatter = math.sqrt(float(weights @ residuals**2) / freedom) if freedom else math.nan
    enlarged = max(scatter, 1.0) if freedom else 1.0
    return Trend(
        points=len(points),
        start_ns=start_ns,
        level=float(mean - slope * centre),
        level_stddev=enlarged * math.sqrt(1.0 / total + centre**2 / spread),
        slope=float(slope),
        slope_stddev=enlarged / math.sqrt(spread),
        scatter=scatter,
    )


def _loss(tension: Trend) -> Quantity:
    per_1000_hours = 1000.0 * _HOUR / MONTH
    return Quantity(-tension.slope * per_1000_hours, tension.slope_stddev * per_1000_hours)
