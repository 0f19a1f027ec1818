"""Bags of any length, made cheaply: the paper's drive under a load that swings."""

import math
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from belt_ros.message_types import belt_typestore

_KIND = "sensor_msgs/msg/JointState"
_JOINTS = ["driver_pulley_joint", "driven_pulley_joint"]
_SECOND_NS = 1_000_000_000
START_NS = 1_700_000_000 * _SECOND_NS


def make_bag(path: Path, rate: float, count: int, seed: int = 0, start_ns: int = START_NS) -> Path:
    """Write `count` joint states at `rate` [Hz], with noise, to a compressed MCAP bag."""
    store, random = belt_typestore(), np.random.default_rng(seed)
    time, header = (
        store.types[name] for name in ("builtin_interfaces/msg/Time", "std_msgs/msg/Header")
    )
    writer = Writer(path, version=8, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer:
        joints = writer.add_connection("/joint_states", _KIND, typestore=store)
        for k in range(count):
            stamp_ns = start_ns + round(k / rate * _SECOND_NS)
            load = 15.0 + 8.0 * math.sin(1.2566 * k / rate)
            noise = random.standard_normal(4)
            speed = 120.0 + 0.005 * noise[0], 120.0 - 0.0184 * load + 0.005 * noise[1]
            torque = load + 0.3 * noise[2], -load + 0.3 * noise[3]
            message = store.types[_KIND](
                header(time(*divmod(stamp_ns, _SECOND_NS)), ""),
                _JOINTS,
                np.zeros(0),
                np.array(speed),
                np.array(torque),
            )
            writer.write(joints, stamp_ns + 1_000_000, store.serialize_cdr(message, _KIND))
    return path
