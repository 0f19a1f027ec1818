"""A fixed slice of the grid: the estimator's intervals hold as often as true ones could."""

import math

import numpy as np
import pytest
from scipy.stats import binom, chi2

from benchmarks.estimation import grid
from benchmarks.estimation.cells import all_cells
from benchmarks.estimation.draws import JUDGED_AT
from benchmarks.estimation.judged import INTERVALS, PARAMETERS, QUANTITIES, Row
from benchmarks.estimation.statistics import held, scores

SLICE = all_cells()[4::9]  # every belt, kf, load and noise
SEEDS = (0, 1, 2)
RUNS = len(SLICE) * len(SEEDS)
RARE = 1e-4  # how seldom true intervals may fail


@pytest.fixture(scope="module")
def judged() -> list[Row]:
    return [row for seed in SEEDS for cell in SLICE for row in grid.run_cell(cell, seed)]


def refuted(rows: list[Row]) -> list[str]:
    """Quantities whose intervals hold too seldom to be right, and NEES where it is too great."""
    inside = np.abs(scores(rows, INTERVALS)) < 1.96
    # The instants of a run may be right or wrong together, so runs are what is counted.
    counts = np.sum(inside, axis=0) / len(JUDGED_AT)
    fewest = binom.ppf(RARE, RUNS, 0.95)
    found = [name for name, count in zip(INTERVALS, counts, strict=True) if count < fewest]
    freedom = len(PARAMETERS) * RUNS
    too_great = held(rows).nees > chi2.ppf(1.0 - RARE, freedom) / freedom
    return found + ["NEES"] * bool(too_great)


def with_deviations(row: Row, factor: float) -> Row:
    stddevs = tuple(factor * stddev for stddev in row.stddevs)
    return row._replace(stddevs=stddevs, nees=row.nees / factor**2)


def test_the_slice_meets_every_belt_stiffness_load_and_noise() -> None:
    for place in range(4):
        assert {cell[place] for cell in SLICE} == {cell[place] for cell in all_cells()}


def test_intervals_hold_as_often_as_true_ones_could(judged: list[Row]) -> None:
    assert len(judged) == RUNS * len(JUDGED_AT)
    assert refuted(judged) == []


@pytest.mark.parametrize(
    ("name", "seed"),
    [("compliant kf 8.1e+07 load 85% fine", 6), ("conveyor kf 2.8e+07 load 85% fine", 3)],
)
def test_a_belt_that_is_loaded_fast_is_not_locked_at_its_verge(name: str, seed: int) -> None:
    (cell,) = (cell for cell in all_cells() if cell.name == name)
    rows = grid.run_cell(cell, seed, of_true_capacity=True)
    assert np.max(np.abs(scores(rows, ("tight_tension", "margin")))) < 4.0


def test_intervals_a_third_as_wide_would_not_pass(judged: list[Row]) -> None:
    narrow = [with_deviations(row, 1.0 / 3.0) for row in judged]
    found = refuted(narrow)
    assert {"tight_tension", "margin", "NEES"} <= set(found)
    assert len(found) >= 4


def test_all_that_is_judged_is_a_number_with_a_deviation(judged: list[Row]) -> None:
    assert all(row.nees >= 0.0 for row in judged)
    for row in judged:
        assert all(map(math.isfinite, row.errors))
        assert all(math.isfinite(stddev) and stddev > 0.0 for stddev in row.stddevs)


def test_errors_squared_of_parameters_agree_with_their_own_deviations(judged: list[Row]) -> None:
    # Whole covariance and marginals weigh errors differently, but both mean 1 where they are right.
    apart = np.mean(scores(judged, PARAMETERS) ** 2)
    assert np.mean([row.nees for row in judged]) == pytest.approx(apart, rel=0.5)
    assert len(QUANTITIES) == len(judged[0].errors)
