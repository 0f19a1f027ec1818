"""Which bags are meant, and results of theirs have names that tell them apart."""

from pathlib import Path

import pytest
from bags import steady_run, write_bag

from belt_ros.replay.bags import find_bags, result_names
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


def pile(root: Path) -> list[Path]:
    """Two bags, the results of one, an empty folder, and files that are none."""
    found = [write_bag(root / name, {"/joint_states": steady_run(2)}) for name in ("a", "b")]
    (root / "a_belt").mkdir()
    (root / "a_belt" / "summary.json").touch()
    (root / "empty").mkdir()
    for name in ("notes.txt", "run.sh"):
        (root / name).touch()
    return found


def test_of_what_a_pattern_matches_only_bags_are_meant_and_the_rest_is_told(tmp_path: Path) -> None:
    found, told = pile(tmp_path), []
    assert find_bags([f"{tmp_path}/*"], tell=told.append) == found
    assert told == [
        f"{tmp_path}/*: 4 of 6 matches are no bags and are left alone: a_belt, empty, notes.txt, "
        "run.sh"
    ]
    assert find_bags([f"{tmp_path}/[ab]"], tell=told.append) == found
    assert len(told) == 1


def test_a_pattern_that_matches_a_bag_and_its_files_means_the_bag(tmp_path: Path) -> None:
    found = pile(tmp_path)
    assert find_bags([f"{tmp_path}/**/*", f"{tmp_path}/a/*.mcap"], tell=lambda _: None) == found


def test_many_that_are_no_bags_are_told_in_short(tmp_path: Path) -> None:
    pile(tmp_path)
    for number in range(20):
        (tmp_path / f"log_{number:02d}").touch()
    told: list[str] = []
    find_bags([f"{tmp_path}/*"], tell=told.append)
    assert "24 of 26 matches are no bags" in told[0]
    assert told[0].endswith("a_belt, empty, log_00, log_01, log_02, ...")


def test_a_pattern_that_matches_no_bag_at_all_is_refused(tmp_path: Path) -> None:
    pile(tmp_path)
    with pytest.raises(
        BagError, match=r"\*\.\*: nothing that matches it is a bag: notes.txt, run.sh"
    ):
        find_bags([f"{tmp_path}/*.*"])
    with pytest.raises(BagError, match=r"\*\.mcap: nothing matches it"):
        find_bags([f"{tmp_path}/*.mcap"])


def test_what_is_given_by_name_is_meant_though_it_is_no_bag(tmp_path: Path) -> None:
    pile(tmp_path)
    given = [tmp_path / "notes.txt", tmp_path / "empty", tmp_path / "gone"]
    assert find_bags(given) == given


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


def test_what_a_killed_run_left_hidden_is_no_bag_of_a_pattern(tmp_path: Path) -> None:
    whole, half = bags(tmp_path, "run/run.mcap", ".other.x1y2.part/other/other.mcap")
    assert find_bags([tmp_path / "*"]) == [whole]
    assert find_bags([tmp_path / "**" / "*.mcap"]) == [whole]
    assert find_bags([tmp_path / ".other.*"]) == [half]
