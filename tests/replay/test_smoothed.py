"""What replay writes with hindsight, beside what the filter knew at the time."""

import dataclasses
import errno
import json
import math
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from bags import PERIOD_NS, steady_run
from typer.testing import CliRunner

from belt_ros.cli import app
from belt_ros.estimation.tape import Tape
from belt_ros.replay import BagError, ResultsError, replay

ROOT = Path(__file__).parents[2]
DATA = ROOT / "tests" / "data"
NAMES = ("estimates.parquet", "smoothed.parquet")


def columns(out, name="smoothed.parquet"):
    return pq.read_table(out / name).to_pydict()


@pytest.fixture(scope="module")
def smoothed(settings, tmp_path_factory):
    """The recorded rig's results, and their summary."""
    if not (DATA / "rig_bag").is_dir():
        pytest.skip("tests/data/rig_bag is not there")
    out = tmp_path_factory.mktemp("smoothed") / "out"
    return out, replay(DATA / "rig_bag", settings, out)


def test_columns_are_those_of_the_filtered_table_with_their_units(smoothed):
    filtered, own = (pq.read_schema(smoothed[0] / name) for name in NAMES)
    for field in own:
        if field.name != "changing_probability":
            assert filtered.field(field.name).equals(field, check_metadata=True), field.name
    assert own.field("changing_probability").metadata == {b"unit": b"-"}
    assert own.metadata[b"drive_name"] == filtered.metadata[b"drive_name"]
    for name in ("slip", "mean_tension", "friction_stiffness", "margin", "capacity_torque"):
        assert own.field(f"{name}_stddev")


def test_rows_are_in_the_order_of_time_and_every_half_second(smoothed):
    stamps = columns(smoothed[0])["stamp_ns"]
    filtered = columns(smoothed[0], "estimates.parquet")["stamp_ns"]
    assert stamps == sorted(stamps)
    assert (stamps[0], stamps[-1]) == (filtered[0], filtered[-1])
    apart = np.abs(np.subtract.outer(np.array(stamps), np.array(filtered)))
    assert np.max(np.min(apart, axis=1)) <= 10_000_000  # between two samples in a lull
    assert np.max(np.diff(np.array(stamps) // 500_000_000)) <= 1  # one in each half second


def test_every_number_is_sound(smoothed):
    for name, values in columns(smoothed[0]).items():
        assert np.all(np.isfinite(values)), name
        assert not name.endswith("_stddev") or min(values) >= 0.0, name


def test_tension_and_margin_come_nearer_the_truth_before_the_first_change(smoothed):
    """420 N till 3.5 s; what tells that is the overload at 5.4 s."""
    filtered, own = (columns(smoothed[0], name) for name in NAMES)
    start = own["stamp_ns"][0]

    def error(table):
        early = [i for i, t in enumerate(table["stamp_ns"]) if t - start < 3_400_000_000]
        return math.sqrt(np.mean([(table["mean_tension"][i] - 420.0) ** 2 for i in early]))

    assert error(own) < 0.5 * error(filtered)
    assert own["mean_tension_stddev"][0] < 0.5 * filtered["mean_tension_stddev"][0]


def test_the_summary_says_what_the_rows_say(smoothed):
    out, summary = smoothed
    table, found = columns(out), summary.smoothed
    assert found.rows == len(table["stamp_ns"])
    assert found.block == 0.5
    worst = int(np.argmin(table["margin"]))
    assert found.worst_margin.value == table["margin"][worst]
    assert found.worst_margin.stamp_ns == table["stamp_ns"][worst]
    elapsed = (table["stamp_ns"][worst] - table["stamp_ns"][0]) * 1e-9
    assert found.worst_margin.time == pytest.approx(elapsed)
    for place, told in ((0, found.initial), (-1, found.final)):
        for name, quantity in told.items():
            assert quantity.value == table[name][place]
            assert quantity.stddev == table[f"{name}_stddev"][place]
    best = found.best_known["friction_stiffness"]
    at = int(np.argmin(table["friction_stiffness_log_stddev"]))
    assert (best.value, best.stamp_ns) == (table["friction_stiffness"][at], table["stamp_ns"][at])
    spread = table["friction_stiffness_log_stddev"][at]
    assert best.high == pytest.approx(best.value * math.exp(1.96 * spread))
    relative = np.array(table["mean_tension_stddev"]) / table["mean_tension"]
    at = int(np.argmin(relative))
    assert found.best_known["mean_tension"].value == table["mean_tension"][at]
    written = json.loads((out / "summary.json").read_text(encoding="utf-8"))["smoothed"]
    assert written == json.loads(json.dumps(dataclasses.asdict(found)))


def test_without_smoothing_the_filtered_results_are_the_same_byte_by_byte(
    make_bag, settings, tmp_path
):
    bag = make_bag(steady_run(120))
    for name, smooth in (("with", True), ("without", False)):
        summary = replay(bag, settings, tmp_path / name, smooth=smooth)
        assert (summary.smoothed is not None) == smooth
        assert (tmp_path / name / "smoothed.parquet").exists() == smooth
    kept = ["estimates.parquet", *(f"estimates/{n}" for n in ("metadata.yaml", "estimates.mcap"))]
    for name in kept:
        first, second = ((tmp_path / place / name).read_bytes() for place in ("with", "without"))
        assert first == second, name


def test_two_runs_are_identical_byte_by_byte(make_bag, settings, tmp_path):
    bag = make_bag(steady_run(120))
    tables = []
    for name in ("first", "second"):
        replay(bag, settings, tmp_path / name)
        tables.append((tmp_path / name / "smoothed.parquet").read_bytes())
    assert tables[0] == tables[1]


def test_rows_are_written_group_by_group(make_bag, settings, tmp_path, monkeypatch):
    bag = make_bag(steady_run(160))
    replay(bag, settings, tmp_path / "whole")
    monkeypatch.setattr("belt_ros.replay.tables._ROW_GROUP", 2)
    monkeypatch.setattr("belt_ros.replay.smoothing._IN_MEMORY", 100)
    replay(bag, settings, tmp_path / "parts")
    assert columns(tmp_path / "parts") == columns(tmp_path / "whole")
    parts = pq.ParquetFile(tmp_path / "parts" / "smoothed.parquet").metadata
    assert [parts.row_group(i).num_rows for i in range(parts.num_row_groups - 1)] == [2] * (
        parts.num_row_groups - 1
    )


def test_a_looping_bag_gives_each_loop_rows_of_its_own(make_bag, settings, tmp_path):
    once = steady_run(120)
    again = [
        sample._replace(log_ns=sample.log_ns + 10**10, stamp_ns=sample.stamp_ns - 10**11)
        for sample in once
    ]
    summary = replay(make_bag([*once, *again]), settings, tmp_path / "out")
    table = columns(tmp_path / "out")
    resets = table["reset_count"]
    assert resets == sorted(resets)
    assert set(resets) == {0, 1}
    first = resets.index(1)
    assert table["stamp_ns"][first] == again[2].stamp_ns
    assert table["stamp_ns"][first - 1] == once[-1].stamp_ns
    steps = np.diff(table["stamp_ns"])
    assert np.sum(steps < 0) == 1
    assert summary.smoothed.rows == len(resets)
    assert summary.resets == 1


def test_one_usable_message_gives_a_row(make_bag, settings, tmp_path):
    summary = replay(make_bag(steady_run(1)), settings, tmp_path / "out")
    assert summary.smoothed.rows == 1
    assert columns(tmp_path / "out")["stamp_ns"] == [steady_run(1)[0].stamp_ns]


def test_a_bag_without_anything_usable_is_still_refused(make_bag, settings, tmp_path):
    blind = [s._replace(velocity=(math.nan, math.nan)) for s in steady_run(3)]
    with pytest.raises(BagError, match="none of the 3"):
        replay(make_bag(blind), settings, tmp_path / "out")
    assert [path.name for path in tmp_path.iterdir()] == ["bag"]


def test_results_of_either_kind_are_replaced(make_bag, settings, tmp_path):
    bag = make_bag(steady_run(5))
    replay(bag, settings, tmp_path / "out")
    replay(bag, settings, tmp_path / "out", replace=True, smooth=False)
    assert not (tmp_path / "out" / "smoothed.parquet").exists()
    replay(bag, settings, tmp_path / "out", replace=True)
    assert (tmp_path / "out" / "smoothed.parquet").exists()


def test_progress_counts_smoothed_moments_too(make_bag, settings, tmp_path, monkeypatch):
    monkeypatch.setattr("belt_ros.replay.run._PROGRESS_EVERY", 1)
    told = []
    replay(
        make_bag(steady_run(120)),
        settings,
        tmp_path / "out",
        progress=lambda done, total: told.append((done, total)),
    )
    rows = len(columns(tmp_path / "out")["stamp_ns"])
    assert [done for done, _ in told] == list(range(1, 121 + rows))
    assert told[119][1] == 120
    assert told[-1] == (120 + rows, 120 + rows)


def full_disk(_tape, _record):
    raise OSError(errno.ENOSPC, "No space left on device")


@pytest.mark.parametrize("samples", [4, 120])
def test_no_room_for_smoothing_is_told_in_one_line(
    make_bag, settings, tmp_path, monkeypatch, samples
):
    """Found at the end of a short bag, and on the way through a longer one."""
    bag = make_bag(steady_run(samples))
    monkeypatch.setattr(Tape, "append", full_disk)
    with pytest.raises(ResultsError, match=r"No space left.*--no-smooth"):
        replay(bag, settings, tmp_path / "out")
    config = ROOT / "config" / "paper_drive.yaml"
    words = ["replay", str(bag), "-c", str(config), "-o", str(tmp_path / "out")]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 1
    assert len(result.stderr.strip().splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["bag"]
    result = CliRunner().invoke(app, [*words, "--no-smooth", "--quiet"])
    assert result.exit_code == 0, result.output
    assert result.output == ""


def test_stamps_that_jump_ahead_leave_a_gap_between_rows(make_bag, settings, tmp_path):
    samples = steady_run(240)
    hour = 3_600_000_000_000
    moved = [s._replace(log_ns=s.log_ns + hour, stamp_ns=s.stamp_ns + hour) for s in samples[120:]]
    summary = replay(make_bag([*samples[:120], *moved]), settings, tmp_path / "out")
    stamps = np.array(columns(tmp_path / "out")["stamp_ns"])
    assert np.all(np.diff(stamps) >= 0)
    assert not np.any((stamps > samples[119].stamp_ns) & (stamps < moved[0].stamp_ns))
    assert summary.rejected["out_of_order"] == 2
    assert summary.smoothed.rows < 20
    assert stamps[-1] - stamps[0] == hour + 239 * PERIOD_NS
