"""Coverage, normalised errors and their sampling tolerance, from a campaign's rows."""

import itertools
from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.estimation.judged import INTERVALS, PARAMETERS, QUANTITIES, Row

_Floats = NDArray[np.float64]
TWO_SIDED_95 = 1.96
BAND = (0.92, 0.98)  # in which a cell's coverage should lie
LEAST = 0.88  # coverage of any cell
NEES_BAND = (0.8, 1.3)  # in which a cell's mean NEES per degree of freedom should lie
_CAMPAIGNS = 4000  # that are simulated


class Held(NamedTuple):
    """How the intervals of a set of rows hold."""

    coverage: dict[str, float]  # by quantity of `INTERVALS`
    together: float  # over all of them
    tolerance: float  # 95 % half-width of `together`; instants of one run are taken as one
    mean_score: dict[str, float]  # error over deviation, by quantity
    nees: float  # mean per degree of freedom of `PARAMETERS`; 1 is right
    median_nees: float  # 0.79 is right
    runs: int
    broken: int  # rows with an error that is no number


def scores(rows: Sequence[Row], names: Iterable[str]) -> _Floats:
    """Errors over stated deviations (rows, names)."""
    places = [QUANTITIES.index(name) for name in names]
    errors = np.array([row.errors for row in rows])[:, places]
    return np.asarray(errors / np.array([row.stddevs for row in rows])[:, places])


def held(rows: Sequence[Row]) -> Held:
    """Judge a set of rows; what is no number counts as not held.

    Where the covariance of the parameters is not known, NEES is that of independent ones.
    """
    z = scores(rows, INTERVALS)
    inside = np.abs(z) < TWO_SIDED_95
    runs = _by_run(rows, inside)
    joint = np.array([row.nees for row in rows])
    apart = np.mean(scores(rows, PARAMETERS) ** 2, axis=1)
    normalised = np.where(np.isfinite(joint), joint, apart)
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


def share_within(values: Iterable[float], band: tuple[float, float] = BAND) -> float:
    """Share of values, such as cells' coverages, that lie in a band."""
    low, high = band
    return float(np.mean([low - 1e-9 <= value <= high + 1e-9 for value in values]))


def likeness(rows: Sequence[Row], quantity: str) -> float:
    """Correlation of the normalised errors at two instants of one run, over all pairs of them."""
    z = dict(zip(map(_key, rows), scores(rows, (quantity,))[:, 0].tolist(), strict=True))
    instants = sorted({row.time for row in rows})
    pairs = []
    for case, seed in {(row.case, row.seed) for row in rows}:
        run = [z.get((case, seed, instant), np.nan) for instant in instants]
        pairs += list(itertools.permutations(run, 2))
    known = np.array(pairs).reshape(-1, 2)
    known = known[np.all(np.isfinite(known), axis=1)]
    if len(known) < 2 or np.ptp(known) == 0.0:
        return 0.0
    return float(np.clip(np.corrcoef(known.T)[0, 1], 0.0, 1.0))


def nominal_coverages(runs: int, instants: int, correlation: float) -> _Floats:
    """Coverages of simulated cells whose 95 % intervals are right.

    Normalised errors are standard normal, and alike by `correlation` within a run.

    Returns
    -------
    ndarray
        One coverage for each of some thousand cells.
    """
    random = np.random.default_rng(1)
    shared = np.sqrt(correlation)
    own = np.sqrt(1.0 - correlation)
    inside = np.zeros(_CAMPAIGNS)
    for _ in range(runs):
        common = shared * random.standard_normal((_CAMPAIGNS, 1))
        z = common + own * random.standard_normal((_CAMPAIGNS, instants))
        inside += np.sum(np.abs(z) < TWO_SIDED_95, axis=1)
    return np.asarray(inside / (runs * instants))


def _key(row: Row) -> tuple[str, int, float]:
    return row.case, row.seed, row.time


def _by_run(rows: Sequence[Row], inside: NDArray[np.bool_]) -> list[float]:
    runs: dict[tuple[str, int], list[float]] = defaultdict(list)
    for row, values in zip(rows, inside, strict=True):
        runs[row.case, row.seed].append(float(np.mean(values)))
    return [float(np.mean(values)) for values in runs.values()]
