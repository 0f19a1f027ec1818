"""Results of bags have names that tell them apart."""

from pathlib import Path

import pytest

from belt_ros.replay.bags import result_names
from belt_ros.replay.errors import BagError


def bags(root: Path, *names: str) -> list[Path]:
    found = [root / name for name in names]
    for bag in found:
        if bag.suffix:
            bag.parent.mkdir(parents=True, exist_ok=True)
            bag.touch()
        else:
            bag.mkdir(parents=True)
    return found


def test_results_are_called_as_their_bags(tmp_path: Path) -> None:
    assert result_names(bags(tmp_path, "monday", "tuesday.mcap")) == ["monday", "tuesday"]


def test_bags_of_one_name_are_told_apart_by_their_folders(tmp_path: Path) -> None:
    found = bags(tmp_path, "a/run", "b/run", "b/other", "x/c/run.mcap", "y/c/run.db3")
    assert result_names(found) == ["a_run", "b_run", "other", "x_c_run", "y_c_run"]


def test_a_bag_and_its_only_file_have_names_of_their_own(tmp_path: Path) -> None:
    names = result_names(bags(tmp_path, "run", "run/run.mcap"))
    assert len(set(names)) == 2


def test_bags_that_no_folder_tells_apart_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BagError, match=r"run.* and .*run.*: rename one"):
        result_names(bags(tmp_path, "run.mcap", "run.db3"))
