"""A memory's file gives back what was saved, and whatever fails leaves the one before."""

import json
import math
import os
import stat
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from memories import INSTALLED, exactly, learn, members, one

from belt_ros.estimation.memory_file import MemoryFileError, load, memory_path, save


@exactly
@given(members())
def test_a_file_gives_back_exactly_what_was_saved(tmp_path_factory, components) -> None:
    learned = learn(components)
    path = memory_path(tmp_path_factory.mktemp("memory"), learned.name)
    save(learned, path)
    loaded = load(path, learned.name)
    assert loaded is not None
    assert (loaded.name, loaded.date, loaded.drive) == (learned.name, learned.date, learned.drive)
    for field in ("weights", "means", "covariances"):
        assert np.array_equal(getattr(loaded, field), getattr(learned, field))
    assert loaded.installed == learned.installed == INSTALLED


def test_without_a_file_there_is_no_memory_and_no_error(tmp_path) -> None:
    assert load(tmp_path / "none" / "x.json", "x") is None


@given(st.text(max_size=25))
@exactly
def test_any_name_gives_a_file_of_its_own_in_the_folder(name) -> None:
    if not name.isprintable():
        return
    path = memory_path(Path("folder"), name)
    assert path.parent == Path("folder")
    assert path.name not in {".", ".."}
    assert path != memory_path(Path("folder"), name + "/")


def test_the_file_has_the_permissions_that_the_umask_leaves(tmp_path) -> None:
    before = os.umask(0o027)
    try:
        path = tmp_path / "x.json"
        save(learn(one()), path)
        assert stat.S_IMODE(path.stat().st_mode) == 0o640
    finally:
        os.umask(before)


@pytest.mark.parametrize(
    ("of", "step"), [(os, "fsync"), (Path, "replace"), (json, "dumps"), (Path, "open")]
)
@pytest.mark.parametrize("failure", [OSError("disk full"), KeyboardInterrupt()])
def test_whatever_step_of_saving_fails_the_previous_file_is_there(
    saved, monkeypatch, of, step, failure
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise failure

    before = saved.read_bytes()
    with monkeypatch.context() as patched:
        patched.setattr(of, step, fail)
        with pytest.raises(MemoryFileError if isinstance(failure, OSError) else KeyboardInterrupt):
            save(learn(one(300.0)), saved)
    assert saved.read_bytes() == before
    assert list(saved.parent.iterdir()) == [saved]


def test_a_power_cut_between_any_two_steps_leaves_the_old_file_or_the_new(
    saved, monkeypatch
) -> None:
    """Seen by what is on the disk just before and just after the renaming."""
    old, seen = saved.read_bytes(), []
    replace = Path.replace

    def watched(temporary: Path, target: Path) -> Path:
        seen.append((target.read_bytes(), temporary.read_bytes()))
        return replace(temporary, target)

    monkeypatch.setattr(Path, "replace", watched)
    save(learn(one(300.0)), saved)
    assert seen == [(old, saved.read_bytes())]
    assert old != saved.read_bytes()


def test_a_folder_is_no_file_to_save_to(tmp_path) -> None:
    for path in (Path("/"), tmp_path):
        with pytest.raises(MemoryFileError):
            save(learn(one()), path)


def test_a_folder_that_cannot_be_synchronised_does_not_undo_saving(saved, monkeypatch) -> None:
    fsync = os.fsync

    def only_files(descriptor: int) -> None:
        if stat.S_ISDIR(os.fstat(descriptor).st_mode):
            raise OSError("not supported")
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", only_files)
    save(learn(one(300.0)), saved)
    loaded = load(saved, "conveyor")
    assert loaded is not None
    assert loaded.means[0, 0] == pytest.approx(math.log(300.0))
