"""The comparison with other estimators as Markdown tables."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.estimation.cells import BELTS, PEAKS
from benchmarks.estimation.judged import QUANTITIES, Row
from benchmarks.estimation.peers import EMPTY, METHODS, OWN, PARTICLES
from benchmarks.estimation.report import label, table, verdicts
from benchmarks.estimation.statistics import TWO_SIDED_95

_Floats = NDArray[np.float64]
_COMPARED = ("slip", "tight_tension", "margin", "ln_kf")
_PLACES = [QUANTITIES.index(name) for name in _COMPARED]
_MARGIN = _COMPARED.index("margin")
_RESAMPLES = 2000
_WORSE = 1.2  # than the reference, at most
_SAME = 0.05  # by which doubling the particles may change errors


class Runs:
    """Errors and stated deviations (runs, instants, quantities) of one method, and its time."""

    def __init__(self, rows: Sequence[Row]) -> None:
        ordered = sorted(rows, key=lambda row: (row.case, row.seed, row.time))
        self.cases = list(dict.fromkeys((row.case, row.seed) for row in ordered))
        shape = (len(self.cases), -1, len(_PLACES))
        scale = np.array([[1.0, BELTS[row.case.split()[0]].tension, 1.0, 1.0] for row in ordered])
        errors = np.array([row.errors for row in ordered])[:, _PLACES] / scale
        stddevs = np.array([row.stddevs for row in ordered])[:, _PLACES] / scale
        self.errors = errors.reshape(shape)
        self.stddevs = stddevs.reshape(shape)
        self.microseconds = float(np.median([row.microseconds for row in rows]))

    def rms(self) -> _Floats:
        """Root-mean-square errors (quantities,)."""
        return np.asarray(np.sqrt(np.mean(self.errors**2, axis=(0, 1))))


def sections(rows: list[Row]) -> list[str]:
    """Return the tables of those runs that every method has."""
    methods = [method for method in METHODS if any(row.method == method for row in rows)]
    shared = set.intersection(
        *({(row.case, row.seed) for row in rows if row.method == method} for method in methods)
    )
    runs = {
        method: Runs([r for r in rows if r.method == method and (r.case, r.seed) in shared])
        for method in methods
    }
    counted = [name for name in (f"{count} particles" for count in PARTICLES) if name in runs]
    lines = [
        f"{len(shared)} runs that all methods share, three instants each. Tension is relative to "
        "the prior's. Without a number: the method says nothing, or has broken down.",
        "",
        *_errors(runs),
    ]
    if len(counted) > 1:
        best, half = runs[counted[-1]], runs[counted[-2]]
        lines = [*_verdicts(runs[OWN], best, half, counted[-1]), "", *lines]
        lines += ["", *_against(runs, counted[-1]), "", *_ratios(runs, counted[-1])]
    return lines


def _verdicts(own: Runs, best: Runs, half: Runs, reference: str) -> list[str]:
    """Whether errors are near the least possible, and whether these are known."""
    everywhere = np.arange(len(own.cases))
    ratios = _ratio(own, best, everywhere)
    halved = _ratio(half, best, everywhere)
    lines = []
    for quantity, ratio, by_cell in zip(_COMPARED, ratios, _cell_ratios(own, best).T, strict=True):
        lines.append(
            (
                f"{label(quantity)}: rms error at most {_WORSE:g} times that of {reference}",
                f"{ratio:.2f}; in {np.mean(by_cell <= _WORSE):.0%} of {len(by_cell)} cells, "
                f"largest {np.max(by_cell):.2f}",
                bool(ratio <= _WORSE),
            )
        )
    alike = f"{np.min(halved):.2f} to {np.max(halved):.2f}"
    lines.append(
        (
            f"half of {reference} do no worse: rms errors within {_SAME:.0%}",
            f"{alike} times as large",
            bool(np.all(np.abs(halved - 1.0) <= _SAME)),
        )
    )
    return verdicts(lines)


def _cell_ratios(own: Runs, best: Runs) -> _Floats:
    """Rms error over the reference's (cells, quantities)."""
    cells = list(dict.fromkeys(case for case, _ in own.cases))
    places = [np.array([i for i, (case, _) in enumerate(own.cases) if case == c]) for c in cells]
    return np.array([_ratio(own, best, chosen) for chosen in places])


def _errors(runs: dict[str, Runs]) -> list[str]:
    """Errors, coverage and time of each method."""
    unit = runs[EMPTY].microseconds
    lines = []
    for method, found in runs.items():
        z = np.abs(found.errors / found.stddevs)
        says = np.any(np.isfinite(found.stddevs))
        coverage = np.mean(z < TWO_SIDED_95, axis=(0, 1))
        optimism = np.mean((found.errors / found.stddevs)[:, :, _MARGIN])
        broken = int(np.sum(np.any(np.isnan(found.errors[:, :, 0]), axis=1)))
        lines.append(
            [
                method,
                *(_number(value) for value in found.rms()),
                *(f"{share:.0%}" if says else "-" for share in coverage),
                f"{optimism:+.2f}" if says else "-",
                "-" if method == EMPTY else str(broken),
                f"{found.microseconds:.0f}",
                f"{found.microseconds / unit:.2f}",
            ]
        )
    names = [label(name) for name in _COMPARED]
    head = [
        "method",
        *(f"rms {name}" for name in names),
        *(f"{name} held" for name in names),
        "margin's mean z",
        "broken",
        "us a step",
        "of empty",
    ]
    return table(head, lines)


def _against(runs: dict[str, Runs], reference: str) -> list[str]:
    """How far other estimates lie from the reference's, in its deviations; their deviations."""
    best = runs[reference]
    lines = []
    for method, found in runs.items():
        if method in (reference, EMPTY):
            continue
        off = np.sqrt(np.mean(((found.errors - best.errors) / best.stddevs) ** 2, axis=(0, 1)))
        widths = np.median(found.stddevs / best.stddevs, axis=(0, 1))
        lines.append([method, *map(_number, off), *map(_number, widths)])
    names = [label(name) for name in _COMPARED]
    return [
        f"Off: rms distance from the estimate of {reference}, in its standard deviations. Width: "
        "median of the stated deviation over that one's.",
        "",
        *table(
            ["method", *(f"{n} off" for n in names), *(f"{n} width" for n in names)],
            lines,
        ),
    ]


def _ratios(runs: dict[str, Runs], reference: str) -> list[str]:
    """Rms error of the estimator over the reference's, with 95 % intervals over runs."""
    own, best = runs[OWN], runs[reference]
    lines = []
    for name, text in (("all", ""), *((f"load {peak:.0%}", f"load {peak:.0%}") for peak in PEAKS)):
        places = np.array([i for i, (case, _) in enumerate(own.cases) if text in case])
        if places.size:
            ratios = _ratio(own, best, places)
            low, high = _interval(own, best, places)
            cells = zip(ratios, low, high, strict=True)
            lines.append([name, *(f"{r:.2f} ({a:.2f} to {b:.2f})" for r, a, b in cells)])
    return [
        f"Rms error of {OWN} over that of {reference} (95 % interval, bootstrap over runs):",
        "",
        *table(["runs of", *map(label, _COMPARED)], lines),
    ]


def _ratio(own: Runs, best: Runs, places: NDArray[np.int64]) -> _Floats:
    ours, theirs = (np.mean(runs.errors[places] ** 2, axis=(0, 1)) for runs in (own, best))
    return np.asarray(np.sqrt(ours / theirs))


def _interval(own: Runs, best: Runs, places: NDArray[np.int64]) -> _Floats:
    random = np.random.default_rng(1)
    drawn = random.choice(places, (_RESAMPLES, places.size))
    return np.quantile([_ratio(own, best, chosen) for chosen in drawn], (0.025, 0.975), axis=0)


def _number(value: float) -> str:
    return f"{value:.3g}" if np.isfinite(value) else "-"
