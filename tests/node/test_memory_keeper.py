"""What a drive has taught, kept in a file: what is written when, and what a bad file does."""

import json
import math
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from belt_msgs.srv import RecordMaintenance
from node_harness import PAPER_DRIVE

from belt_ros.estimation import BeltEstimate, MaintenanceKind, Measurement, MemoryRefusedError
from belt_ros.estimation.memory_file import load
from belt_ros.node import services
from belt_ros.node.memory import BEFORE_FAILURE, Memory, span
from belt_ros.node.pipeline import Pipeline
from belt_ros.settings import load_settings

SETTINGS = load_settings(PAPER_DRIVE)
DATE = 1.7e9
DAY = 86400.0
STEP_NS = 10_000_000


class Run:
    """One run of a drive with a memory; its clocks stand still unless they are set."""

    def __init__(self, path: Path, wall: float = DATE, **overrides: object) -> None:
        settings = load_settings(PAPER_DRIVE, overrides) if overrides else SETTINGS
        self.wall = wall
        self.steady = 0.0
        self.stamp_ns = 0
        self.warnings: list[str] = []
        self.pipeline = Pipeline("node", ("/joint_states",), settings, steady=lambda: self.steady)
        self.memory = Memory(
            path, self.pipeline, self.warnings.append, lambda: self.wall, lambda: self.steady
        )
        self.said = self.memory.restore()

    def give(self) -> BeltEstimate | None:
        """Give it a measurement with the present stamp."""
        measurement = Measurement(self.stamp_ns, 120.0, 119.4, 30.0, -30.0)
        return self.pipeline.take(measurement, self.stamp_ns, self.stamp_ns).estimate

    def take(self) -> float:
        """Take in a measurement; return the standard deviation of the tension [N]."""
        self.stamp_ns += STEP_NS
        estimate = self.give()
        assert estimate is not None
        return estimate.mean_tension.stddev

    def maintain(self, action: int, value: float = math.nan, stddev: float = math.nan):
        request = RecordMaintenance.Request(action=action, value=value, value_stddev=stddev)
        return services.record_maintenance(self.pipeline, self.memory, request)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "deep" / "belt.json"


@pytest.fixture
def taught(path: Path) -> Path:
    """The file of a drive whose tension was measured as 400 +/- 8 N."""
    run = Run(path)
    run.take()
    assert run.maintain(MaintenanceKind.TENSION_MEASURED, 400.0, 8.0).success
    run.memory.close()
    return path


def test_without_a_file_a_run_begins_at_the_priors_and_says_so(path: Path) -> None:
    run = Run(path)

    assert run.said == f"paper_drive: no memory yet in '{path}'"
    assert run.take() == pytest.approx(60.0, rel=0.01)
    assert run.warnings == []
    assert math.isnan(run.memory.report().since_saved)


def test_nothing_is_written_before_something_was_estimated(path: Path) -> None:
    run = Run(path)
    run.memory.save()
    run.memory.close()

    assert not path.exists()


def test_a_run_begins_with_what_the_last_one_kept(taught: Path) -> None:
    run = Run(taught, wall=DATE + 600.0)

    assert run.said == f"paper_drive: restored what was learned 10 min ago, '{taught}'"
    assert run.take() < 15.0
    assert run.memory.report().restored_age == pytest.approx(600.0)


def test_it_is_written_once_for_all_that_has_come_since(path: Path) -> None:
    run = Run(path)
    run.take()
    run.memory.finish()
    run.steady = 5.0
    run.memory.finish()
    assert run.memory.report().saves == 1
    assert run.memory.report().since_saved == 5.0

    run.take()
    run.memory.finish()
    assert run.memory.report().saves == 2
    assert run.memory.report().since_saved == 0.0


def test_a_report_does_not_wait_for_a_disk_that_hangs(path: Path) -> None:
    run = Run(path)
    run.take()
    freed = threading.Event()
    run.memory._writer.submit(freed.wait, 20.0)
    run.memory.save()
    assert run.memory.report().saves == 0
    freed.set()
    run.memory.finish()
    assert run.memory.report().saves == 1


def test_what_is_kept_is_as_old_as_the_last_measurement(path: Path) -> None:
    run = Run(path)
    run.take()
    run.wall, run.steady = DATE + 60.0, 60.0
    run.memory.close()

    learned = load(path, "paper_drive")
    assert learned is not None
    assert learned.date == DATE


def test_a_clock_set_back_between_two_runs_is_said(taught: Path) -> None:
    run = Run(taught, wall=DATE - DAY)

    assert "the clock was set back" in run.said
    assert run.take() < 15.0
    assert run.memory.report().restored_age == 0.0


def without_its_end(content: bytes) -> bytes:
    return content[:-40]


def with_nan(content: bytes) -> bytes:
    return content.replace(str(json.loads(content)["means"][0][0]).encode(), b"NaN", 1)


def of_wider_pulleys(content: bytes) -> bytes:
    return content.replace(b'"driver_radius": 0.08125', b'"driver_radius": 0.09', 1)


@pytest.mark.parametrize(
    "damage",
    [
        without_its_end,
        with_nan,
        of_wider_pulleys,
        *(lambda _, bad=bad: bad for bad in (b"", b"\xff\x00", b"[]", b"name: paper_drive")),
    ],
)
def test_a_file_that_cannot_be_used_is_reported_once_ignored_and_kept_aside(
    taught: Path, damage: Callable[[bytes], bytes]
) -> None:
    bad = damage(taught.read_bytes())
    assert bad != taught.read_bytes()
    taught.write_bytes(bad)
    run = Run(taught)

    assert run.said == ""
    assert len(run.warnings) == 1
    assert str(taught) in run.warnings[0]
    assert "\n" not in run.warnings[0]
    assert run.memory.report().trouble == run.warnings[0]
    assert run.take() == pytest.approx(60.0, rel=0.01)
    assert taught.read_bytes() == bad

    run.memory.close()
    assert taught.with_name("belt.json.refused").read_bytes() == bad
    assert load(taught, "paper_drive") is not None
    assert run.memory.report().trouble == ""


@pytest.mark.parametrize(
    ("overrides", "reason"),
    [
        ({"name": "another"}, "is the memory of 'paper_drive', not of 'another'"),
        ({"driven.radius": 0.09}, "is of another drive"),
    ],
)
def test_the_memory_of_another_drive_is_refused(
    taught: Path, overrides: dict[str, object], reason: str
) -> None:
    run = Run(taught, **overrides)

    assert reason in run.warnings[0]
    assert run.take() == pytest.approx(60.0, rel=0.01)


@pytest.mark.parametrize(
    "where", ["folder", "/", "file/belt.json", "a" * 300, "nul\0", "/dev/null"]
)
def test_a_place_that_cannot_be_written_is_a_warning_and_no_more(
    tmp_path: Path, where: str
) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("not a folder")
    run = Run(tmp_path / where)
    for _ in range(3):
        run.take()
        run.memory.finish()

    assert run.warnings
    assert len(run.warnings) == len(set(run.warnings))
    assert run.memory.report().trouble
    assert run.memory.report().saves == 0
    assert (tmp_path / "folder").is_dir()
    assert not Path("/dev/null").is_file()


def test_what_could_not_be_written_is_written_once_it_can(tmp_path: Path) -> None:
    blocked = tmp_path / "folder"
    blocked.write_text("in the way")
    run = Run(blocked / "belt.json")
    run.take()
    run.memory.finish()
    assert run.memory.trouble

    blocked.unlink()
    run.memory.finish()
    assert run.memory.trouble == ""
    assert run.memory.report().saves == 1


def test_what_is_not_fit_to_be_kept_is_a_warning(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = Run(path)
    run.take()

    def refuse(*_: object) -> None:
        raise MemoryRefusedError("the means must lie within 100 of nought")

    monkeypatch.setattr(run.pipeline, "learned", refuse)
    run.memory.close()
    assert "not fit to be kept" in run.warnings[0]
    assert not path.exists()


def test_a_memory_that_upsets_the_arithmetic_is_refused(
    taught: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise np.linalg.LinAlgError("singular")

    monkeypatch.setattr(Pipeline, "restore", fail)
    run = Run(taught)
    assert "singular; starting at the priors" in run.warnings[0]


def test_a_reset_goes_back_to_the_priors_for_good(taught: Path) -> None:
    run = Run(taught)
    run.take()
    answer = services.reset(run.pipeline, run.memory, lambda _: None)
    aside = taught.with_name("belt.json.before_reset")

    assert answer.success
    assert "started anew at the configured priors, reset 1" in answer.message
    assert answer.message.endswith(f"what was learned before is kept as {aside}")
    assert load(aside, "paper_drive") is not None
    assert run.take() == pytest.approx(60.0, rel=0.01)
    assert Run(taught).take() == pytest.approx(60.0, rel=0.01)

    run.memory.close()
    assert Run(taught).take() == pytest.approx(60.0, rel=0.01)


def test_maintenance_is_kept_at_once(path: Path) -> None:
    run = Run(path)
    run.take()
    run.maintain(MaintenanceKind.RETENSIONED, 500.0, 5.0)

    assert Run(path).take() < 10.0


def test_maintenance_is_kept_also_before_the_first_measurement(path: Path) -> None:
    Run(path).maintain(MaintenanceKind.RETENSIONED, 500.0, 5.0)

    assert Run(path).take() < 10.0


@pytest.mark.parametrize("by_clock", [True, False])
def test_a_backward_jump_leads_back_to_what_was_restored(taught: Path, by_clock: bool) -> None:
    run = Run(taught)
    run.stamp_ns = 100 * 10**9
    known = run.take()
    run.stamp_ns = 50 * 10**9
    if by_clock:
        assert run.pipeline.reset_after_jump(run.stamp_ns)
    else:
        for _ in range(2):
            run.stamp_ns += STEP_NS
            run.give()

    assert run.take() == pytest.approx(known, rel=0.01)
    assert run.pipeline.health.resets == 1


def test_maintenance_that_cannot_be_kept_is_taken_in_and_says_so(tmp_path: Path) -> None:
    run = Run(tmp_path)
    run.take()
    answer = run.maintain(MaintenanceKind.RETENSIONED, 500.0, 5.0)

    assert answer.success
    assert "; not kept: " in answer.message
    assert run.take() < 10.0


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.0, "0 s"), (119.0, "119 s"), (300.0, "5 min"), (7200.0, "2 h"), (1e6, "12 days")],
)
def test_a_span_is_told_in_the_unit_that_suits_it(seconds: float, text: str) -> None:
    assert span(seconds) == text


def test_a_copy_outlives_what_is_learned_after_time_went_back(path: Path) -> None:
    run = Run(path)
    assert run.memory.copy() == ""  # nothing of this run is in the file
    for _ in range(50):
        run.take()
    run.memory.finish()
    before = path.read_bytes()

    aside = path.with_name(path.name + ".before_jump")
    assert str(aside) in run.memory.copy()
    run.take()
    run.memory.finish()
    assert path.read_bytes() != before
    assert aside.read_bytes() == before
    assert run.warnings == []


def test_a_copy_that_cannot_be_made_is_told_of(path: Path) -> None:
    run = Run(path)
    run.take()
    run.memory.finish()
    path.with_name(path.name + ".before_jump").mkdir()
    assert "cannot be copied" in run.memory.copy()
    assert "cannot be copied" in run.memory.trouble


def test_what_was_learned_before_a_run_failed_outlives_further_failures(taught: Path) -> None:
    run = Run(taught)
    good = taught.read_text()
    for _ in range(3):
        run.memory.forget(BEFORE_FAILURE)
        run.pipeline.give_up()
        run.take()
        run.memory.finish()
    assert taught.with_name(taught.name + BEFORE_FAILURE).read_text() == good
    assert taught.read_text() != good
