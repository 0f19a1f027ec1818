"""How one drive's measurements arrive: on which topics, as what messages, read how. No ROS.

Messages are read by their fields' names alone, so that those of rclpy and of rosbags serve alike.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from belt_ros.estimation import Joint, Measurement, Rejection, measurement_from_joints
from belt_ros.estimation.measurement import of_others
from belt_ros.node_tables import UNIT_PARAMETERS, InputKind
from belt_ros.parameter_table import SettingsError
from belt_ros.settings import DriveSettings, names_of_drives, read_parameters
from belt_ros.several_drives import values_of_drive

JOINT_STATE = "sensor_msgs/msg/JointState"
PULLEY_STATE = "belt_msgs/msg/PulleyState"
FLOAT64 = "std_msgs/msg/Float64"
_SECOND_NS = 1_000_000_000
_MOST_SECONDS = 2**31  # of builtin_interfaces/Time
_MOST_JOINTS = 1000
_PULLEYS = ("driver", "driven")
_MOTION = ("speed", "torque", "position")
_INPUT = ("input", "input_reorder_window", "input_disorder", "input_slop", "input_loads")
_JOINT_STATE_FIELDS = ("header", "name", "position", "velocity", "effort")
_PULLEY_STATE_FIELDS = ("header", "speed", "torque", "position", "hub_load", "span_tension")
_LOADS = {
    "driver/hub_load": "driver_hub_load",
    "driven/hub_load": "driven_hub_load",
    "driven/span_tension": "span_tension",
}


@dataclass(frozen=True)
class InputSettings:
    """What speeds and torques come as, and how messages of several topics are joined [s]."""

    kind: InputKind = InputKind.JOINT_STATE
    reorder_window: float = 0.05
    disorder: float = 0.0
    slop: float = 0.001
    loads: bool = False  # come as Float64 beside them


def inputs_from_parameters(values: Mapping[str, object]) -> InputSettings:
    """Build settings from flat parameter names, of which all others are left aside.

    Raises
    ------
    SettingsError
        For a wrong type or a value out of range.
    """
    kind, window, disorder, slop, loads = (
        UNIT_PARAMETERS[name].check(values.get(name, UNIT_PARAMETERS[name].default))
        for name in _INPUT
    )
    return InputSettings(InputKind(kind), float(window), float(disorder), float(slop), bool(loads))


def load_inputs(path: str | Path, drive: str = "") -> InputSettings:
    """Read from a drive's YAML how its measurements arrive.

    Parameters
    ----------
    path : str or Path
    drive : str
        Which drive, where the file describes several.

    Raises
    ------
    SettingsError
        If the file or a value in it cannot be used; the message begins with the path.
    """
    values = read_parameters(path)
    try:
        names = names_of_drives(values)
        if drive in names:
            values = values_of_drive(values, drive, names)
        return inputs_from_parameters(values)
    except SettingsError as error:
        raise SettingsError(f"{path}: {error}") from error


def refuse_confused(drives: Iterable[tuple[DriveSettings, InputKind]]) -> None:
    """Raise where two drives could not be told apart: by name, or by the joints that they read.

    Raises
    ------
    SettingsError
    """
    names: set[str] = set()
    by_joints: dict[tuple[str, str], str] = {}
    for drive, kind in drives:
        if drive.name in names:
            raise SettingsError(f"name is {drive.name!r} for several drives; give each its own")
        names.add(drive.name)
        joints = drive.driver.name, drive.driven.name
        if kind is InputKind.JOINT_STATE and by_joints.setdefault(joints, drive.name) != drive.name:
            raise SettingsError(
                f"{by_joints[joints]} and {drive.name} both read the joints {joints[0]!r} and "
                f"{joints[1]!r}; set driver.joint and driven.joint of each"
            )


class Feed(NamedTuple):
    """One topic, named relative to the drive's namespace.

    `read` makes a sample of a message, given its stamp or, where it has none, its arrival [ns];
    None of one that is another drive's.
    """

    topic: str
    type_name: str
    read: Callable[[Any, int], Measurement | Rejection | None]
    stamped: bool = True
    fields: tuple[str, ...] = ()  # that the message must have
    needed: bool = True  # without it there is nothing to estimate from


def feeds(kind: InputKind, prefix: str, joints: tuple[Joint, Joint], *, loads: bool) -> list[Feed]:
    """Return the topics of a drive.

    Parameters
    ----------
    kind : InputKind
    prefix : str
        What stands before the names of the topics, e.g. ``drive_name/``; ``joint_states`` is one
        for all drives and has none.
    joints : tuple of Joint
        Of driver and driven pulley.
    loads : bool
        Whether hub loads and span tension come as Float64; a PulleyState carries them itself.
    """
    found: list[Feed] = []
    if kind is InputKind.JOINT_STATE:
        read = _joint_state_reader(*joints)
        found.append(Feed("joint_states", JOINT_STATE, read, fields=_JOINT_STATE_FIELDS))
    elif kind is InputKind.PULLEY_STATE:
        found += [
            Feed(
                f"{prefix}{name}/state",
                PULLEY_STATE,
                partial(_pulley, name),
                fields=_PULLEY_STATE_FIELDS,
            )
            for name in _PULLEYS
        ]
    else:
        pairs = [(pulley, what) for pulley in _PULLEYS for what in _MOTION]
        channels = {f"{pulley}/{what}": f"{pulley}_{what}" for pulley, what in pairs}
        found += _numbers(channels, prefix, needed=("driver/speed", "driven/speed"))
    if loads and kind is not InputKind.PULLEY_STATE:
        found += _numbers(_LOADS, prefix)
    return found


def _numbers(
    channels: Mapping[str, str], prefix: str, needed: tuple[str, ...] = ()
) -> Iterator[Feed]:
    for topic, channel in channels.items():
        yield Feed(
            prefix + topic,
            FLOAT64,
            partial(_number, channel),
            stamped=False,
            fields=("data",),
            needed=topic in needed,
        )


def stamp_of(message: Any) -> int | None:
    """Return a message's stamp [ns]; None if it is no time."""
    stamp = message.header.stamp
    if not (0 <= stamp.sec < _MOST_SECONDS and 0 <= stamp.nanosec < _SECOND_NS):
        return None
    return int(stamp.sec) * _SECOND_NS + int(stamp.nanosec)


def measurement_from_joint_state(
    driver: Joint, driven: Joint, message: Any
) -> Measurement | Rejection | None:
    """Read the two pulleys out of a sensor_msgs/JointState, or say why that is impossible.

    None if it has nothing of either.
    """
    if len(message.name) > _MOST_JOINTS:
        return Rejection.MALFORMED
    stamp_ns = stamp_of(message)
    if stamp_ns is None:
        return None if of_others(driver, driven, message.name) else Rejection.MALFORMED
    return measurement_from_joints(
        driver,
        driven,
        stamp_ns,
        message.name,
        message.velocity,
        message.effort,
        message.position,
    )


def _joint_state_reader(
    driver: Joint, driven: Joint
) -> Callable[[Any, int], Measurement | Rejection | None]:
    return lambda message, _: measurement_from_joint_state(driver, driven, message)


def reading_from_pulley_state(pulley: str, message: Any) -> Measurement | Rejection:
    """Read a belt_msgs/PulleyState of the ``"driver"`` or ``"driven"`` pulley.

    The driver's span tension is of a span that `Measurement` does not know.
    """
    stamp_ns = stamp_of(message)
    if stamp_ns is None:
        return Rejection.MALFORMED
    values = {f"{pulley}_{what}": getattr(message, what) for what in (*_MOTION, "hub_load")}
    if pulley == "driven":
        values["span_tension"] = message.span_tension
    return reading(stamp_ns, values)


def _pulley(pulley: str, message: Any, _: int) -> Measurement | Rejection:
    return reading_from_pulley_state(pulley, message)


def _number(channel: str, message: Any, stamp_ns: int) -> Measurement | Rejection:
    if not 0 <= stamp_ns < _MOST_SECONDS * _SECOND_NS:
        return Rejection.MALFORMED
    return reading(stamp_ns, {channel: message.data})


def reading(stamp_ns: int, values: Mapping[str, float]) -> Measurement | Rejection:
    """Return a measurement of some quantities, by their names in `Measurement`.

    One that is infinite is turned away here, before it is joined with what others measured; so is
    one in which nothing is measured.
    """
    if any(map(math.isinf, values.values())) or all(map(math.isnan, values.values())):
        return Rejection.NOT_FINITE
    named: dict[str, Any] = dict(values)
    return Measurement(stamp_ns, **named)
