"""A run of the rig as a rosbag2 MCAP bag, written without ROS."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from belt_ros.appearing import appearing
from belt_ros.message_fields import state_fields
from belt_ros.message_types import belt_typestore
from belt_ros.rig.sensors import JointSample
from belt_ros.rig.simulate import RigSample
from belt_ros.rig.truth import Truth, as_estimate

JOINT_TOPIC = "/joint_states"
TRUTH_TOPIC = "/belt_rig/truth"
_JOINT_TYPE = "sensor_msgs/msg/JointState"
_TRUTH_TYPE = "belt_msgs/msg/BeltState"
_METADATA_VERSION: Literal[8] = 8  # the newest that ROS 2 Humble reads


def write_bag(
    path: str | Path, drive_name: str, samples: Iterable[RigSample], *, truth_every: int = 1
) -> int:
    """Write joint states and truth to a new bag, compressed chunk by chunk.

    The bag appears complete or not at all. A message's time in it is when it goes out, its header's
    stamp what faults make of it.

    Parameters
    ----------
    path : str or Path
        Directory of the bag; it must not exist yet.
    drive_name : str
        As the truth is to name the drive.
    samples : iterable of RigSample
    truth_every : int
        Write the truth of every n-th sample only.

    Returns
    -------
    int
        Number of joint states written.

    Raises
    ------
    FileExistsError
        If there is something at `path` already.
    """
    if truth_every < 1:
        raise ValueError(f"truth_every is {truth_every}; it must be at least 1")
    place = Path(path)
    refuse_existing(place)
    with appearing(place) as part:
        count = _write(part, drive_name, samples, truth_every)
        refuse_existing(place)
    return count


def refuse_existing(place: Path) -> None:
    """Raise `FileExistsError` if there is something where a bag is to be."""
    if place.exists():
        raise FileExistsError(f"{place} exists already; choose another name or remove it")


def _write(path: Path, drive_name: str, samples: Iterable[RigSample], truth_every: int) -> int:
    store = belt_typestore()
    writer = Writer(path, version=_METADATA_VERSION, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    count = 0
    with writer:
        joints = writer.add_connection(JOINT_TOPIC, _JOINT_TYPE, typestore=store)
        truths = writer.add_connection(TRUTH_TOPIC, _TRUTH_TYPE, typestore=store)
        for number, sample in enumerate(samples):
            now_ns = sample.stamp_ns
            for report in sample.published:
                message = _joint_state(*report)
                writer.write(joints, now_ns, store.serialize_cdr(message, _JOINT_TYPE))
                count += 1
            if number % truth_every == 0:
                message = _belt_state(now_ns, drive_name, sample.truth)
                writer.write(truths, now_ns, store.serialize_cdr(message, _TRUTH_TYPE))
    return count


def _header(stamp_ns: int) -> Any:
    types = belt_typestore().types
    seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
    stamp = types["builtin_interfaces/msg/Time"](seconds, nanoseconds)
    return types["std_msgs/msg/Header"](stamp, "")


def _joint_state(stamp_ns: int, joints: JointSample) -> Any:
    return belt_typestore().types[_JOINT_TYPE](
        _header(stamp_ns),
        list(joints.names),
        np.array(joints.positions),
        np.array(joints.velocities),
        np.array(joints.efforts),
    )


def _belt_state(stamp_ns: int, drive_name: str, truth: Truth) -> Any:
    fields = state_fields(drive_name, as_estimate(truth, stamp_ns))
    fields["rejection_counts"] = np.array(fields["rejection_counts"], dtype=np.uint64)
    return belt_typestore().types[_TRUTH_TYPE](header=_header(stamp_ns), **fields)
