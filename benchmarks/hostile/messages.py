"""Rows of readings as messages: live and recorded ones, well formed or not."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from belt_msgs.msg import PulleyState
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from belt_ros.estimation import Joint
from belt_ros.settings import DriveSettings
from benchmarks.hostile.motion import Row

_SECOND_NS = 1_000_000_000
_GREATEST = 2**31
_RECORDED = get_typestore(Stores.ROS2_JAZZY).types
_RATES = (0.0, 0.0, 1e-3, 0.02, 0.3)
_FIELDS = ("velocity", "effort", "position")
_NAMES = ("", "elbow", "\u00e9paule", "a" * 300, "driver_pulley_joint ", "\x00", "\U0001f600")


class Messages:
    """Makes messages of one kind for one drive, and breaks some of them.

    Parameters
    ----------
    settings : DriveSettings
    random : Generator
    recorded : bool
        Whether joint states are as `rosbags` reads them, rather than as rclpy hands them out.
    """

    def __init__(
        self, settings: DriveSettings, random: np.random.Generator, *, recorded: bool
    ) -> None:
        self._joints = (settings.driver, settings.driven)
        self._random = random
        self._recorded = recorded
        self._broken = float(random.choice(_RATES))
        self._with = {"velocity": 1.0, "effort": 1.0, "position": float(random.random() < 0.4)}
        self._loads = float(random.random() < 0.5)

    def joint_state(self, row: Row) -> Any:
        """Return a joint state, among others' joints."""
        random = self._random
        names = [joint.name for joint in self._joints]
        columns = dict(zip(_FIELDS, self._reported(row), strict=True))
        content = {
            field: list(values) if random.random() < self._with[field] else []
            for field, values in columns.items()
        }
        if random.random() < self._broken:
            self._break(names, content)
        seconds, nanoseconds = self._stamp(row.stamp_ns)
        if self._recorded:
            return _recorded(seconds, nanoseconds, names, content)
        message = JointState(name=names, **content)
        message.header.stamp.sec, message.header.stamp.nanosec = seconds, nanoseconds
        return message

    def pulley_states(self, row: Row) -> Iterator[tuple[str, Any]]:
        """Return topics and messages."""
        speeds, efforts, positions = self._reported(row)
        hub, span = row.values[6:8].tolist(), float(row.values[8])
        loads = self._random.random() < self._loads
        for at, pulley in enumerate(("driver", "driven")):
            if self._random.random() < self._broken:
                continue
            message = PulleyState(
                speed=speeds[at],
                torque=efforts[at],
                position=positions[at] if self._with["position"] else math.nan,
                hub_load=hub[at] if loads else math.nan,
                span_tension=span if loads else math.nan,
            )
            stamp = message.header.stamp
            stamp.sec, stamp.nanosec = self._stamp(row.stamp_ns)
            yield f"/{pulley}/state", message

    def numbers(self, row: Row) -> Iterator[tuple[str, Any]]:
        """Return topics and messages, in no order."""
        names = ("speed", "torque", "position")
        found = [
            (f"/{pulley}/{name}", values[at])
            for name, values in zip(names, self._reported(row), strict=True)
            for at, pulley in enumerate(("driver", "driven"))
            if name != "position" or self._with["position"]
        ]
        if self._loads:
            at_loads = ("/driver/hub_load", "/driven/hub_load", "/driven/span_tension")
            found += zip(at_loads, row.values[6:].tolist(), strict=True)
        if self._random.random() < self._broken:
            found = [found[at] for at in self._random.integers(0, len(found), size=len(found))]
        for topic, value in found:
            yield topic, Float64(data=value)

    def _reported(self, row: Row) -> tuple[list[float], list[float], list[float]]:
        """Return velocities, efforts and positions as the joints report them."""
        values = row.values.tolist()
        joints = self._joints
        return (
            [_reported_speed(joint, values[at]) for at, joint in enumerate(joints)],
            [joint.effort(values[2 + at], values[at]) for at, joint in enumerate(joints)],
            [_reported_speed(joint, values[4 + at]) for at, joint in enumerate(joints)],
        )

    def _stamp(self, stamp_ns: int) -> tuple[int, int]:
        """Return seconds and nanoseconds, now and then of no time at all."""
        seconds, rest = divmod(stamp_ns, _SECOND_NS)
        seconds = (seconds + _GREATEST) % (2 * _GREATEST) - _GREATEST
        if self._random.random() < 0.1 * self._broken:
            rest = int(self._random.integers(_SECOND_NS, 2**32))
        return seconds, rest

    def _break(self, names: list[str], content: dict[str, list[float]]) -> None:
        """Let names be doubled, missing or many, arrays empty or of another length."""
        random = self._random
        way = int(random.integers(7))
        field = str(random.choice(_FIELDS))
        if way == 0:
            names[int(random.integers(2))] = str(random.choice(_NAMES))
        elif way == 1:
            _extend(names, content, [names[0], names[1], names[0]])
        elif way == 2:
            _extend(names, content, [f"joint_{at}" for at in range(random.integers(990, 1100))])
        elif way == 3:
            content[field] = []
        elif way == 4:
            content[field].append(1.0)
        elif way == 5:
            names.clear()
        else:
            names.reverse()


def _reported_speed(joint: Joint, value: float) -> float:
    return joint.sign * value * joint.gear_ratio


def _extend(names: list[str], content: dict[str, list[float]], others: list[str]) -> None:
    names[:0] = others
    for values in content.values():
        if values:
            values[:0] = [1.5] * len(others)


def _recorded(
    seconds: int, nanoseconds: int, names: list[str], content: dict[str, list[float]]
) -> Any:
    stamp = _RECORDED["builtin_interfaces/msg/Time"](seconds, nanoseconds)
    header = _RECORDED["std_msgs/msg/Header"](stamp, "")
    arrays = {field: np.array(values, dtype=np.float64) for field, values in content.items()}
    return _RECORDED["sensor_msgs/msg/JointState"](header=header, name=names, **arrays)
