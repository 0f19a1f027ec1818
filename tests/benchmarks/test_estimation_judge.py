"""The judge of the estimator: its draws, its counting, its files, the estimators beside it."""

import math
from itertools import islice

import numpy as np
import pytest
from scipy.stats import binom

from belt_ros.mechanics import torque_capacity
from belt_ros.rig import measured
from benchmarks.estimation import campaign, store
from benchmarks.estimation.cells import BELTS, Cell, all_cells, cell_settings
from benchmarks.estimation.draws import JUDGED_AT, RATE, drawn_scenario
from benchmarks.estimation.judged import QUANTITIES, Row, judge
from benchmarks.estimation.kalman import Extended, Stock
from benchmarks.estimation.model import SENSED
from benchmarks.estimation.particle import _STRAIGHT, Particles, _effective, motion_jacobians
from benchmarks.estimation.statistics import held, likeness, nominal_coverages, share_within
from benchmarks.estimation.today import Today

SLICE = (
    Cell("paper", 8.1e7, 0.60, "fine"),
    Cell("conveyor", 1e7, 0.85, "coarse"),
    Cell("compliant", 2.8e7, 0.97, "fine"),
)


def row(errors: float, stddevs: float, seed: int = 0) -> Row:
    count = len(QUANTITIES)
    return Row("own", "a cell", seed, 1.0, 10.0, "code", (errors,) * count, (stddevs,) * count)


def test_a_draw_is_the_same_every_time() -> None:
    cell = SLICE[0]
    settings = cell_settings(cell)
    runs = [measured(settings, drawn_scenario(cell, settings, 5)) for _ in range(2)]
    assert list(islice(runs[0], 100)) == list(islice(runs[1], 100))


def test_near_capacity_the_load_peaks_at_the_share_of_the_drives_own_that_the_cell_says() -> None:
    for cell in SLICE:
        settings = cell_settings(cell)
        scenario = drawn_scenario(cell, settings, 1, of_true_capacity=True)
        margins = [truth.margin for _, truth in measured(settings, scenario)]
        assert min(margins[round(1.1 * RATE) :]) == pytest.approx(1.0 - cell.peak, abs=0.02)


def test_the_load_peaks_first_and_at_the_cells_share_of_the_told_capacity() -> None:
    for cell in SLICE:
        settings = cell_settings(cell)
        told = torque_capacity(settings.drive, settings.prior.tension, BELTS[cell.belt].speed)
        for seed in range(5):
            levels = drawn_scenario(cell, settings, seed).profiles[1].values[2::2]
            assert levels[0] == max(levels) == pytest.approx(cell.peak * told)


def test_no_drive_of_the_grid_slips_through() -> None:
    cell = SLICE[2]  # at 97 % of the told capacity
    settings = cell_settings(cell)
    for seed in range(5):
        margins = [
            truth.margin for _, truth in measured(settings, drawn_scenario(cell, settings, seed))
        ]
        assert min(margins) > 0.0


def test_drives_that_would_slip_through_are_those_that_are_drawn_again() -> None:
    light, heavy = (Cell("paper", 8.1e7, peak, "fine") for peak in (0.30, 0.97))
    means = []
    for cell in (light, heavy):
        settings = cell_settings(cell)
        tensions = [drawn_scenario(cell, settings, k).profiles[2].values[0] for k in range(60)]
        means.append(np.mean(np.log(tensions)) - math.log(settings.prior.tension))
    assert means[0] == pytest.approx(-0.5 * math.log1p(0.3**2), abs=0.12)  # median is below mean
    assert means[1] > 0.1


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


def test_nees_is_that_of_the_whole_covariance_where_it_is_known() -> None:
    known = row(1.0, 1.0)._replace(nees=3.0)
    assert held([known, known, row(1.0, 1.0, 1)]).nees == pytest.approx((3.0 + 3.0 + 1.0) / 3.0)


def test_simulated_cells_spread_as_binomial_ones_where_instants_are_independent() -> None:
    coverages = nominal_coverages(200, 3, 0.0)
    assert np.mean(coverages) == pytest.approx(0.95, abs=1e-3)
    assert np.std(coverages) == pytest.approx(math.sqrt(0.95 * 0.05 / 600), rel=0.05)
    low, high = binom.cdf([551, 588], 600, 0.95)  # 92 to 98 %
    assert share_within(coverages) == pytest.approx(high - low, abs=0.005)


def test_simulated_cells_spread_as_binomial_ones_of_runs_where_instants_are_alike() -> None:
    coverages = nominal_coverages(200, 3, 1.0)
    assert np.std(coverages) == pytest.approx(math.sqrt(0.95 * 0.05 / 200), rel=0.05)
    low, high = binom.cdf([183, 196], 200, 0.95)
    assert share_within(coverages) == pytest.approx(high - low, abs=0.015)


def test_even_right_intervals_leave_cells_out_of_the_band_when_few_are_judged() -> None:
    one_of_eighteen = float(binom.pmf(17, 18, 0.95))
    assert one_of_eighteen < 0.4
    assert share_within(nominal_coverages(6, 3, 0.0)) == pytest.approx(one_of_eighteen, abs=0.03)


def test_likeness_is_the_correlation_within_runs() -> None:
    random = np.random.default_rng(0)
    rows = []
    for seed in range(400):
        common = random.standard_normal()
        for time in (1.0, 2.0, 3.0):
            z = math.sqrt(0.6) * common + math.sqrt(0.4) * random.standard_normal()
            rows.append(row(float(z), 1.0, seed)._replace(time=time))
    assert likeness(rows, "slip") == pytest.approx(0.6, abs=0.08)


def test_rows_survive_the_file_and_what_is_there_is_not_run_again(tmp_path) -> None:
    path = tmp_path / "rows.csv"
    kept = row(0.125, 0.5)._replace(nees=1.5)
    store.append(path, [kept], store.ROWS)
    assert store.load(path, store.ROWS) == [kept]
    known = campaign.Job("own", "a cell", 0, pytest.fail, ("must not run",))
    assert campaign.run([known], path, 1, "none", store.ROWS) == [kept]


@pytest.mark.parametrize("kind", [Today, Extended, Stock, "particles"])
def test_other_estimators_follow_slip(kind) -> None:
    cell = SLICE[0]
    settings = cell_settings(cell)
    maker = (lambda told: Particles(told, 50, 0)) if kind == "particles" else kind
    samples = measured(settings, drawn_scenario(cell, settings, 0))
    short = islice(samples, round(JUDGED_AT[0] * RATE) + 1)
    (found,) = judge(maker(settings), short, JUDGED_AT[:1], "other", cell.name, 0)
    assert abs(found.errors[QUANTITIES.index("slip")]) < 1e-3


def test_the_jacobian_of_a_particle_is_that_of_the_law_of_motion() -> None:
    cell = SLICE[2]
    settings = cell_settings(cell)
    particles = Particles(settings, 20, 0)
    for measurement, _ in islice(measured(settings, drawn_scenario(cell, settings, 0)), 300):
        particles.step(measurement)
    states, covariances = particles._cloud.states, particles._cloud.covariances
    state, steps = states[0], 0.1 * np.sqrt(np.diag(covariances[0]))
    each = np.full((2, len(states)), steps[[2, 6]][:, None])
    _, jacobians = motion_jacobians(particles.model.constants, states, *each, 1.0 / RATE)
    found = jacobians[0]
    rows = np.tile(state, (16, 1))
    rows[np.arange(8), _STRAIGHT] += steps
    rows[8 + np.arange(8), _STRAIGHT] -= steps
    moved = particles.model.moved(rows, 1.0 / RATE)[:, :3]
    expected = ((moved[:8] - moved[8:]) / (2.0 * steps[:, None])).T
    scale = np.sqrt(np.sum((expected * steps) ** 2, axis=1, keepdims=True))
    assert np.max(np.abs(found - expected) * steps / scale) < 0.01


def test_a_reading_that_few_particles_explain_is_taken_in_by_parts() -> None:
    particles = Particles(cell_settings(SLICE[0]), 400, 0)
    samples = measured(
        cell_settings(SLICE[0]), drawn_scenario(SLICE[0], cell_settings(SLICE[0]), 0)
    )
    for measurement, _ in islice(samples, 20):
        particles.step(measurement)
    speeds = particles._cloud.states[:, SENSED]
    far = np.mean(speeds, axis=0) + 1000.0 * np.std(speeds, axis=0) * (1.0, -1.0, 0.0, 0.0)
    dull, sharp = np.full(4, 1e6), np.full(4, 1e-12)
    assert particles._weigh(far, dull, 1.0) == 1.0
    assert particles._weigh(far, sharp, 1.0) < 0.1
    assert _effective(particles._cloud.log_weights) > 0.25
