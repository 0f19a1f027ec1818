import dataclasses
import json
import math
import os
import stat
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.estimation import Drift, Prior
from belt_ros.estimation.condensing import MEMBERS, condensed
from belt_ros.estimation.fingerprint import fingerprint
from belt_ros.estimation.gaussian_sum import Component, mixture_moments, normalised
from belt_ros.estimation.installed import Installed
from belt_ros.estimation.load import Activity
from belt_ros.estimation.memory import (
    REMEMBERED,
    STANDING,
    Learned,
    MemoryRefusedError,
    aged,
    forgetting,
    learned_from,
    restore,
)
from belt_ros.estimation.memory_file import MemoryFileError, load, memory_path, save
from belt_ros.estimation.process import drift_processes, drift_wander, prior_state
from belt_ros.estimation.state import STATES, Index
from belt_ros.mechanics import Belt, BeltDrive, Pulley
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.drive import Tensioning

DRIVE = BeltDrive(
    Belt(80068.0, 0.1036), Pulley(0.08, 3.0, 0.5, 1e8), Pulley(0.06, 2.9, 0.6, 2e8), 0.5
)
PRIOR, DRIFT = Prior(), Drift()
MEAN, STDDEV = prior_state(PRIOR, DRIVE)
HOUR, DAY = 3600.0, 86400.0
INSTALLED = Installed(400.0, math.log(400.0), math.log(0.5))
PLACES = list(REMEMBERED)
DATE = 1.75e9
exactly = settings(derandomize=True, deadline=None, max_examples=60)


class Members(list[Component]):
    def __repr__(self) -> str:
        return f"{len(self)} members"


@st.composite
def members(draw: st.DrawFn, most: int = 5) -> "Members":
    """Members of a filter in the middle of its work, all states going with all others."""
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    out = Members()
    for _ in range(draw(st.integers(1, most))):
        factor = rng.standard_normal((STATES, STATES)) * rng.uniform(0.02, 0.4)
        out.append(
            Component(
                rng.uniform(-5.0, 0.0),
                MEAN + STDDEV * rng.standard_normal(STATES),
                np.outer(STDDEV, STDDEV) * (factor @ factor.T),
                bool(rng.random() < 0.2),
            )
        )
    return out


def moments(components: list[Component]) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance, in units of the prior's deviations."""
    mean, covariance = mixture_moments(
        normalised(np.array([c.log_weight for c in components])),
        np.stack([c.mean for c in components]),
        np.stack([c.covariance for c in components]),
    )
    remembered = len(mean) == len(PLACES)
    centre, unit = (MEAN[PLACES], STDDEV[PLACES]) if remembered else (MEAN, STDDEV)
    return (mean - centre) / unit, covariance / np.outer(unit, unit)


def assert_same(one: list[Component], other: list[Component], tolerance: float = 1e-9) -> None:
    for a, b in zip(moments(one), moments(other), strict=True):
        np.testing.assert_allclose(a, b, rtol=tolerance, atol=tolerance)


def learn(components: list[Component]) -> Learned:
    return learned_from(components, "conveyor", DRIVE, DATE, INSTALLED)


def one(tension: float = 500.0, spread: float = 0.05) -> list[Component]:
    mean, covariance = MEAN.copy(), np.diag((0.1 * STDDEV) ** 2)
    mean[Index.LOG_TENSION] = math.log(tension)
    covariance[Index.LOG_TENSION, Index.LOG_TENSION] = spread**2
    return [Component(0.0, mean, covariance)]


# What was learned


@exactly
@given(members())
def test_what_was_learned_has_the_moments_of_the_belief_it_is_from(components) -> None:
    mean, covariance = moments(components)
    learned_mean, learned_covariance = moments(learn(components).components)
    np.testing.assert_allclose(learned_mean, mean[PLACES], rtol=1e-9, atol=1e-9)
    expected = covariance[np.ix_(PLACES, PLACES)]
    np.testing.assert_allclose(learned_covariance, expected, rtol=1e-9, atol=1e-9)


def test_too_many_members_are_merged_and_mean_and_covariance_stay() -> None:
    rng = np.random.default_rng(1)
    many = [
        Component(-0.01 * k, MEAN + STDDEV * 3.0 * rng.standard_normal(STATES), c.covariance)
        for k, c in enumerate(one(spread=0.01) * 90)
    ]
    learned = learn(many)
    assert len(learned.weights) == MEMBERS
    mean, covariance = moments(many)
    learned_mean, learned_covariance = moments(learned.components)
    np.testing.assert_allclose(learned_mean, mean[PLACES], atol=1e-9)
    np.testing.assert_allclose(learned_covariance, covariance[np.ix_(PLACES, PLACES)], atol=1e-9)


def test_what_was_learned_cannot_be_changed() -> None:
    learned = learn(one())
    with pytest.raises(ValueError, match="read-only"):
        learned.means[0, 0] = 0.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        learned.date = 0.0


@pytest.mark.parametrize("broken", [math.nan, math.inf, 1e9])
def test_a_belief_that_has_come_apart_is_not_remembered(broken) -> None:
    for place in ("mean", "covariance", "log_weight"):
        component = one()[0]
        if place == "mean":
            component.mean[Index.LOG_STIFFNESS] = broken
        elif place == "covariance":
            component.covariance[Index.LOG_STIFFNESS, Index.LOG_STIFFNESS] = broken
        elif math.isfinite(broken):
            continue
        else:
            component.log_weight = broken
        with pytest.raises(MemoryRefusedError), np.errstate(invalid="ignore"):
            learn([component])


# Ageing


@exactly
@given(members(), st.floats(0.0, 30.0 * DAY), st.floats(0.0, 30.0 * DAY))
def test_ageing_composes(components, first, second) -> None:
    law = forgetting(MEAN, STDDEV, DRIFT)
    learned = learn(components).components
    assert_same(aged(aged(learned, law, first), law, second), aged(learned, law, first + second))


@exactly
@given(members(), st.floats(0.0, 1e6))
def test_without_a_change_of_tension_ageing_is_the_filter_s_own(components, elapsed) -> None:
    """All but the ratio bias, which the filter holds for constant."""
    law = forgetting(MEAN, STDDEV, DRIFT, pace=1.0)._replace(changes=0.0)
    constants = drive_constants(DRIVE)
    wander = drift_wander(DRIFT, STDDEV, 400.0)
    process, _ = drift_processes(
        wander, constants, Activity(np.ones(2), np.ones(2)), (1.0, 0.0, 0.0), elapsed, elapsed
    )
    belt = PLACES[:3]
    learned = learn(components).components
    expected = [
        Component(
            c.log_weight,
            MEAN[belt] + process.memory[belt] * (c.mean[:3] - MEAN[belt]),
            np.outer(process.memory[belt], process.memory[belt]) * c.covariance[:3, :3]
            + process.covariance_before[np.ix_(belt, belt)],
        )
        for c in learned
    ]
    kept = [c for c in aged(learned, law, elapsed) if c.log_weight > -math.inf]
    for mine, its in zip(kept, expected, strict=True):
        np.testing.assert_allclose(mine.mean[:3], its.mean, rtol=1e-12)
        np.testing.assert_allclose(mine.covariance[:3, :3], its.covariance, rtol=1e-9, atol=1e-15)


@exactly
@given(members())
def test_restored_at_once_the_belief_is_what_it_was(components) -> None:
    restored = restore(learn(components), DRIVE, MEAN, STDDEV, DRIFT, 0.0)
    assert restored.note == ""
    mean, covariance = moments(components)
    restored_mean, restored_covariance = moments(restored.components)
    np.testing.assert_allclose(restored_mean[PLACES], mean[PLACES], rtol=1e-9, atol=1e-9)
    places = np.ix_(PLACES, PLACES)
    np.testing.assert_allclose(
        restored_covariance[places], covariance[places], rtol=1e-9, atol=1e-9
    )
    others = [place for place in Index if place not in PLACES]
    np.testing.assert_allclose(restored_mean[others], 0.0, atol=1e-12)
    np.testing.assert_allclose(restored_covariance[others], np.eye(STATES)[others], atol=1e-12)


@exactly
@given(members(), st.sampled_from([math.inf, 1e300, 1e4 * 365.0 * DAY]))
def test_restored_after_very_long_the_belief_is_the_prior(components, elapsed) -> None:
    restored = restore(learn(components), DRIVE, MEAN, STDDEV, DRIFT, elapsed)
    mean, covariance = moments(restored.components)
    np.testing.assert_allclose(mean, 0.0, atol=1e-9)
    np.testing.assert_allclose(covariance, np.eye(STATES), atol=1e-9)
    assert "years old" in restored.note


def test_the_longer_the_pause_the_likelier_the_tension_was_changed() -> None:
    """And only the tension: what is known of kf does not depend on it."""
    law = forgetting(MEAN, STDDEV, DRIFT)
    for elapsed in (HOUR, DAY, 7.0 * DAY):
        kept, changed = aged(learn(one()).components, law, elapsed)
        share = 1.0 - math.exp(-STANDING * DRIFT.tension_changes * elapsed)
        assert math.exp(changed.log_weight) == pytest.approx(share)
        assert math.exp(kept.log_weight) == pytest.approx(1.0 - share)
        assert changed.mean[0] == MEAN[Index.LOG_TENSION]
        assert changed.covariance[0, 0] == pytest.approx(STDDEV[Index.LOG_TENSION] ** 2)
        assert np.all(changed.covariance[0, 1:] == 0.0)
        assert np.array_equal(changed.mean[1:], kept.mean[1:])
        assert np.array_equal(changed.covariance[1:, 1:], kept.covariance[1:, 1:])


@pytest.mark.parametrize("elapsed", [-1.0, -1e9, -math.inf, math.nan])
def test_a_clock_that_was_set_back_ages_nothing_and_is_noted(elapsed) -> None:
    learned = learn(one())
    restored = restore(learned, DRIVE, MEAN, STDDEV, DRIFT, elapsed)
    assert "clock was set back" in restored.note
    fresh = restore(learned, DRIVE, MEAN, STDDEV, DRIFT, 0.0)
    assert_same(restored.components, fresh.components, 1e-15)


@exactly
@given(members(most=50), st.floats(0.0, 100.0 * DAY))
def test_what_is_restored_is_proper_and_bounded(components, elapsed) -> None:
    restored = restore(learn(components), DRIVE, MEAN, STDDEV, DRIFT, elapsed).components
    assert 1 <= len(restored) <= MEMBERS
    for component in restored:
        assert not component.changing
        unit = np.sqrt(np.diag(component.covariance))
        correlation = component.covariance / np.outer(unit, unit)
        assert np.array_equal(component.covariance, component.covariance.T)
        assert np.min(np.linalg.eigvalsh(correlation)) >= -1e-9


def test_what_is_restored_owns_its_numbers() -> None:
    learned = learn(one())
    restored = restore(learned, DRIVE, MEAN, STDDEV, DRIFT, 0.0).components[0]
    before = learned.means.copy()
    restored.mean += 1.0
    restored.covariance *= 2.0
    assert np.array_equal(learned.means, before)
    assert STDDEV[0] == 1.0


@pytest.mark.parametrize(
    ("other", "phrase"),
    [
        (dataclasses.replace(DRIVE, belt=Belt(7e4, 0.1036)), "axial_stiffness was 80068, is 70000"),
        (
            dataclasses.replace(DRIVE, driver=Pulley(0.07, 2.9, 0.6, 2e8)),
            "driver_radius was 0.06, is 0.07",
        ),
        (
            dataclasses.replace(DRIVE, tensioning=Tensioning.FIXED_CENTRES),
            "tensioning was constant_mean, is fixed_centres",
        ),
    ],
)
def test_the_memory_of_another_drive_is_refused_and_says_what_differs(other, phrase) -> None:
    with pytest.raises(MemoryRefusedError, match=phrase):
        restore(learn(one()), other, MEAN, STDDEV, DRIFT, 0.0)


def test_a_corrected_inertia_or_another_guess_of_friction_is_no_other_drive() -> None:
    driven = dataclasses.replace(DRIVE.driven, inertia=0.5, friction_coefficient=0.25)
    driver = dataclasses.replace(DRIVE.driver, friction_coefficient=0.3)
    other = dataclasses.replace(DRIVE, driven=driven, driver=driver)
    assert fingerprint(DRIVE).differences(fingerprint(other)) == []


def test_condensing_few_that_differ_changes_nothing() -> None:
    apart = one(300.0) + one(600.0)
    kept = condensed(apart, (Index.LOG_TENSION, Index.LOG_STIFFNESS))
    for before, after in zip(apart, kept, strict=True):
        assert after.log_weight == before.log_weight
        assert np.array_equal(after.mean, before.mean)
        assert np.array_equal(after.covariance, before.covariance)


# The file


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


@pytest.mark.parametrize("certain", [1e-20, 1e-40, 0.0])
def test_what_is_known_beyond_rounding_is_remembered_as_well(certain) -> None:
    component = one()[0]
    place = Index.LOG_TENSION
    component.covariance[place, :] = component.covariance[:, place] = 0.0
    component.covariance[place, place] = certain
    learned = learn([component, *one()])
    assert np.all(learned.covariances[:, 0, 0] > 0.0)
    np.testing.assert_array_equal(learned.components[0].mean, component.mean[PLACES])


def test_a_member_beyond_reason_does_not_spoil_the_others() -> None:
    sound, wild = one()[0], one()[0]
    wild.mean[Index.LOG_STIFFNESS] = 1e6
    learned = learn([sound, wild])
    assert len(learned.weights) == 1
    np.testing.assert_array_equal(learned.means[0], sound.mean[PLACES])


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


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    path = memory_path(tmp_path / "new", "conveyor")
    save(learn(one()), path)
    return path


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
