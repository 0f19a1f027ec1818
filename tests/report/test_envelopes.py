import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.report.envelopes import EVERY_ROW, EnvelopeTally, Grid
from belt_ros.report.table_scan import Batch

PERIOD = 0.01  # s


def batch(elapsed, **columns):
    count = len(elapsed)
    given_columns = {
        "margin": np.zeros(count),
        "margin_stddev": np.zeros(count),
        "driver_speed": np.full(count, 100.0),
    } | columns
    step = np.diff(elapsed, prepend=elapsed[0] - PERIOD)
    return Batch(elapsed, step, np.round(elapsed * 1e9).astype(np.int64), given_columns)


def gathered(whole, cuts, grid, names=("margin",), only_moving=()):
    """Curves of one batch that is handed over in pieces."""
    tally = EnvelopeTally(grid, names, only_moving, 1.0)
    for start, end in zip([0, *cuts], [*cuts, len(whole.elapsed)], strict=True):
        if start < end:
            columns = {name: values[start:end] for name, values in whole.columns.items()}
            arrays = (part[start:end] for part in whole[:3])
            tally.add(Batch(*arrays, columns))
    return tally.curves()


def test_a_short_table_keeps_every_row():
    elapsed = np.arange(500) * PERIOD
    values = np.random.default_rng(1).normal(size=500)
    grid = Grid(500, elapsed[-1], 1.0)
    curves = gathered(batch(elapsed, margin=values), [], grid)
    np.testing.assert_array_equal(curves.curves["margin"].least, values)
    np.testing.assert_allclose(curves.time, elapsed)
    assert curves.every_row


@given(st.integers(0, 2**32 - 1))
@settings(derandomize=True, deadline=None, max_examples=20)
def test_no_peak_of_a_long_table_is_lost_and_its_page_stays_small(seed):
    generator = np.random.default_rng(seed)
    rows = int(generator.integers(EVERY_ROW + 1, 200_000))
    elapsed = np.arange(rows) * PERIOD
    values = generator.normal(size=rows)
    place = int(generator.integers(rows))
    values[place] = 50.0
    moments = [int(elapsed[i] * 1e9) for i in generator.integers(rows, size=20)]
    grid = Grid(rows, elapsed[-1], 1.0, moments)
    cuts = sorted(generator.integers(rows, size=5).tolist())
    curves = gathered(batch(elapsed, margin=values), cuts, grid)
    curve = curves.curves["margin"]
    assert np.max(curve.greatest) == 50.0
    assert np.min(curve.least) == np.min(values)
    assert len(curves.time) < 20_000
    assert np.all(np.diff(curves.time) > 0.0)
    bucket = int(np.argmax(curve.greatest))
    width = np.max(np.diff(curves.time))
    assert abs(curves.time[bucket] - elapsed[place]) <= width


def test_batches_do_not_show_in_the_curves():
    rows = EVERY_ROW * 3
    elapsed = np.arange(rows) * PERIOD
    values = np.random.default_rng(2).normal(size=rows)
    grid = Grid(rows, elapsed[-1], 1.0)
    whole = gathered(batch(elapsed, margin=values), [], grid)
    pieces = gathered(batch(elapsed, margin=values), [5, 6, 7001, 20_003], grid)
    np.testing.assert_allclose(whole.time, pieces.time)
    np.testing.assert_array_equal(whole.curves["margin"], pieces.curves["margin"])


def test_buckets_are_finer_about_alarms():
    rows = 400_000
    elapsed = np.arange(rows) * PERIOD
    grid = Grid(rows, elapsed[-1], 1.0, [int(2000.0 * 1e9)])
    curves = gathered(batch(elapsed), [], grid)
    widths = np.diff(curves.time)
    near = np.abs(curves.time[:-1] - 2000.0) < 1.0
    assert np.max(widths[near]) < 0.05 * np.median(widths)


def test_curves_break_in_gaps():
    elapsed = np.concatenate([np.arange(100), np.arange(1000, 1100)]) * PERIOD
    curves = gathered(batch(elapsed), [], Grid(200, elapsed[-1], 1.0))
    inside = (curves.time > 1.0) & (curves.time < 9.99)
    assert np.count_nonzero(inside) == 1
    assert np.isnan(curves.curves["margin"].least[inside]).all()


def test_slip_is_left_out_while_the_drive_hardly_moves():
    elapsed = np.arange(100) * PERIOD
    speed = np.where(elapsed < 0.5, 0.1, 100.0)
    whole = batch(elapsed, driver_speed=speed)
    curves = gathered(whole, [], Grid(100, elapsed[-1], 1.0), only_moving=("margin",))
    np.testing.assert_array_equal(np.isnan(curves.curves["margin"].high), elapsed < 0.5)


def test_band_of_kf_is_log_normal():
    elapsed = np.arange(10) * PERIOD
    whole = batch(
        elapsed,
        friction_stiffness=np.full(10, 5e6),
        friction_stiffness_log_stddev=np.full(10, 0.5),
    )
    grid = Grid(10, elapsed[-1], 1.0)
    curve = gathered(whole, [], grid, ("friction_stiffness",)).curves["friction_stiffness"]
    assert curve.low[0] == pytest.approx(5e6 * np.exp(-0.98))
    assert curve.high[0] == pytest.approx(5e6 * np.exp(0.98))
