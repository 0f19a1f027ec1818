"""Joint states are read as rosbags reads them, whatever came before and whatever is broken."""

import math
import struct

import numpy as np
import pytest
from bags import JOINT_STATE, TYPES, cdr, steady_run, write_bag
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from belt_ros.replay.contents import Contents, MessageReader
from belt_ros.replay.joint_states import JointStateReader

HOSTILE = settings(derandomize=True, deadline=None, max_examples=200)
numbers = st.floats(width=64, allow_nan=True, allow_infinity=True)


class Counting:
    """rosbags' decoder, and how often it has been asked."""

    def __init__(self):
        self.asked = 0
        self._reader = MessageReader(TYPES, JOINT_STATE)

    def read(self, data):
        self.asked += 1
        return self._reader.read(data)


def serialised(frame, names, arrays, seconds=1, nanoseconds=2, *, little_endian=True):
    stamp = TYPES.types["builtin_interfaces/msg/Time"](seconds, nanoseconds)
    message = TYPES.types[JOINT_STATE](
        TYPES.types["std_msgs/msg/Header"](stamp, frame), names, *map(np.array, arrays)
    )
    return bytes(TYPES.serialize_cdr(message, JOINT_STATE, little_endian=little_endian))


def plain(message):
    """All that anyone asks for, comparable to the last bit."""
    if message is None:
        return None
    stamp = message.header.stamp
    arrays = (message.position, message.velocity, message.effort)
    packed = [struct.pack(f"{len(values)}d", *values) for values in arrays]
    return stamp.sec, stamp.nanosec, list(message.name), packed


@st.composite
def like(draw, frame, names, lengths):
    arrays = [draw(st.lists(numbers, min_size=n, max_size=n)) for n in lengths]
    stamp = draw(st.integers(-(2**31), 2**31 - 1)), draw(st.integers(0, 2**32 - 1))
    arrays = [np.array(values, dtype=np.float64) for values in arrays]
    return serialised(frame, names, arrays, *stamp, little_endian=draw(st.booleans()))


shapes = st.tuples(
    st.text(max_size=6),
    st.lists(st.text(max_size=9), max_size=4),
    st.tuples(*[st.integers(0, 3)] * 3),
)


@HOSTILE
@given(data=st.data())
def test_any_sequence_is_read_as_rosbags_reads_it(data):
    kinds = data.draw(st.lists(shapes, min_size=1, max_size=2))
    reader, whole = JointStateReader(Counting()), Counting()
    for _ in range(6):
        message = data.draw(like(*data.draw(st.sampled_from(kinds))))
        assert plain(reader.read(message)) == plain(whole.read(message))


@HOSTILE
@given(
    place=st.integers(0, 150),
    byte=st.integers(0, 255),
    cut=st.integers(-9, 9),
)
def test_broken_bytes_are_read_as_rosbags_reads_them(place, byte, cut):
    first, second = map(cdr, steady_run(2))
    broken = bytearray(second)
    broken[place % len(broken)] = byte
    broken = bytes(broken[:cut]) if cut < 0 else bytes(broken) + bytes(cut)
    reader, whole = JointStateReader(Counting()), Counting()
    reader.read(first)
    for message in (broken, second, broken):
        assert plain(reader.read(message)) == plain(whole.read(message))


def test_messages_that_are_alike_are_decoded_once():
    whole = Counting()
    reader = JointStateReader(whole)
    for sample in steady_run(50):
        reader.read(cdr(sample))
    assert whole.asked == 1
    reader.read(cdr(sample, joints=("driver_pulley_joint", "driven_pulley_jointx")))
    assert whole.asked == 2


def test_no_layout_is_kept_of_arrays_without_end():
    whole = Counting()
    reader = JointStateReader(whole)
    endless = serialised("", ["a"], [[], [0.0] * 100_000, []])
    for _ in range(3):
        assert len(reader.read(endless).velocity) == 100_000
    assert whole.asked == 3


def test_the_reader_of_a_bag_is_quick_only_where_the_bag_means_the_same(tmp_path):
    usual = write_bag(tmp_path / "usual", {"/joint_states": steady_run(3)})
    contents = Contents(usual)
    assert isinstance(contents.reader(JOINT_STATE), JointStateReader)
    contents.close()

    text = "std_msgs/Header header\nstring[] name\nfloat64[] velocity\nfloat64[] position\n"
    header = f"{'=' * 80}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    time = f"{'=' * 80}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
    types = get_typestore(Stores.EMPTY)
    types.register(get_types_from_msg(text + header + time, JOINT_STATE))
    stamp = types.types["builtin_interfaces/msg/Time"](1, 2)
    message = types.types[JOINT_STATE](
        types.types["std_msgs/msg/Header"](stamp, ""), ["a"], np.array([3.0]), np.array([4.0])
    )
    with Writer(tmp_path / "other", version=8, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/joint_states", JOINT_STATE, typestore=types)
        writer.write(connection, 1, types.serialize_cdr(message, JOINT_STATE))
    contents = Contents(tmp_path / "other")
    reader = contents.reader(JOINT_STATE)
    ((_, _, data),) = contents.messages({"/joint_states": JOINT_STATE})
    assert (reader.read(data).velocity, reader.read(data).position) == (3.0, 4.0)
    contents.close()


@pytest.mark.parametrize("value", [math.nan, -0.0, 5e-324, math.inf])
def test_numbers_keep_their_bits(value):
    reader = JointStateReader(Counting())
    message = serialised("base", ["a", "b"], [[value, 1.0], [value, -value], []])
    assert plain(reader.read(message)) == plain(reader.read(message))
    assert struct.pack("d", reader.read(message).position[0]) == struct.pack("d", value)


def test_publishers_that_alternate_on_a_topic_are_each_looked_at_once():
    drive = serialised("", ["a", "b"], [[1.0, 2.0]] * 3)
    arm = serialised("", ["shoulder", "elbow", "wrist"], [[1.0, 2.0, 3.0]] * 3)
    whole = Counting()
    reader = JointStateReader(whole)
    for _ in range(5):
        assert plain(reader.read(drive)) == plain(whole._reader.read(drive))
        assert plain(reader.read(arm)) == plain(whole._reader.read(arm))
    assert whole.asked == 2
