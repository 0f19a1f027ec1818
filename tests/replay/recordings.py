"""Bags of any topics, as recorders leave them."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

from bags import START_NS
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from belt_ros.drive_inputs import FLOAT64, JOINT_STATE, PULLEY_STATE
from belt_ros.message_types import belt_typestore

TYPES = belt_typestore()
Logged = tuple[int, str, Any]  # log time [ns], topic, message


def header(stamp_ns: int) -> Any:
    seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
    time = TYPES.types["builtin_interfaces/msg/Time"](seconds, nanoseconds)
    return TYPES.types["std_msgs/msg/Header"](time, "")


def pulley_state(stamp_ns: int, *values: float) -> Any:
    """Position, speed, torque, hub load, span tension."""
    return TYPES.types[PULLEY_STATE](header(stamp_ns), *values)


def float32(value: float) -> Any:
    return TYPES.types["std_msgs/msg/Float32"](value)


def text(value: str) -> Any:
    return TYPES.types["std_msgs/msg/String"](value)


def float64(value: float) -> Any:
    return TYPES.types[FLOAT64](value)


def record(
    path: Path,
    logged: Iterable[Logged],
    *,
    plugin: StoragePlugin = StoragePlugin.MCAP,
    version: Literal[8, 9] = 8,
    compression: CompressionMode | None = None,
) -> Path:
    """Write messages to a bag in the order given."""
    writer = Writer(path, version=version, storage_plugin=plugin)
    if compression is not None:
        writer.set_compression(compression, CompressionFormat.ZSTD)
    connections: dict[tuple[str, str], Any] = {}
    with writer:
        for log_ns, topic, message in logged:
            kind = message.__msgtype__
            if (topic, kind) not in connections:
                connection = writer.add_connection(topic, kind, typestore=TYPES)
                connections[topic, kind] = connection
            writer.write(connections[topic, kind], log_ns, TYPES.serialize_cdr(message, kind))
    return path


def pulleys(count: int, prefix: str = "", late_ns: int = 300_000) -> list[Logged]:
    """Two pulleys at 100 Hz; the driven one's message comes a little later, and first at times."""
    logged: list[Logged] = []
    for k in range(count):
        stamp_ns = START_NS + k * 10_000_000
        arrivals = (stamp_ns + 1_000_000, stamp_ns + 1_000_000 + (-1) ** (k % 3) * late_ns)
        driver = pulley_state(stamp_ns, 1.2 * k, 120.0, 15.0, 800.0, float("nan"))
        driven = pulley_state(stamp_ns + 200_000, 1.197 * k, 119.72, -15.0, 800.0, 450.0)
        logged += [
            (arrivals[0], f"{prefix}/driver/state", driver),
            (arrivals[1], f"{prefix}/driven/state", driven),
        ]
    return sorted(logged, key=lambda each: each[0])


def numbers(count: int, prefix: str = "") -> list[Logged]:
    """Speeds and torques as plain numbers, one after another, at 100 Hz."""
    values = {
        "driver/speed": 120.0,
        "driven/speed": 119.72,
        "driver/torque": 15.0,
        "driven/torque": -15.0,
    }
    return [
        (START_NS + k * 10_000_000 + place * 150_000, f"{prefix}/{name}", float64(value))
        for k in range(count)
        for place, (name, value) in enumerate(values.items())
    ]


__all__ = [
    "JOINT_STATE",
    "TYPES",
    "float32",
    "float64",
    "numbers",
    "pulley_state",
    "pulleys",
    "record",
    "text",
]
