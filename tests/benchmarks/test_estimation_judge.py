"""A fixed slice of the judge of the estimator: intervals that hold, and a judge that can count."""

import math
from itertools import islice

import numpy as np
import pytest
from scipy.stats import binom

from belt_ros.rig import measured
from benchmarks.estimation import campaign, grid, store
from benchmarks.estimation.cells import Cell, all_cells, cell_settings
from benchmarks.estimation.draws import JUDGED_AT, drawn_scenario
from benchmarks.estimation.judged import INTERVALS, QUANTITIES, Row, judge
from benchmarks.estimation.kalman import Extended, Stock
from benchmarks.estimation.particle import _STRAIGHT, Particles, motion_jacobian
from benchmarks.estimation.statistics import held, scores, share_at_nominal
from benchmarks.estimation.today import Today

SLICE = (
    Cell("paper", 8.1e7, 0.60, "fine"),
    Cell("conveyor", 1e7, 0.85, "coarse"),
    Cell("compliant", 2.8e7, 0.97, "fine"),
)
INSTANTS = len(JUDGED_AT)


def row(errors: float, stddevs: float, seed: int = 0) -> Row:
    count = len(QUANTITIES)
    return Row("own", "a cell", seed, 1.0, 10.0, "code", (errors,) * count, (stddevs,) * count)


@pytest.fixture(scope="module")
def judged() -> list[Row]:
    return [found for cell in SLICE for found in grid.run_cell(cell, 0)]


def test_intervals_of_a_fixed_slice_hold_as_often_as_true_ones_could(judged: list[Row]) -> None:
    inside = np.abs(scores(judged, INTERVALS)) < 1.96
    assert inside.size == len(SLICE) * INSTANTS * len(INTERVALS)
    # What is said at one instant is right or wrong together, so instants are what is counted.
    fewest = binom.ppf(1e-4, len(judged), 0.95)
    assert np.sum(np.mean(inside, axis=1)) >= fewest


def test_all_that_is_judged_is_a_number_with_a_deviation(judged: list[Row]) -> None:
    for found in judged:
        assert all(map(math.isfinite, found.errors))
        assert all(math.isfinite(stddev) and stddev > 0.0 for stddev in found.stddevs)


def test_a_draw_is_the_same_every_time() -> None:
    cell = SLICE[0]
    settings = cell_settings(cell)
    runs = [measured(settings, drawn_scenario(cell, settings, 5)) for _ in range(2)]
    assert list(islice(runs[0], 100)) == list(islice(runs[1], 100))


def test_load_peaks_at_the_share_of_capacity_that_the_cell_says() -> None:
    for cell in SLICE:
        settings = cell_settings(cell)
        margins = [
            truth.margin for _, truth in measured(settings, drawn_scenario(cell, settings, 1))
        ]
        assert min(margins[150:]) == pytest.approx(1.0 - cell.peak, abs=0.02)


def test_the_drawn_drive_is_not_the_one_that_the_estimator_is_told() -> None:
    cell = SLICE[0]
    settings = cell_settings(cell)
    tensions = [drawn_scenario(cell, settings, seed).profiles[2].values for seed in range(40)]
    logs = np.log([values[0] for values in tensions]) - math.log(settings.prior.tension)
    assert np.std(logs) == pytest.approx(0.3, abs=0.1)
    assert all(len(set(values)) > 50 for values in tensions)


def test_the_grid_has_every_cell_once() -> None:
    cells = all_cells()
    assert len(cells) == len({cell.name for cell in cells}) == 3 * 5 * 4 * 2


def test_coverage_counts_what_lies_inside_and_takes_no_number_for_outside() -> None:
    found = held([row(1.0, 1.0), row(-1.9, 1.0, 1), row(2.0, 1.0, 2), row(math.nan, 1.0, 3)])
    assert found.together == 0.5
    assert found.broken == 1
    assert found.runs == 4
    assert found.nees == pytest.approx((1.0 + 1.9**2 + 4.0) / 3.0)


def test_even_right_intervals_leave_many_cells_out_of_the_band_when_few_are_judged() -> None:
    assert share_at_nominal(18) == pytest.approx(float(binom.pmf(17, 18, 0.95)))
    assert share_at_nominal(2000) > 0.999


def test_rows_survive_the_file_and_what_is_there_is_not_run_again(tmp_path) -> None:
    path = tmp_path / "rows.csv"
    store.append(path, [row(0.125, 0.5)])
    assert store.load(path) == [row(0.125, 0.5)]
    known = campaign.Job("own", "a cell", 0, pytest.fail, ("must not run",))
    assert campaign.run([known], path, 1, "none") == [row(0.125, 0.5)]


@pytest.mark.parametrize("kind", [Today, Extended, Stock, "particles"])
def test_other_estimators_follow_slip(kind) -> None:
    cell = SLICE[0]
    settings = cell_settings(cell)
    maker = (lambda told: Particles(told, 50, 0)) if kind == "particles" else kind
    samples = measured(settings, drawn_scenario(cell, settings, 0))
    short = islice(samples, 380)
    (found,) = judge(maker(settings), short, JUDGED_AT[:1], "other", cell.name, 0)
    assert abs(found.errors[QUANTITIES.index("slip")]) < 1e-3


def test_the_jacobian_of_a_particle_is_that_of_the_law_of_motion() -> None:
    cell = SLICE[2]
    settings = cell_settings(cell)
    particles = Particles(settings, 20, 0)
    for measurement, _ in islice(measured(settings, drawn_scenario(cell, settings, 0)), 300):
        particles.step(measurement)
    state, covariance = particles._cloud.states[0], particles._cloud.covariances[0]
    steps = 0.1 * np.sqrt(np.diag(covariance))
    _, found = motion_jacobian(particles.model.constants, state, steps[2], steps[6], 0.01)
    rows = np.tile(state, (16, 1))
    rows[np.arange(8), _STRAIGHT] += steps
    rows[8 + np.arange(8), _STRAIGHT] -= steps
    moved = particles.model.moved(rows, 0.01)[:, :3]
    expected = ((moved[:8] - moved[8:]) / (2.0 * steps[:, None])).T
    scale = np.sqrt(np.sum((expected * steps) ** 2, axis=1, keepdims=True))
    assert np.max(np.abs(found - expected) * steps / scale) < 0.01
