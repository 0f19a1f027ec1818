"""A long table as curves that a page can hold: the envelope of every bucket of rows.

Short tables keep every row. About alarms, buckets are smaller, so that zooming in shows more.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.report.table_scan import Batch, Floats

SIGMAS_95 = 1.96
EVERY_ROW = 12_000  # rows up to which nothing is left out
_BUCKETS = 4_000
_FINER = 64  # times, about alarms
_WINDOW = 200  # fine buckets on either side of an alarm
_LONGEST_GAPS = 2_000  # gaps shorter than this part of the run are not seen in it
_LOG_NORMAL = {"friction_stiffness": "friction_stiffness_log_stddev"}


class Curve(NamedTuple):
    """A quantity bucket by bucket: extremes of its value, and of its 95 % interval. SI."""

    least: Floats
    greatest: Floats
    low: Floats
    high: Floats


@dataclass(frozen=True)
class Curves:
    """Curves over common times; NaN where nothing is known, and in gaps."""

    time: Floats  # [s]
    curves: dict[str, Curve]
    every_row: bool


@dataclass(frozen=True)
class Grid:
    """How rows are put into buckets.

    Parameters
    ----------
    rows : int
        Of the table.
    duration : float
        Of the run [s].
    greatest_gap : float
        Time between rows [s] over which a curve is drawn.
    moments_ns : sequence of int
        Log times [ns] about which buckets are finer.
    """

    rows: int
    duration: float
    greatest_gap: float
    moments_ns: Sequence[int] = ()

    @property
    def every_row(self) -> bool:
        """Whether every row has a bucket of its own."""
        return self.rows <= EVERY_ROW

    @property
    def least_gap(self) -> float:
        """Time between rows [s] from which on a curve is broken."""
        return max(self.greatest_gap, self.duration / _LONGEST_GAPS)

    def shares(self, log_ns: NDArray[np.int64]) -> Floats:
        """Return the part of a bucket that each row fills."""
        if self.every_row:
            return np.ones(len(log_ns))
        rows = max(self.rows // _BUCKETS, 1)
        fine = max(rows // _FINER, 1)
        shares = np.full(len(log_ns), 1.0 / rows)
        reach = round(_WINDOW * fine * self.duration / self.rows * 1e9)
        for moment in self.moments_ns:
            shares[np.abs(log_ns - moment) <= reach] = 1.0 / fine
        return shares


@dataclass
class EnvelopeTally:
    """Envelopes of quantities, gathered while going through a table.

    Parameters
    ----------
    grid : Grid
    names : sequence of str
        Quantities that have a standard deviation.
    only_moving : sequence of str
        Those that have a meaning only while the drive moves well.
    least_speed : float
        Driver's speed [rad/s] from which on it does.
    """

    grid: Grid
    names: Sequence[str]
    only_moving: Sequence[str]
    least_speed: float
    _filled: float = 0.0
    _gaps: int = 0
    _last_id: int = -1
    _parts: list[tuple[NDArray[np.int64], Floats, Floats]] = field(default_factory=list)

    columns: Sequence[str] = field(init=False)

    def __post_init__(self) -> None:
        spreads = [_LOG_NORMAL.get(name, f"{name}_stddev") for name in self.names]
        self.columns = [*self.names, *spreads, "driver_speed"]

    def add(self, batch: Batch) -> None:
        """Take in the next rows."""
        filled = self._filled + np.cumsum(self.grid.shares(batch.log_ns))
        gaps = self._gaps + np.cumsum(batch.step > self.grid.least_gap)
        # A gap ends a bucket, and leaves a number free for the break that is drawn.
        ids = np.ceil(filled - 1e-6).astype(np.int64) + 2 * gaps
        self._filled, self._gaps = float(filled[-1]), int(gaps[-1])
        starts = np.flatnonzero(np.diff(ids, prepend=ids[0] - 1))
        rows = np.stack([part for name in self.names for part in self._curve(name, batch)])
        lowest = np.fmin.reduceat(rows, starts, axis=1)
        highest = np.fmax.reduceat(rows, starts, axis=1)
        lasts = np.append(starts[1:], len(ids)) - 1
        times = np.stack([batch.elapsed[starts], batch.elapsed[lasts]])
        self._parts.append((ids[starts], times, np.stack([lowest, highest])))

    def _curve(self, name: str, batch: Batch) -> tuple[Floats, Floats, Floats]:
        value = batch.columns[name]
        if name in _LOG_NORMAL:
            factor = np.exp(SIGMAS_95 * batch.columns[_LOG_NORMAL[name]])
            low, high = value / factor, value * factor
        else:
            band = SIGMAS_95 * batch.columns[f"{name}_stddev"]
            low, high = value - band, value + band
        if name not in self.only_moving:
            return value, low, high
        moving = np.abs(batch.columns["driver_speed"]) > self.least_speed
        value, low, high = (np.where(moving, part, np.nan) for part in (value, low, high))
        return value, low, high

    def curves(self) -> Curves:
        """Return the curves of all rows so far."""
        ids = np.concatenate([part[0] for part in self._parts])
        times = np.concatenate([part[1] for part in self._parts], axis=1)
        extremes = np.concatenate([part[2] for part in self._parts], axis=2)
        # Two batches may share a bucket.
        starts = np.flatnonzero(np.diff(ids, prepend=ids[0] - 1))
        lasts = np.append(starts[1:], len(ids)) - 1
        lowest = np.fmin.reduceat(extremes[0], starts, axis=1)
        highest = np.fmax.reduceat(extremes[1], starts, axis=1)
        time = 0.5 * (times[0, starts] + times[1, lasts])
        breaks = np.flatnonzero(np.diff(ids[starts]) > 1) + 1
        between = 0.5 * (times[1, lasts[breaks - 1]] + times[0, starts[breaks]])
        time = np.insert(time, breaks, between)
        lowest = np.insert(lowest, breaks, np.nan, axis=1)
        highest = np.insert(highest, breaks, np.nan, axis=1)
        curves = {
            name: Curve(lowest[3 * i], highest[3 * i], lowest[3 * i + 1], highest[3 * i + 2])
            for i, name in enumerate(self.names)
        }
        return Curves(time, curves, self.grid.every_row)
