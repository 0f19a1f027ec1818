"""What the smoothed rows of a bag amount to."""

import dataclasses
from dataclasses import dataclass

from belt_ros.estimation import Quantity
from belt_ros.estimation.estimate import log_spread
from belt_ros.replay.quantities import (
    LOG_NORMAL,
    BestKnown,
    Extreme,
    FinalQuantity,
    with_interval,
)
from belt_ros.replay.smoothing import SMOOTHED_FIELDS, SmoothedRow
from belt_ros.replay.tables import state_units

_SECONDS = 1e-9
_BELT = ("mean_tension", "friction_stiffness", "friction_coefficient", "ratio_bias")
_RELATIVE = "mean_tension"  # compared by its relative deviation


@dataclass(frozen=True)
class SmoothedSummary:
    """What is known of a bag with hindsight. Times in s, stamps in ns."""

    rows: int
    block: float  # between rows, at most, while there are data
    worst_margin: Extreme  # of the rows; peaks of the load between them are not in it
    initial: dict[str, FinalQuantity]
    final: dict[str, FinalQuantity]
    best_known: dict[str, BestKnown]


def _quantity(row: SmoothedRow, name: str) -> Quantity:
    return Quantity(row.fields[name], row.fields[f"{name}_stddev"])


def _quantities(row: SmoothedRow) -> dict[str, FinalQuantity]:
    units = state_units()
    return {
        name: with_interval(name, _quantity(row, name), units.get(name, ""))
        for name in SMOOTHED_FIELDS
        if f"{name}_stddev" in row.fields
    }


def _spread(name: str, quantity: Quantity) -> float:
    """How uncertain a quantity is, comparable between its own values."""
    if name in LOG_NORMAL:
        return log_spread(quantity)
    return quantity.stddev / quantity.value if name == _RELATIVE else quantity.stddev


class SmoothedTally:
    """Extremes of smoothed rows, which are added in the order of time.

    Parameters
    ----------
    block : float
        Time [s] between rows, at most.
    """

    def __init__(self, block: float) -> None:
        self._block = block
        self._rows = 0
        self._elapsed_ns = 0
        self._first: SmoothedRow | None = None
        self._last: SmoothedRow | None = None
        self._worst: Extreme | None = None
        self._best: dict[str, tuple[float, BestKnown]] = {}

    def add(self, row: SmoothedRow) -> None:
        """Take in the next row."""
        if self._first is None:
            self._first = row
        if self._last is not None:
            self._elapsed_ns += max(row.stamp_ns - self._last.stamp_ns, 0)
        self._rows += 1
        self._last = row
        time = self._elapsed_ns * _SECONDS
        margin = _quantity(row, "margin")
        if self._worst is None or margin.value < self._worst.value:
            self._worst = Extreme(*margin, row.stamp_ns, time)
        for name in _BELT:
            self._note_best(name, row, time)

    def _note_best(self, name: str, row: SmoothedRow, time: float) -> None:
        quantity = _quantity(row, name)
        spread = _spread(name, quantity)
        if name not in self._best or spread < self._best[name][0]:
            known = with_interval(name, quantity, state_units().get(name, ""))
            best = BestKnown(**dataclasses.asdict(known), stamp_ns=row.stamp_ns, time=time)
            self._best[name] = spread, best

    def summary(self) -> SmoothedSummary:
        """Return the summary. At least one row has been added by now."""
        assert self._first is not None
        assert self._last is not None
        assert self._worst is not None
        return SmoothedSummary(
            rows=self._rows,
            block=self._block,
            worst_margin=self._worst,
            initial=_quantities(self._first),
            final=_quantities(self._last),
            best_known={name: known for name, (_, known) in self._best.items()},
        )
