"""Bags for the replay tests, written with the libraries that users' bags come from."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

TYPES = get_typestore(Stores.ROS2_JAZZY)
JOINT_STATE = "sensor_msgs/msg/JointState"
JOINTS = ("driver_pulley_joint", "driven_pulley_joint")
START_NS = 1_700_000_000_000_000_000
PERIOD_NS = 10_000_000


class Sample(NamedTuple):
    log_ns: int
    stamp_ns: int
    velocity: tuple[float, ...]
    effort: tuple[float, ...]


def steady_run(count: int, seed: int = 0) -> list[Sample]:
    """The paper's drive at 120 rad/s and 15 N m, with noise; logged 1 ms after each stamp."""
    noise = np.random.default_rng(seed).standard_normal((count, 4))
    samples = []
    for i, (a, b, c, d) in enumerate(noise):
        stamp_ns = START_NS + i * PERIOD_NS
        velocity = (120.0 + 0.005 * a, 120.0 * (1.0 - 0.0023) + 0.005 * b)
        samples.append(
            Sample(stamp_ns + 1_000_000, stamp_ns, velocity, (15.0 + 0.3 * c, -15.0 + 0.3 * d))
        )
    return samples


def cdr(sample: Sample, joints: tuple[str, ...] = JOINTS) -> bytes:
    seconds, nanoseconds = divmod(sample.stamp_ns, 1_000_000_000)
    stamp = TYPES.types["builtin_interfaces/msg/Time"](seconds, nanoseconds)
    message = TYPES.types[JOINT_STATE](
        TYPES.types["std_msgs/msg/Header"](stamp, ""),
        list(joints),
        np.zeros(0),
        np.array(sample.velocity, dtype=np.float64),
        np.array(sample.effort, dtype=np.float64),
    )
    return bytes(TYPES.serialize_cdr(message, JOINT_STATE))


def write_bag(
    path: Path,
    topics: dict[str, Iterable[bytes | Sample]],
    *,
    plugin: StoragePlugin = StoragePlugin.MCAP,
    joints: tuple[str, ...] = JOINTS,
) -> Path:
    with Writer(path, version=8, storage_plugin=plugin) as writer:
        for topic, messages in topics.items():
            connection = writer.add_connection(topic, JOINT_STATE, typestore=TYPES)
            for i, message in enumerate(messages):
                if isinstance(message, Sample):
                    writer.write(connection, message.log_ns, cdr(message, joints))
                else:
                    writer.write(connection, START_NS + i * PERIOD_NS, message)
    return path


def write_chunked_mcap(path: Path, samples: Iterable[Sample], **options: Any) -> Path:
    """A bare MCAP file of many small chunks."""
    definition, _ = TYPES.generate_msgdef(JOINT_STATE, ros_version=2)
    settings = {"chunk_size": 1024, "compression": CompressionType.ZSTD, **options}
    with path.open("wb") as file:
        writer = McapWriter(file, **settings)
        writer.start(profile="ros2")
        schema = writer.register_schema(JOINT_STATE, "ros2msg", definition.encode())
        channel = writer.register_channel("/joint_states", "cdr", schema)
        for sample in samples:
            writer.add_message(channel, sample.log_ns, cdr(sample), sample.log_ns)
        writer.finish()
    return path


def chunk_ends(path: Path) -> list[int]:
    """Where each chunk of a file ends [bytes]."""
    with path.open("rb") as file:
        return [
            file.tell()
            for record in StreamReader(file, emit_chunks=True).records
            if isinstance(record, Chunk)
        ]
