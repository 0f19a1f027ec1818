"""What is written appears complete or not at all, and harms nothing that was there."""

from pathlib import Path

import pytest

from belt_ros.appearing import appearing


def test_a_file_takes_the_place_of_an_earlier_one_once_it_is_complete(tmp_path: Path) -> None:
    place = tmp_path / "new" / "page.html"
    for text in ("one", "two"):
        with appearing(place) as part:
            part.write_text(text)
            assert part.name == place.name
            assert not place.exists() or place.read_text() == "one"
    assert place.read_text() == "two"
    with pytest.raises(ZeroDivisionError), appearing(place) as part:
        part.write_text(f"{1 / 0}")
    assert place.read_text() == "two"
    assert list(place.parent.iterdir()) == [place]


def test_a_directory_takes_the_place_of_an_earlier_one(tmp_path: Path) -> None:
    place = tmp_path / "results"
    for name in ("one", "two"):
        with appearing(place) as part:
            part.mkdir()
            (part / name).touch()
    assert [path.name for path in tmp_path.rglob("*")] == ["results", "two"]


def test_a_file_never_takes_the_place_of_a_directory(tmp_path: Path) -> None:
    place = tmp_path / "page.html"
    place.mkdir()
    (place / "kept").touch()
    with pytest.raises(OSError, match="directory"), appearing(place) as part:
        part.touch()
    assert [path.name for path in tmp_path.rglob("*")] == ["page.html", "kept"]
