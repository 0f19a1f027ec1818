"""Coverage, normalised errors and their sampling tolerance, from a campaign's rows."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom

from benchmarks.estimation.judged import INTERVALS, PARAMETERS, QUANTITIES, Row

_Floats = NDArray[np.float64]
TWO_SIDED_95 = 1.96
BAND = (0.92, 0.98)  # in which a cell's coverage should lie


class Held(NamedTuple):
    """How the intervals of a set of rows hold."""

    coverage: dict[str, float]  # by quantity of `INTERVALS`
    together: float  # over all of them
    tolerance: float  # 95 % half-width of `together`; instants of one run are taken as one
    mean_score: dict[str, float]  # error over deviation, by quantity
    nees: float  # mean per degree of freedom of `PARAMETERS`, from marginals; 1 is right
    median_nees: float  # 0.79 is right for three independent ones
    runs: int
    broken: int  # rows with an error that is no number


def scores(rows: Sequence[Row], names: Iterable[str]) -> _Floats:
    """Errors over stated deviations (rows, names)."""
    places = [QUANTITIES.index(name) for name in names]
    errors = np.array([row.errors for row in rows])[:, places]
    return np.asarray(errors / np.array([row.stddevs for row in rows])[:, places])


def held(rows: Sequence[Row]) -> Held:
    """Judge a set of rows; what is no number counts as not held."""
    z = scores(rows, INTERVALS)
    inside = np.abs(z) < TWO_SIDED_95
    runs = _by_run(rows, inside)
    normalised = np.mean(scores(rows, PARAMETERS) ** 2, axis=1)
    spread = float(np.std(runs, ddof=1)) if len(runs) > 1 else float("nan")
    return Held(
        dict(zip(INTERVALS, np.mean(inside, axis=0).tolist(), strict=True)),
        float(np.mean(inside)),
        TWO_SIDED_95 * spread / np.sqrt(len(runs)),
        dict(zip(INTERVALS, np.nanmean(z, axis=0).tolist(), strict=True)),
        float(np.nanmean(normalised)),
        float(np.nanmedian(normalised)),
        len(runs),
        int(np.sum(np.any(np.isnan(z), axis=1))),
    )


def by_case(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Group rows by case, in the order in which cases first come."""
    groups: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        groups[row.case].append(row)
    return dict(groups)


def share_within(coverages: Iterable[float]) -> float:
    """Share of cells' coverages that lie in `BAND`."""
    low, high = BAND
    return float(np.mean([low <= coverage <= high for coverage in coverages]))


def share_at_nominal(values: int) -> float:
    """Probability that true 95 % intervals give a coverage in `BAND` over independent values."""
    counts = np.arange(values + 1)
    within = (counts >= BAND[0] * values - 1e-9) & (counts <= BAND[1] * values + 1e-9)
    return float(np.sum(binom.pmf(counts[within], values, 0.95)))


def root_mean_square(rows: Sequence[Row], quantity: str) -> float:
    """Root-mean-square error of one quantity."""
    errors = np.array([row.errors[QUANTITIES.index(quantity)] for row in rows])
    return float(np.sqrt(np.mean(errors**2)))


def _by_run(rows: Sequence[Row], inside: NDArray[np.bool_]) -> list[float]:
    runs: dict[tuple[str, int], list[float]] = defaultdict(list)
    for row, values in zip(rows, inside, strict=True):
        runs[row.case, row.seed].append(float(np.mean(values)))
    return [float(np.mean(values)) for values in runs.values()]
