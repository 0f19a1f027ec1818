"""Whatever stands in a memory's file, it is read as a memory or refused with the reason."""

import json
import math
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from memories import INSTALLED, exactly, learn, one

from belt_ros.estimation.memory_file import MemoryFileError, load, save


def assert_refused(path: Path, reason: str = "", name: str = "conveyor") -> None:
    with pytest.raises(MemoryFileError, match=reason or None) as caught:
        load(path, name)
    assert "\n" not in str(caught.value)
    assert path.name in str(caught.value)


def altered(path: Path, **entries: object) -> Path:
    path.write_text(json.dumps(json.loads(path.read_text()) | entries))
    return path


@pytest.mark.parametrize(
    ("entries", "reason"),
    [
        ({"version": 3}, "newer"),
        ({"version": "1"}, "unknown"),
        ({"format": "other"}, "not written by belt_ros"),
        ({"more": 1}, "entries"),
        ({"states": ["log_tension"]}, "entries"),
        ({"name": 3}, "name is no str"),
        ({"name": "a\nb"}, "printable"),
        ({"name": "\ud800"}, "printable"),
        ({"date": None}, "date is no float"),
        ({"date": True}, "date is no float"),
        ({"date": math.nan}, "NaN"),
        ({"drive": {}}, "drive"),
        ({"installed": {}}, "installation"),
        ({"installed": {**INSTALLED._asdict(), "tension": "400"}}, "tension is no float"),
        ({"installed": {**INSTALLED._asdict(), "tension": -400.0}}, "installed as"),
        ({"installed": {**INSTALLED._asdict(), "log_tension": 1e3}}, "installed as"),
        ({"weights": [], "means": [], "covariances": []}, "0 members"),
        ({"weights": [0.5]}, "sum to one"),
        ({"weights": [[1.0]]}, "weights is no float"),
        ({"weights": [0.5, 0.5]}, "shape"),
        ({"means": [[0.0, 0.0, 0.0]]}, "shape"),
        ({"means": [["1", 0.0, 0.0, 0.0]]}, "means is no float"),
        ({"means": [[1e3, 0.0, 0.0, 0.0]]}, "means"),
        ({"covariances": [np.zeros((4, 4)).tolist()]}, "variances"),
        ({"covariances": [(np.eye(4) + np.eye(4, k=1)).tolist()]}, "symmetric"),
        ({"covariances": [(2.0 - np.eye(4)).tolist()]}, "semi-definite"),
        ({"covariances": [(1.5 * np.eye(4) - 0.5).tolist()]}, "semi-definite"),
    ],
)
def test_a_file_with_a_wrong_entry_is_refused_with_the_reason(saved, entries, reason) -> None:
    assert_refused(altered(saved, **entries), reason)


def test_a_file_from_before_installations_were_kept_can_be_read(saved) -> None:
    document = json.loads(saved.read_text()) | {"version": 1}
    del document["installed"]
    saved.write_text(json.dumps(document))
    loaded = load(saved, "conveyor")
    assert loaded is not None
    assert loaded.installed is None


def test_a_number_beyond_all_bounds_is_refused(saved) -> None:
    content = saved.read_text()
    for number in ("1e999", "9" * 5000):
        saved.write_text(content.replace("1750000000.0", number))
        assert_refused(saved, "date is inf")


def test_the_memory_of_a_drive_of_another_name_is_refused(saved) -> None:
    assert_refused(saved, "of 'conveyor', not of 'lift'", "lift")


def test_what_is_no_file_of_sensible_size_is_refused(saved) -> None:
    assert_refused(saved.parent, "regular file")
    pipe = saved.parent / "pipe"
    os.mkfifo(pipe)
    assert_refused(pipe, "regular file")
    saved.write_bytes(b" " * 1_000_001)
    assert_refused(saved, "larger than")
    saved.write_bytes(b"[" * 900_000)
    assert_refused(saved)


@exactly
@given(st.binary(max_size=300), st.integers(0, 3000))
def test_random_bytes_and_truncations_are_refused(tmp_path_factory, noise, length) -> None:
    path = tmp_path_factory.mktemp("memory") / "x.json"
    save(learn(one()), path)
    whole = path.read_bytes()
    for content in (noise, whole[: length % len(whole)], whole[:length] + noise + b"\xff"):
        path.write_bytes(content)
        assert_refused(path)


@settings(derandomize=True, deadline=None, max_examples=200)
@given(st.data())
def test_no_change_of_a_file_gives_anything_but_a_memory_or_the_error(
    tmp_path_factory, data
) -> None:
    path = tmp_path_factory.mktemp("memory") / "x.json"
    save(learn(one(300.0) + one(600.0)), path)
    document = json.loads(path.read_text())
    value = st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
        lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner),
        max_leaves=5,
    )
    for _ in range(data.draw(st.integers(1, 3))):
        place: object = document
        while True:
            keys = list(place) if isinstance(place, dict) else list(range(len(place)))
            key = data.draw(st.sampled_from(keys))
            inner = place[key]
            if isinstance(inner, dict | list) and inner and data.draw(st.integers(0, 4)):
                place = inner
                continue
            place[key] = data.draw(value)
            break
    path.write_text(json.dumps(document))
    try:
        loaded = load(path, "conveyor")
    except MemoryFileError:
        return
    assert loaded is not None
    assert loaded.name == "conveyor"
    assert np.sum(loaded.weights) == pytest.approx(1.0)
