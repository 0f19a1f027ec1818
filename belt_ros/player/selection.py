"""Which topics of a bag go out, under which names, and with which quality of service."""

import importlib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from rclpy.duration import Duration
from rclpy.exceptions import InvalidTopicNameException
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.validate_full_topic_name import validate_full_topic_name
from rosbags.interfaces import ConnectionExtRosbag2, Qos, QosDurability, QosReliability, QosTime

from belt_ros.replay.errors import BagError
from belt_ros.replay.sources import Topic
from belt_ros.replay.sqlite_files import BagReader

_DEPTH = 100  # at least: recorders mostly do not know it
_FOREVER = 2**31 - 1  # [s]
CLOCK = "/clock"
_CLOCK_TYPE = "rosgraph_msgs/msg/Clock"


class Route(NamedTuple):
    """One topic of the bag, and how it is published."""

    recorded: str
    published: str
    type_name: str
    kind: type[Any]
    quality: QoSProfile


class Selection(NamedTuple):
    """What goes out, and why the rest does not."""

    routes: tuple[Route, ...]
    left_out: dict[str, str]  # topic: reason


def remappings(given: Sequence[str]) -> dict[str, str]:
    """Return new names of topics from texts ``/old:=/new``.

    Raises
    ------
    BagError
        For any other text.
    """
    renamed: dict[str, str] = {}
    for text in given:
        old, found, new = text.partition(":=")
        if not (found and old.strip("/ ") and _is_topic(_absolute(new))):
            raise BagError(f"--remap {text!r} is no renaming of a topic; write /old:=/new")
        renamed[_absolute(old)] = _absolute(new)
    return renamed


def selection(
    path: Path,
    topics: Sequence[Topic],
    chosen: Sequence[str],
    renamed: dict[str, str],
    *,
    own_clock: bool,
) -> Selection:
    """Return which topics of a bag are published and how.

    Parameters
    ----------
    path : Path
        The bag.
    topics : sequence of Topic
        What is in it.
    chosen : sequence of str
        Those wanted; all if empty.
    renamed : dict
        From `remappings`.
    own_clock : bool
        Whether the player publishes the clock, so that a recorded one is left out.

    Raises
    ------
    BagError
        If a topic asked for is not there, nothing is left to publish, or one name is to carry
        messages of different types.
    """
    types = {topic.name: topic.type_name for topic in topics if topic.messages}
    wanted = {_absolute(name) for name in chosen} or set(types)
    for name in (*sorted(wanted), *renamed):
        if name not in types:
            raise BagError(f"{path}: no messages on {name}; there are {', '.join(sorted(types))}")
    offered = _offered(path)
    routes, left_out = [], {}
    for name in sorted(wanted):
        kind = _message_class(types[name])
        if own_clock and name == CLOCK:
            left_out[name] = "the player publishes the clock itself"
        elif kind is None:
            left_out[name] = f"{types[name]} is not installed"
        else:
            quality = _quality(offered.get(name, ()))
            routes.append(Route(name, renamed.get(name, name), types[name], kind, quality))
    if not routes:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in left_out.items())
        raise BagError(f"{path}: nothing to publish ({reasons or 'it holds no messages'})")
    carried = [(route.published, types[route.recorded]) for route in routes]
    _refuse_mixed([*carried, (CLOCK, _CLOCK_TYPE)] if own_clock else carried)
    return Selection(tuple(routes), left_out)


def _refuse_mixed(carried: Sequence[tuple[str, str]]) -> None:
    """Raise where topics of different types would go out under one name."""
    for name, type_name in carried:
        types = sorted({other for there, other in carried if there == name})
        if types != [type_name]:
            raise BagError(f"{name} would carry {' and '.join(types)}; choose another --remap")


def _is_topic(name: str) -> bool:
    with suppress(InvalidTopicNameException):
        validate_full_topic_name(name)
        return True
    return False


def _absolute(name: str) -> str:
    return "/" + name.strip().lstrip("/")


def _message_class(type_name: str) -> type[Any] | None:
    """Return the class of ``package/msg/Name``, None where it is not installed."""
    package, _, name = type_name.partition("/msg/")
    try:
        kind: type[Any] = getattr(importlib.import_module(f"{package}.msg"), name)
    except (ImportError, AttributeError):
        return None
    return kind


def _offered(path: Path) -> dict[str, tuple[Qos, ...]]:
    """Return the quality of service that was offered on each topic, where the bag knows it."""
    found: dict[str, tuple[Qos, ...]] = {}
    # A bag that can be read file by file only has lost its metadata.
    with suppress(Exception), BagReader(path) as reader:
        for connection in reader.connections:
            extension = connection.ext
            if isinstance(extension, ConnectionExtRosbag2):
                earlier = found.get(connection.topic, ())
                found[connection.topic] = (*earlier, *extension.offered_qos_profiles)
    return found


def _quality(offered: Sequence[Qos]) -> QoSProfile:
    """Return what publishers offered if they agree; else what most subscribers can take."""
    quality = QoSProfile(depth=_DEPTH)
    first = next(iter(offered), None)
    if first is None or any(_contract(one) != _contract(first) for one in offered):
        return quality
    quality.depth = max(first.depth, _DEPTH)
    if first.reliability is QosReliability.BEST_EFFORT:
        quality.reliability = ReliabilityPolicy.BEST_EFFORT
    if first.durability is QosDurability.TRANSIENT_LOCAL:
        quality.durability = DurabilityPolicy.TRANSIENT_LOCAL
    quality.deadline = _duration(first.deadline)
    quality.lifespan = _duration(first.lifespan)
    return quality


def _contract(qos: Qos) -> tuple[object, ...]:
    """Return what publisher and subscriber have to agree on."""
    return qos.reliability, qos.durability, qos.deadline, qos.lifespan


def _duration(time: QosTime) -> Duration:
    """Return a duration; zero, which is none, where it is practically infinite."""
    if time.sec >= _FOREVER:
        return Duration()
    return Duration(seconds=time.sec, nanoseconds=time.nsec)
