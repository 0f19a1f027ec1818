"""Bags of the rig: readable by others, the same every time, and the committed one is current."""

import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from belt_ros.message_types import belt_typestore, message_texts
from belt_ros.replay.bags import find_bags
from belt_ros.rig.bag import write_bag
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.rig.simulate import simulate
from belt_ros.settings import DriveSettings

COMMITTED = Path(__file__).resolve().parents[1] / "data" / "rig_bag"


@pytest.fixture
def made(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.syspath_prepend(str(root / "tools"))
    import make_rig_bag  # noqa: PLC0415

    path = tmp_path / "rig_bag"
    make_rig_bag.make_bag(path)
    sys.modules.pop("make_rig_bag")
    return path


def content(path: Path) -> dict[str, list[Any]]:
    """Decoded messages by topic, by the types that the bag itself carries."""
    topics: dict[str, list[Any]] = {}
    with AnyReader([path]) as reader:
        for connection, stamp, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == stamp
            topics.setdefault(connection.topic, []).append(message)
    return topics


def short_run(settings: DriveSettings, seed: int = 3) -> Any:
    script = {"duration": 0.5, "speed": 100.0, "load": 30.0, "seed": seed}
    return simulate(settings, scenario_from_mapping(script, settings), 10**18)


def test_bag_holds_joint_states_and_truth(tmp_path: Path, settings: DriveSettings) -> None:
    path = tmp_path / "bag"
    count = write_bag(path, "a_drive", short_run(settings), truth_every=2)

    topics = content(path)
    expected = list(short_run(settings))
    assert count == len(topics["/joint_states"]) == 51
    assert len(topics["/belt_rig/truth"]) == 26
    joints, truth = topics["/joint_states"][-1], topics["/belt_rig/truth"][-1]
    assert joints.name == ["driver_pulley_joint", "driven_pulley_joint"]
    assert tuple(joints.velocity) == expected[-1].joints.velocities
    assert truth.drive_name == "a_drive"
    assert truth.margin == expected[-1].truth.margin
    assert truth.margin_stddev == 0.0
    assert truth.gross_slip_probability == 0.0


def test_bag_holds_what_faults_leave_when_it_comes(tmp_path: Path, settings: DriveSettings) -> None:
    script = {
        "duration": 0.5,
        "speed": 100.0,
        "faults": [
            {"at": 0.1, "kind": "dropout", "duration": 0.1},
            {"at": 0.3, "kind": "time_jump", "value": -5.0},
        ],
    }
    path = tmp_path / "bag"
    samples = simulate(settings, scenario_from_mapping(script, settings), 10**18)
    assert write_bag(path, "a_drive", samples) == 41

    moved = []
    with AnyReader([path]) as reader:
        for connection, time, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            if stamp != time:
                assert connection.topic == "/joint_states"
                assert stamp == time - 5 * 10**9
                moved.append((time - 10**18) // 10**6)
    assert moved == list(range(300, 501, 10))


def test_bag_is_plain_mcap_with_its_definitions(tmp_path: Path, settings: DriveSettings) -> None:
    path = tmp_path / "bag"
    write_bag(path, "a_drive", short_run(settings))

    with (path / "bag.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert {channel.topic for channel in summary.channels.values()} == {
        "/joint_states",
        "/belt_rig/truth",
    }
    schemas = {schema.name: schema.data.decode() for schema in summary.schemas.values()}
    assert "float64 margin_stddev" in schemas["belt_msgs/msg/BeltState"]
    assert {index.compression for index in summary.chunk_indexes} == {"zstd"}
    assert "version: 8" in (path / "metadata.yaml").read_text()


def test_same_seed_gives_the_same_bytes(tmp_path: Path, settings: DriveSettings) -> None:
    for name, seed in (("one", 3), ("two", 3), ("other", 4)):
        write_bag(tmp_path / name / "bag", "a_drive", short_run(settings, seed))

    one, two, other = (
        (tmp_path / name / "bag" / "bag.mcap").read_bytes() for name in ("one", "two", "other")
    )
    assert one == two
    assert one != other


def test_existing_bag_is_not_overwritten(tmp_path: Path, settings: DriveSettings) -> None:
    with pytest.raises(FileExistsError, match="exists already"):
        write_bag(tmp_path, "a_drive", short_run(settings))
    with pytest.raises(ValueError, match="truth_every is 0"):
        write_bag(tmp_path / "bag", "a_drive", [], truth_every=0)


def broken_off(samples: Iterable[Any], act: Callable[[], object]) -> Iterator[Any]:
    """What comes of a run in which something happens halfway."""
    for number, sample in enumerate(samples):
        if number == 20:
            act()
        yield sample


def interrupt() -> None:
    raise KeyboardInterrupt


def kill() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_run_that_is_interrupted_leaves_nothing(tmp_path: Path, settings: DriveSettings) -> None:
    path = tmp_path / "bag"
    with pytest.raises(KeyboardInterrupt):
        write_bag(path, "a_drive", broken_off(short_run(settings), interrupt))
    assert list(tmp_path.iterdir()) == []
    assert write_bag(path, "a_drive", short_run(settings)) == 51


def test_a_run_that_is_killed_leaves_nothing_that_looks_like_its_bag(
    tmp_path: Path, settings: DriveSettings
) -> None:
    path = tmp_path / "bag"
    samples = broken_off(short_run(settings), kill)
    killed = multiprocessing.get_context("fork").Process(
        target=write_bag, args=(path, "a_drive", samples)
    )
    killed.start()
    killed.join(60.0)
    assert killed.exitcode == -signal.SIGKILL
    assert not path.exists()
    assert write_bag(path, "a_drive", short_run(settings)) == 51
    assert find_bags([tmp_path]) == [path]


def test_what_has_come_to_its_place_meanwhile_stays(
    tmp_path: Path, settings: DriveSettings
) -> None:
    path = tmp_path / "bag"

    def come() -> None:
        path.mkdir()
        (path / "kept").touch()

    with pytest.raises(FileExistsError, match="exists already"):
        write_bag(path, "a_drive", broken_off(short_run(settings), come))
    assert [entry.name for entry in tmp_path.rglob("*")] == ["bag", "kept"]


def test_a_bag_is_for_all_to_read_whom_the_umask_lets(
    tmp_path: Path, settings: DriveSettings
) -> None:
    before = os.umask(0o027)
    try:
        write_bag(tmp_path / "bag", "a_drive", short_run(settings))
    finally:
        os.umask(before)
    assert (tmp_path / "bag").stat().st_mode & 0o777 == 0o750
    assert (tmp_path / "bag" / "bag.mcap").stat().st_mode & 0o777 == 0o640


def test_committed_bag_is_what_the_script_makes(made: Path) -> None:
    committed, fresh = content(COMMITTED), content(made)

    assert committed.keys() == fresh.keys()
    for topic, messages in committed.items():
        assert len(messages) == len(fresh[topic])
    for old, new in zip(committed["/joint_states"], fresh["/joint_states"], strict=True):
        assert old.header.stamp.sec == new.header.stamp.sec
        assert old.header.stamp.nanosec == new.header.stamp.nanosec
        np.testing.assert_allclose(old.velocity, new.velocity, atol=2.1e-3)
        np.testing.assert_allclose(old.effort, new.effort, atol=1e-4)
        np.testing.assert_allclose(old.position, new.position, atol=1e-3)
    for old, new in zip(committed["/belt_rig/truth"], fresh["/belt_rig/truth"], strict=True):
        for name in ("slip", "margin", "tight_tension", "friction_stiffness", "ratio_bias"):
            assert getattr(old, name) == pytest.approx(getattr(new, name), rel=1e-5, abs=1e-6)


def test_committed_bag_is_small_and_slips(root: Path) -> None:
    assert sum(file.stat().st_size for file in COMMITTED.iterdir()) < 150_000
    phases = {message.phase for message in content(COMMITTED)["/belt_rig/truth"]}
    assert {1, 2, 5} <= phases


def test_message_definitions_are_those_of_the_interface_package(root: Path) -> None:
    texts = message_texts()
    for path in (root / "msg_defs" / "msg").glob("*.msg"):
        assert texts[f"belt_msgs/msg/{path.stem}"] == path.read_text()
        assert f"belt_msgs/msg/{path.stem}" in belt_typestore().types
