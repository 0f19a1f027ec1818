"""Trends over months: weighted lines, their errors, and the order of the drives."""

import math

import numpy as np
import pyarrow.parquet as pq
import pytest

from belt_ros.fleet.page import render
from belt_ros.fleet.records import Row, failed_row
from belt_ros.fleet.table import write_tables
from belt_ros.fleet.trends import MONTH, _Point, fitted, trends

START_NS = 1_700_000_000_000_000_000


def at(months):
    return START_NS + round(months * MONTH * 1e9)


def row(months, tension, stddev, drive="a", **changes):
    values = {
        "start_ns": at(months),
        "hours": 1.0,
        "tension": tension,
        "tension_stddev": stddev,
        "tension_learned": True,
        "kf": 5e6,
        "kf_stddev": 5e5,
        "kf_learned": True,
        "mu": 1.0,
        "mu_stddev": 0.1,
        "worst_margin": 0.5,
        "worst_margin_stddev": 0.05,
        "accepted_share": 1.0,
        "messages": 10,
    }
    return Row(drive, f"/bags/{months}", **{**values, **changes})


def test_the_line_is_that_of_weighted_least_squares():
    random = np.random.default_rng(0)
    months = np.sort(random.uniform(0.0, 24.0, 12))
    stddevs = random.uniform(2.0, 20.0, 12)
    values = 420.0 - 1.5 * months + stddevs * random.standard_normal(12)
    line = fitted([_Point(at(m), v, s) for m, v, s in zip(months, values, stddevs, strict=True)])
    design = np.stack([np.ones(12), months - months[0]], axis=1) / stddevs[:, None]
    best, squares, *_ = np.linalg.lstsq(design, values / stddevs, rcond=None)
    scatter = math.sqrt(squares[0] / 10)
    errors = np.sqrt(np.diag(np.linalg.inv(design.T @ design))) * max(scatter, 1.0)
    assert (line.level, line.slope) == pytest.approx(best, rel=1e-6)
    assert (line.level_stddev, line.slope_stddev) == pytest.approx(errors, rel=1e-6)
    assert line.scatter == pytest.approx(scatter, rel=1e-6)


def test_stated_errors_of_slopes_are_true():
    random = np.random.default_rng(1)
    months, stddev = np.arange(0.0, 12.0), 10.0
    inside = 0
    for _ in range(400):
        values = 400.0 - 2.0 * months + stddev * random.standard_normal(12)
        line = fitted([_Point(at(m), v, stddev) for m, v in zip(months, values, strict=True)])
        inside += abs(line.slope + 2.0) < 1.96 * line.slope_stddev
    assert 0.94 < inside / 400 <= 1.0  # enlarging errors by the scatter makes them cautious


def test_points_that_scatter_more_than_they_say_widen_the_line():
    quiet = fitted([_Point(at(m), 400.0 + d, 1.0) for m, d in enumerate((0, 1, -1, 0))])
    loud = fitted([_Point(at(m), 400.0 + d, 1.0) for m, d in enumerate((0, 50, -50, 0))])
    assert loud.scatter > 10.0
    assert loud.slope_stddev > 10.0 * quiet.slope_stddev


def test_loss_is_that_of_1000_hours():
    (trend,) = trends([row(0, 420.0, 1.0), row(10, 400.0, 1.0)])
    hours = 10 * MONTH / 3600.0
    assert trend.loss_per_1000_h.value == pytest.approx(20.0 / hours * 1000.0)
    assert trend.loss_per_1000_h.stddev == pytest.approx(math.sqrt(2.0) / hours * 1000.0)


def test_a_bag_that_taught_nothing_is_not_in_the_line():
    rows = [row(0, 420.0, 1.0), row(1, 300.0, 60.0, tension_learned=False), row(2, 410.0, 1.0)]
    (trend,) = trends(rows)
    assert trend.tension.points == 2
    assert trend.tension.slope == pytest.approx(-5.0)
    (alone,) = trends(rows[:2])
    assert alone.tension is None
    assert alone.loss_per_1000_h is None


def test_drives_are_ranked_by_their_worst_margin():
    rows = [
        row(0, 400.0, 1.0, "good"),
        row(0, 400.0, 1.0, "bad", worst_margin=0.1),
        row(1, 400.0, 1.0, "good", worst_margin=0.4),
        failed_row("silent", "/bags/x", "no bag"),
    ]
    assert [trend.drive for trend in trends(rows)] == ["bad", "good", "silent"]
    silent = trends(rows)[-1]
    assert (silent.bags, silent.failed, silent.hours) == (1, 1, 0.0)


def test_page_shows_everything_and_escapes_it():
    hostile = "<script>alert(1)</script>"
    rows = [row(m, 420.0 - m, 1.0, hostile) for m in range(3)]
    rows.append(failed_row("b", "/bags/broken.mcap", f"damaged {hostile}"))
    page = render(rows, trends(rows))
    assert "<script>alert" not in page
    assert page.count("<circle") == 9
    assert "broken.mcap" in page
    assert "1.37" in page  # N in 1000 h
    assert "http://" not in page.replace("http://www.w3.org", "")


def test_tables_hold_the_rows_and_unknowns_are_null(tmp_path):
    rows = [row(0, 420.0, 1.0), failed_row("a", "/bags/x", "no bag")]
    parquet, text = write_tables(tmp_path, rows)
    table = pq.read_table(parquet).to_pylist()
    assert table[0]["tension"] == 420.0
    assert table[1]["tension"] is None
    assert table[1]["start"] is None
    assert table[1]["error"] == "no bag"
    assert text.read_text(encoding="utf-8").count("\n") == 3
    assert sorted(path.name for path in tmp_path.iterdir()) == ["fleet.csv", "fleet.parquet"]
