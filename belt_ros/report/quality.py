"""How good the data were: rates, gaps, rejected messages, and how well sensors fitted."""

import heapq
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from belt_ros.estimation.estimate import Consistency
from belt_ros.report.table_scan import Batch, Floats

_LISTED_GAPS = 10
_SAMPLE = 200_000  # periods kept for their median


class Gap(NamedTuple):
    """A time without data, in s."""

    length: float
    start: float


@dataclass
class QualityTally:
    """Periods, gaps and fit, gathered while going through a table.

    Parameters
    ----------
    greatest_gap : float
        Time between rows [s] over which the drive still counts as observed.
    """

    greatest_gap: float
    columns: Sequence[str] = ("fit", "fit_mean")
    gaps: int = 0
    rows: int = 0
    longest: list[Gap] = field(default_factory=list)
    fit_seconds: dict[str, float] = field(default_factory=dict)
    worst_fit: float = 0.0  # mean innovation squared per degree of freedom
    _periods: list[Floats] = field(default_factory=list)
    _kept: int = 0

    def add(self, batch: Batch) -> None:
        """Take in the next rows."""
        self.rows += len(batch.step)
        gaps = np.flatnonzero(batch.step > self.greatest_gap)
        self.gaps += len(gaps)
        found = (Gap(float(batch.step[i]), float(batch.elapsed[i] - batch.step[i])) for i in gaps)
        self.longest = heapq.nlargest(_LISTED_GAPS, [*self.longest, *found])
        steps = np.where(batch.step > self.greatest_gap, 0.0, batch.step)
        for kind in Consistency:
            time = float(np.sum(steps[batch.columns["fit"] == kind]))
            name = kind.name.lower()
            self.fit_seconds[name] = self.fit_seconds.get(name, 0.0) + time
        self.worst_fit = max(self.worst_fit, float(np.max(batch.columns["fit_mean"])))
        if self._kept < _SAMPLE:
            self._periods.append(steps[steps > 0.0])
            self._kept += len(self._periods[-1])

    @property
    def period(self) -> float | None:
        """Median time between rows [s]."""
        periods = np.concatenate(self._periods) if self._periods else np.empty(0)
        return float(np.median(periods)) if len(periods) else None
