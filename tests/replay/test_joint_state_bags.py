"""Bags of joint states, of whatever storage and in whatever state, and what they cannot give."""

import dataclasses
import math
import shutil
import sqlite3
from contextlib import suppress
from pathlib import Path

import pytest
from bags import JOINTS, START_NS, Sample, cdr, steady_run, write_bag, write_chunked_mcap
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from reading import expected, measured, read
from rosbags.rosbag2 import StoragePlugin

from belt_ros.estimation import Joint, Measurement, Rejection
from belt_ros.replay import BagError
from belt_ros.replay.drive_bag import DriveBag

SHARED_BAG = Path(__file__).parents[3] / "shared" / "data" / "exudyn_belt_drive"


@pytest.mark.parametrize("plugin", list(StoragePlugin), ids=lambda plugin: plugin.name)
def test_reads_every_storage_and_its_bare_file(settings, make_bag, plugin):
    samples = steady_run(20)
    bag = make_bag(samples, plugin=plugin)
    (storage,) = (file for file in bag.iterdir() if file.suffix != ".yaml")
    assert read(bag, settings) == expected(samples)
    assert read(storage, settings) == expected(samples)


def test_messages_come_in_the_order_of_their_log_time(settings, make_bag):
    samples = steady_run(10)
    assert read(make_bag(samples[::-1]), settings) == expected(samples)


def test_signs_and_gear_ratios_are_those_of_the_joints(settings, make_bag):
    bag = make_bag(steady_run(1))
    driven = Joint("driven_pulley_joint", gear_ratio=2.0, sign=-1.0)
    (content,) = measured(read(bag, dataclasses.replace(settings, driven=driven)))
    (plain,) = steady_run(1)
    assert content.driven_speed == -plain.velocity[1] / 2.0
    assert content.driven_torque == -plain.effort[1] * 2.0


def test_torques_may_be_missing(settings, make_bag):
    bag = make_bag([Sample(START_NS, START_NS, (1.0, 1.0), ())])
    (content,) = measured(read(bag, settings))
    assert math.isnan(content.driver_torque)
    assert math.isnan(content.driven_torque)


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (Sample(START_NS, START_NS, (1.0,), (1.0, 1.0)), Rejection.MALFORMED),
        (Sample(START_NS, START_NS, (), (1.0, 1.0)), Rejection.INCOMPLETE),
        (Sample(START_NS, -1, (1.0, 1.0), (1.0, 1.0)), Rejection.MALFORMED),
        (b"", Rejection.MALFORMED),
        (b"\x00\x01\x00\x00", Rejection.MALFORMED),
        (b"\x00\x01\x00\x00" + b"\xff" * 40, Rejection.MALFORMED),
    ],
)
def test_a_message_that_says_nothing_says_why(settings, make_bag, message, reason):
    assert [sample.content for sample in read(make_bag([message]), settings)] == [reason]


def test_topic_is_found_by_the_joints_it_carries(settings, tmp_path):
    bag = tmp_path / "bag"
    write_bag(bag, {"/arm/joint_states": steady_run(2)}, joints=("shoulder", "elbow"))
    other = write_chunked_mcap(tmp_path / "other.mcap", steady_run(3))
    shutil.move(other, bag / "bag_1.mcap")
    (bag / "metadata.yaml").unlink()
    with DriveBag(bag, settings) as it:
        assert it.topics == ("/joint_states",)
        assert it.joints_seen == list(JOINTS)
        assert len(measured(it.samples())) == 3


def in_turns(joints: tuple[str, ...]) -> list[Sample | bytes]:
    """Five messages of an arm, then by turns those of the arm and of three samples of the drive."""
    arm, drive = steady_run(8), steady_run(3, seed=1)
    turns = [cdr(sample, ("shoulder", "elbow")) for sample in arm]
    for place, sample in zip((5, 7, 9), drive, strict=True):
        turns.insert(place, cdr(sample, joints))
    return turns


def test_a_drive_is_found_where_others_speak_first_on_its_topic(settings, tmp_path):
    other = [cdr(sample, ("wheel", "gripper")) for sample in steady_run(5)]
    bag = write_bag(tmp_path / "bag", {"/a": other, "/b": in_turns(JOINTS)})
    with DriveBag(bag, settings) as it:
        assert it.topics == ("/b",)
        assert len(measured(it.samples())) == 3


def test_joints_are_found_by_the_end_of_their_names_where_others_speak_first(settings, tmp_path):
    there = tuple(f"line/{name}" for name in JOINTS)
    bag = write_bag(tmp_path / "bag", {"/joint_states": in_turns(there)})
    with DriveBag(bag, settings) as it:
        assert len(measured(it.samples())) == 3
        assert it.joints_seen == ["shoulder", "elbow", *there]


def test_a_joint_that_two_senders_could_mean_is_taken_for_neither(settings, tmp_path):
    both = [in_turns(tuple(f"{side}_{name}" for name in JOINTS)) for side in ("left", "right")]
    bag = write_bag(tmp_path / "bag", {"/joint_states": [*both[0], *both[1]]})
    with DriveBag(bag, settings) as it:
        assert it.note == ""
        assert measured(it.samples()) == []


def test_several_candidates_are_listed_and_one_can_be_chosen(settings, tmp_path):
    bag = write_bag(tmp_path / "bag", {"/a/joints": steady_run(2), "/b/joints": steady_run(3)})
    with pytest.raises(BagError, match=r"2 topics .* --topic: /a/joints, /b/joints"):
        read(bag, settings)
    assert len(read(bag, settings, topic="/b/joints")) == 3


def test_a_wrong_topic_names_the_right_ones(settings, make_bag):
    with pytest.raises(BagError, match=r"no joint states on /joints\. .*--topic: /joint_states"):
        read(make_bag(steady_run(1)), settings, topic="/joints")


def test_a_bag_without_joint_states_says_what_it_holds(settings, tmp_path):
    bag = write_bag(tmp_path / "bag", {})
    with pytest.raises(BagError, match=r"no topic of type sensor_msgs/JointState.*no topics"):
        read(bag, settings)


def test_types_of_ros_2_serve_where_the_bag_has_none(settings, make_bag):
    samples = steady_run(3)
    bag = make_bag(samples, plugin=StoragePlugin.SQLITE3)
    with sqlite3.connect(bag / "bag.db3") as database:
        database.execute("DELETE FROM message_definitions")
    database.close()
    assert read(bag, settings) == expected(samples)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("notes.txt", b"no bag"),
        ("empty.mcap", b""),
        ("text.mcap", b"no bag"),
        ("text.db3", b"no bag"),
        ("folder", None),
    ],
)
def test_what_is_no_bag_is_named(settings, tmp_path, name, content):
    path = tmp_path / name
    path.mkdir() if content is None else path.write_bytes(content)
    with pytest.raises(BagError, match=f"{name}.*Give a rosbag2 directory"):
        read(path, settings)


def test_a_missing_bag_is_named(settings, tmp_path):
    with pytest.raises(BagError, match="gone: no such file"):
        read(tmp_path / "gone", settings)


def test_broken_metadata_does_not_hinder(settings, make_bag):
    samples = steady_run(5)
    bag = make_bag(samples)
    (bag / "metadata.yaml").write_text("rosbag2_bagfile_information: [")
    with DriveBag(bag, settings) as it:
        assert list(it.samples()) == expected(samples)
        assert "Read file by file" in it.note


@pytest.fixture(scope="module")
def whole_file(tmp_path_factory):
    samples = steady_run(30)
    return write_chunked_mcap(tmp_path_factory.mktemp("whole") / "bag.mcap", samples), samples


def test_a_definition_that_lacks_a_part_is_a_clear_error(settings, whole_file, tmp_path):
    whole, _ = whole_file
    content = whole.read_bytes()
    assert b"MSG: std_msgs/Header" in content
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(content.replace(b"MSG: std_msgs/Header", b"MSG: std_msgs/Haeder"))
    with pytest.raises(BagError, match="definition of sensor_msgs/msg/JointState is broken"):
        read(broken, settings)


@hypothesis_settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_damaged_bytes_give_measurements_or_a_clear_error(
    settings, whole_file, tmp_path_factory, data
):
    whole, _ = whole_file
    content = bytearray(whole.read_bytes())
    for place in data.draw(st.lists(st.integers(0, len(content) - 1), min_size=1, max_size=8)):
        content[place] = data.draw(st.integers(0, 255))
    broken = tmp_path_factory.getbasetemp() / "broken.mcap"
    broken.write_bytes(content)
    with suppress(BagError):
        samples = read(broken, settings)
        assert all(isinstance(sample.content, Measurement | Rejection) for sample in samples)


@pytest.mark.skipif(not SHARED_BAG.is_dir(), reason="the Exudyn bag is not beside this checkout")
def test_reads_a_bag_of_another_origin(settings):
    samples = read(SHARED_BAG, settings)
    assert len(samples) == 2451
    assert len(measured(samples)) == 2451
    assert samples[-1].content.driven_speed == pytest.approx(11.3406, abs=1e-3)
