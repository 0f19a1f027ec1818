"""Bags of every kind of input give the measurements that the live node makes of them."""

import dataclasses
import sqlite3
from pathlib import Path

import pytest
from bags import START_NS, cdr, chunk_ends, steady_run, write_bag, write_chunked_mcap
from reading import measured, read
from recordings import TYPES, float64, numbers, pulleys, record
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from belt_ros.drive_inputs import InputSettings, load_inputs
from belt_ros.node_tables import InputKind
from belt_ros.parameter_table import SettingsError
from belt_ros.replay import BagError, replay
from belt_ros.replay.drive_bag import DriveBag

PULLEYS = InputSettings(InputKind.PULLEY_STATE)
NUMBERS = InputSettings(InputKind.FLOAT64)


def test_pulley_states_are_joined_by_their_stamps(settings, tmp_path):
    bag = record(tmp_path / "bag", pulleys(30))
    rows = measured(read(bag, settings, PULLEYS))
    assert [row.stamp_ns for row in rows] == [START_NS + k * 10_000_000 for k in range(30)]
    assert {row.speeds for row in rows} == {(120.0, 119.72)}
    assert {row.loads for row in rows} == {(800.0, 800.0, 450.0)}


def test_plain_numbers_are_stamped_with_their_log_time(settings, tmp_path):
    bag = record(tmp_path / "bag", numbers(20))
    rows = measured(read(bag, settings, NUMBERS))
    assert [row.stamp_ns for row in rows] == [START_NS + k * 10_000_000 for k in range(20)]
    assert {(row.speeds, row.torques) for row in rows} == {((120.0, 119.72), (15.0, -15.0))}


def test_a_namespace_is_found_where_there_is_one_and_listed_where_there_are_two(settings, tmp_path):
    one = record(tmp_path / "one", pulleys(3, "/hall/line"))
    assert len(measured(read(one, settings, PULLEYS))) == 3
    two = record(tmp_path / "two", [*pulleys(3, "/a"), *pulleys(4, "/b")])
    with pytest.raises(BagError, match=r"2 namespaces .* Choose one with --topic: /a, /b\."):
        read(two, settings, PULLEYS)
    assert len(measured(read(two, settings, PULLEYS, topic="/b"))) == 4
    with pytest.raises(BagError, match=r"not in namespace /c\. Namespaces that have them: /a, /b"):
        read(two, settings, PULLEYS, topic="/c")


def test_a_drive_among_several_has_its_own_topics(settings, tmp_path):
    bag = record(tmp_path / "bag", [*pulleys(3, "/infeed"), *pulleys(4, "/outfeed")])
    assert len(measured(read(bag, settings, PULLEYS, prefix="outfeed/"))) == 4
    with pytest.raises(BagError, match=r"no topics lift/driver/state and lift/driven/state"):
        read(bag, settings, PULLEYS, prefix="lift/")


def test_the_only_kind_of_input_that_a_bag_has_is_read(settings, tmp_path):
    bag = record(tmp_path / "bag", pulleys(3))
    with DriveBag(bag, settings) as source:
        assert len(measured(source.samples())) == 3
        assert "input: joint_state, but the bag has only pulley_state" in source.note


def test_joints_are_found_by_the_end_of_their_names_if_only_one_is(settings, tmp_path):
    there = ("arm/driver_pulley_joint", "arm/driven_pulley_joint")
    bag = write_bag(tmp_path / "bag", {"/joint_states": steady_run(2)}, joints=there)
    with DriveBag(bag, settings) as source:
        assert len(measured(source.samples())) == 2
        assert "arm/driver_pulley_joint for driver_pulley_joint" in source.note


def test_load_cells_come_beside_joint_states(settings, tmp_path):
    joints = [(s.log_ns, "/joint_states", _joint_state(s)) for s in steady_run(10)]
    loads = [(log_ns + 1, "/driver/hub_load", float64(800.0)) for log_ns, _, _ in joints]
    bag = record(tmp_path / "bag", sorted([*joints, *loads], key=lambda each: each[0]))
    rows = measured(read(bag, settings, dataclasses.replace(InputSettings(), loads=True)))
    assert {row.driver_hub_load for row in rows if row.driver_hub_load == row.driver_hub_load} == {
        800.0
    }
    assert sum(row.driver_speed > 0.0 for row in rows) == 10


def _joint_state(sample):
    return TYPES.deserialize_cdr(cdr(sample), "sensor_msgs/msg/JointState")


def test_a_definition_without_what_is_needed_is_named(settings, tmp_path):
    bag = record(tmp_path / "bag", pulleys(3), plugin=StoragePlugin.SQLITE3)
    with sqlite3.connect(bag / "bag.db3") as database:
        database.execute(
            "UPDATE message_definitions SET encoded_message_definition = "
            "replace(encoded_message_definition, 'float64 speed', 'float64 velocity')"
        )
    database.close()
    with pytest.raises(BagError, match=r"definition of belt_msgs/msg/PulleyState has no speed"):
        read(bag, settings, PULLEYS)


@pytest.mark.parametrize("version", [8, 9])  # of Humble, of Jazzy and Kilted
@pytest.mark.parametrize(
    ("plugin", "compression"),
    [
        (StoragePlugin.MCAP, None),
        (StoragePlugin.MCAP, CompressionMode.STORAGE),
        (StoragePlugin.SQLITE3, None),
        (StoragePlugin.SQLITE3, CompressionMode.FILE),
        (StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
    ],
    ids=str,
)
def test_every_storage_compression_and_metadata_is_read(
    settings, tmp_path, version, plugin, compression
):
    bag = record(
        tmp_path / "bag", pulleys(5), plugin=plugin, version=version, compression=compression
    )
    assert len(measured(read(bag, settings, PULLEYS))) == 5


def test_a_chunk_damaged_in_the_middle_costs_only_itself(settings, tmp_path):
    samples = steady_run(60)
    path = write_chunked_mcap(tmp_path / "bag.mcap", samples)
    whole = replay(path, settings, tmp_path / "whole", smooth=False)
    content = bytearray(path.read_bytes())
    content[chunk_ends(path)[2] - 100] ^= 0xFF
    path.write_bytes(content)
    summary = replay(path, settings, tmp_path / "out", smooth=False)
    assert whole.messages == 60
    assert 30 < summary.messages < 60
    assert "unreadable and left out" in summary.note


def test_inputs_are_read_from_the_drives_own_file(tmp_path):
    file = tmp_path / "drives.yaml"
    file.write_text("drives: [a, b]\ninput_slop: 0.002\nb: {input: float64, input_loads: true}\n")
    assert load_inputs(file, "a") == InputSettings(slop=0.002)
    assert load_inputs(file, "b") == InputSettings(InputKind.FLOAT64, slop=0.002, loads=True)
    file.write_text("input_slop: 2.0\n")
    with pytest.raises(SettingsError, match=r"drives.yaml: input_slop is 2 s"):
        load_inputs(file)


def test_several_topics_are_replayed_as_one_drive(settings, tmp_path):
    bag = record(tmp_path / "bag", pulleys(40))
    summary = replay(Path(bag), settings, tmp_path / "out", inputs=PULLEYS, smooth=False)
    assert summary.accepted == summary.messages == 40
    assert summary.topic == "/driver/state, /driven/state"


def test_a_log_time_that_no_stamp_can_hold_is_turned_away(settings, tmp_path):
    logged = numbers(5)
    bag = record(tmp_path / "bag", [*logged, (2**31 * 10**9, *logged[0][1:])])
    summary = replay(Path(bag), settings, tmp_path / "out", inputs=NUMBERS, smooth=False)
    assert summary.rejected["malformed"] == 1
    assert summary.accepted >= 4
