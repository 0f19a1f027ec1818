"""How well each sensor fitted, from the diagnostics of a result bag.

The numbers are means of innovations squared, over those that the filter expects: 1 is right. They
are judged by the limits of all sensors together, which those of a single one exceed only below
some 25 samples a second.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from belt_ros.estimation.estimate import Consistency
from belt_ros.report.result_messages import LogTimes, result_messages
from belt_ros.report.table_scan import Batch

MOST_ROWS = 20_000  # of diagnostics, that are taken in; for longer runs less often than each second
_DIAGNOSTICS_TYPE = "diagnostic_msgs/msg/DiagnosticArray"
_OF_SENSOR = re.compile(r"fit (.+) mean \[-\]")
_MOSTLY = 0.5  # share of the time


class SensorFit(NamedTuple):
    """How well one sensor fitted, while that was known."""

    sensor: str
    median: float  # [-], NaN if it was never known, as is the next
    greatest: float
    log_ns: int  # of the greatest [ns]
    worse: float  # share of the time in which it fitted worse than stated [-]
    better: float
    time: float = math.nan  # of the greatest, in the run [s]

    @property
    def verdict(self) -> Consistency:
        """What it was most of the time."""
        if math.isnan(self.median):
            return Consistency.UNKNOWN
        if self.worse > _MOSTLY:
            return Consistency.OVERCONFIDENT
        return Consistency.UNDERCONFIDENT if self.better > _MOSTLY else Consistency.CONSISTENT


class _Row(NamedTuple):
    """What was known of one sensor at one time."""

    mean: float
    lowest: float
    highest: float
    log_ns: int


def read_fits(bag: Path) -> tuple[SensorFit, ...]:
    """Return the fit of each sensor, in the order of the diagnostics; none if they lack it.

    Raises
    ------
    ReportError
        If the bag is damaged.
    """
    found: dict[str, list[_Row]] = {}
    for log_ns, message in result_messages(bag, _DIAGNOSTICS_TYPE, MOST_ROWS):
        for sensor, row in _rows(log_ns, message):
            known = found.setdefault(sensor, [])
            if row.mean > 0.0 and row.highest > 0.0:  # zero as long as they are not known
                known.append(row)
    return tuple(_fit(sensor, rows) for sensor, rows in found.items())


def _rows(log_ns: int, message: Any) -> Iterator[tuple[str, _Row]]:
    values = {item.key: item.value for status in message.status for item in status.values}
    lowest, highest = (_number(values, f"fit {end} [-]") for end in ("lowest", "highest"))
    for key in values:
        if match := _OF_SENSOR.fullmatch(key):
            yield match[1], _Row(_number(values, key), lowest, highest, log_ns)


def _number(values: Mapping[str, str], key: str) -> float:
    """Return a finite number, 0 for what is none."""
    try:
        value = float(values.get(key, 0.0))
    except ValueError:
        return 0.0
    return value if math.isfinite(value) else 0.0


def _fit(sensor: str, rows: Sequence[_Row]) -> SensorFit:
    if not rows:
        return SensorFit(sensor, math.nan, math.nan, 0, 0.0, 0.0)
    means, lowest, highest, _ = np.array(rows).T
    worst = max(rows)
    worse, better = float(np.mean(means > highest)), float(np.mean(means < lowest))
    return SensorFit(sensor, float(np.median(means)), worst.mean, worst.log_ns, worse, better)


class FitTally:
    """Puts the worst fit of each sensor on the time of the table."""

    columns: Sequence[str] = ()

    def __init__(self, fits: Sequence[SensorFit]) -> None:
        self._fits = fits
        self._times = LogTimes([fit.log_ns for fit in fits])

    def add(self, batch: Batch) -> None:
        """Take in the next rows."""
        self._times.add(batch)

    def fits(self) -> tuple[SensorFit, ...]:
        """Return the fits with their times."""
        pairs = zip(self._fits, self._times.seconds, strict=True)
        return tuple(fit._replace(time=time) for fit, time in pairs)
