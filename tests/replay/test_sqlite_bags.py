"""SQLite bags as recorders leave them: with a write-ahead log, and under any name."""

import shutil
import sqlite3
from collections.abc import Sequence
from pathlib import Path

import pytest
from bags import Sample, cdr, steady_run, write_bag
from reading import expected, read
from rosbags.rosbag2 import StoragePlugin

from belt_ros.replay import BagError
from belt_ros.replay.bags import files_of
from belt_ros.replay.drive_bag import DriveBag

SAMPLES = steady_run(20)


def stored(path: Path, samples: Sequence[Sample] = SAMPLES) -> Path:
    """A bag under a name under which rosbags would not write it."""
    plain = write_bag(
        path.with_name("plain"), {"/joint_states": samples}, plugin=StoragePlugin.SQLITE3
    )
    metadata = plain / "metadata.yaml"
    metadata.write_text(metadata.read_text().replace("plain.db3", f"'{path.name}.db3'"))
    (plain / "plain.db3").rename(plain / f"{path.name}.db3")
    return plain.rename(path)


def killed(path: Path, name: str = "bag") -> Path:
    """A bag whose recorder was killed: its newest half is in the write-ahead log only."""
    whole = stored(path.with_name("whole"), SAMPLES[:10])
    database = sqlite3.connect(whole / "whole.db3")
    database.execute("PRAGMA journal_mode=WAL")
    database.executemany(
        "INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?, ?)",
        [(sample.log_ns, cdr(sample)) for sample in SAMPLES[10:]],
    )
    database.commit()
    path.mkdir()
    for ending in (".db3", ".db3-wal"):
        shutil.copy(whole / f"whole{ending}", path / f"{name}{ending}")
    database.close()
    shutil.rmtree(whole)
    return path


def contents(folder: Path) -> dict[str, tuple[bytes, int]]:
    return {file.name: (file.read_bytes(), file.stat().st_mtime_ns) for file in folder.rglob("*.*")}


def with_metadata(bag: Path) -> Path:
    """The same bag with the metadata that its recorder wrote first."""
    other = stored(bag.with_name("other"), SAMPLES[:1])
    text = (other / "metadata.yaml").read_text()
    (bag / "metadata.yaml").write_text(text.replace("other.db3", "bag.db3"))
    return bag


def test_what_is_in_the_write_ahead_log_only_is_read_too(settings, tmp_path):
    bag = killed(tmp_path / "bag")
    assert read(bag, settings) == expected(SAMPLES)
    assert read(bag / "bag.db3", settings) == expected(SAMPLES)
    assert read(with_metadata(bag), settings) == expected(SAMPLES)


def test_nothing_is_made_or_changed_beside_the_bag_nor_left_elsewhere(
    settings, tmp_path, monkeypatch
):
    bag = killed(tmp_path / "bag")
    (tmp_path / "room").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "room"))
    before = contents(bag)
    assert read(bag, settings) == expected(SAMPLES)
    assert contents(bag) == before
    (bag / "bag.db3").write_bytes(b"no bag")
    with pytest.raises(BagError, match="Give a rosbag2 directory"):
        read(bag, settings)
    assert list((tmp_path / "room").iterdir()) == []


def test_a_bag_with_a_log_that_finds_no_room_says_so(settings, tmp_path, monkeypatch):
    def full(*_arguments, **_options):
        raise OSError(28, "No space left on device")

    bag = killed(tmp_path / "bag")
    monkeypatch.setattr("shutil.copyfile", full)
    with pytest.raises(BagError, match=r"bag\.db3: .*\(No space left on device\)\. .*TMPDIR"):
        read(bag / "bag.db3", settings)


@pytest.mark.parametrize("name", ["run#1", "run?", "100%25", "%2e"])
def test_a_name_may_be_anything_that_a_file_may_be_called(settings, tmp_path, name):
    bag = stored(tmp_path / name)
    assert read(bag, settings) == expected(SAMPLES)
    assert read(bag / f"{name}.db3", settings) == expected(SAMPLES)
    logged = killed(tmp_path / f"{name} killed", name)
    assert read(logged / f"{name}.db3", settings) == expected(SAMPLES)


def test_a_write_ahead_log_is_part_of_the_bag(tmp_path):
    bag = killed(tmp_path / "bag")
    assert [file.name for file in files_of(bag)] == ["bag.db3", "bag.db3-wal"]
    assert [file.name for file in files_of(bag / "bag.db3")] == ["bag.db3", "bag.db3-wal"]


def test_a_log_of_which_nothing_was_committed_costs_nothing(settings, tmp_path):
    bag = killed(tmp_path / "bag")
    log = bag / "bag.db3-wal"
    log.write_bytes(log.read_bytes()[:40])
    with DriveBag(bag, settings) as source:
        assert list(source.samples()) == expected(SAMPLES[:10])
