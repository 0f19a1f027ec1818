"""Load against slip: how often a drive was where, and how much it slipped at which load."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation import Phase
from belt_ros.report.table_scan import Batch, Floats

COLUMNS, ROWS = 200, 120  # cells of the picture
LOADS = 24  # steps of the load at which slip is compared
_TORQUE, _SLIP, _SPEED = "transmitted_torque", "slip", "driver_speed"


class Window(NamedTuple):
    """What the picture shows. Torque in N m, slip as a fraction."""

    torque_low: float
    torque_high: float
    slip_low: float
    slip_high: float


class Cells(NamedTuple):
    """Cells of the picture in which the drive has been; arrays of one length."""

    column: NDArray[np.uint16]
    row: NDArray[np.uint16]
    measurements: NDArray[np.uint32]
    time: Floats  # [s] mean of them


class CloudTally:
    """Counts measurements by load and slip while the drive moves well.

    Torque counts along the rotation: positive when the driver pulls.

    Parameters
    ----------
    window : Window
    least_speed : float
        Driver's speed [rad/s] from which on it moves well.
    """

    columns: Sequence[str] = (_TORQUE, _SLIP, _SPEED)

    def __init__(self, window: Window, least_speed: float) -> None:
        self._window = window
        self._least_speed = least_speed
        self._count = np.zeros(COLUMNS * ROWS)
        self._time = np.zeros(COLUMNS * ROWS)
        self.beyond = 0  # measurements outside of the window
        self.moving = 0

    def add(self, batch: Batch) -> None:
        """Take in the next rows."""
        low, high, slip_low, slip_high = self._window
        speed = batch.columns[_SPEED]
        moving = np.abs(speed) > self._least_speed
        torque = (batch.columns[_TORQUE] * np.sign(speed))[moving]
        slip = batch.columns[_SLIP][moving]
        inside = (torque >= low) & (torque < high) & (slip >= slip_low) & (slip < slip_high)
        column = ((torque[inside] - low) / (high - low) * COLUMNS).astype(np.int64)
        row = ((slip[inside] - slip_low) / (slip_high - slip_low) * ROWS).astype(np.int64)
        cell = np.minimum(column, COLUMNS - 1) * ROWS + np.minimum(row, ROWS - 1)
        self._count += np.bincount(cell, minlength=COLUMNS * ROWS)
        times = batch.elapsed[moving][inside]
        self._time += np.bincount(cell, weights=times, minlength=COLUMNS * ROWS)
        self.moving += len(torque)
        self.beyond += int(len(torque) - np.count_nonzero(inside))

    def cells(self) -> Cells:
        """Return the cells that are not empty."""
        used = np.flatnonzero(self._count)
        return Cells(
            (used // ROWS).astype(np.uint16),
            (used % ROWS).astype(np.uint16),
            self._count[used].astype(np.uint32),
            self._time[used] / self._count[used],
        )


class SlipAtLoad(NamedTuple):
    """Slip at one load, with what it is uncertain by and how much it varied. Slip as a fraction."""

    torque: float  # [N m] middle of the step
    slip: float
    stddev: float
    share: float  # of the running time


class SlipAtLoadTally:
    """Mean slip at each step of the load while the drive runs without gross slip.

    Parameters
    ----------
    greatest_torque : float
        Of the steps [N m]; the same for runs that are to be compared.
    """

    columns: Sequence[str] = (_TORQUE, _SLIP, f"{_SLIP}_stddev", "phase")

    def __init__(self, greatest_torque: float) -> None:
        self._greatest = greatest_torque
        self._sums = np.zeros((4, LOADS))  # 1, slip, slip squared, variance

    def add(self, batch: Batch) -> None:
        """Take in the next rows."""
        columns = batch.columns
        running = columns["phase"] == Phase.RUNNING
        torque = columns[_TORQUE][running]
        step = np.floor(torque / self._greatest * LOADS)
        inside = (step >= 1) & (step < LOADS)  # the first is that of idling
        place = step[inside].astype(np.int64)
        slip = columns[_SLIP][running][inside]
        variance = columns[f"{_SLIP}_stddev"][running][inside] ** 2
        for row, weights in enumerate((np.ones(len(slip)), slip, slip**2, variance)):
            self._sums[row] += np.bincount(place, weights=weights, minlength=LOADS)

    def share(self, step: int) -> float:
        """Return the part of the running time at one step of the load."""
        total = float(np.sum(self._sums[0]))
        return float(self._sums[0, step]) / total if total else 0.0

    def at(self, step: int) -> SlipAtLoad:
        """Return slip at one step; its error holds the filter's own and the scatter about it."""
        first, second, variance = self._sums[1:, step] / max(self._sums[0, step], 1.0)
        scatter = max(float(second - first**2), 0.0)
        return SlipAtLoad(
            (step + 0.5) / LOADS * self._greatest,
            float(first),
            float(np.sqrt(scatter + variance)),
            self.share(step),
        )


def common_step(one: SlipAtLoadTally, other: SlipAtLoadTally) -> int | None:
    """Return the step of the load at which both runs spent most time, if there is one."""
    shares = [min(one.share(step), other.share(step)) for step in range(LOADS)]
    best = int(np.argmax(shares))
    return best if shares[best] > 0.0 else None
