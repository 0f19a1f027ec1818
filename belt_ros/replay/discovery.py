"""Which topics and joints of a bag are a drive's: found where it is clear, listed where it is not.

Topics have the names that the live node listens on, in any namespace; a JointState may be on any
topic, if only one carries both joints among its first messages. A joint may be called
``robot_1/driver_pulley_joint`` or ``left_driver_pulley_joint`` where the description says
``driver_pulley_joint``, if only one is.
"""

import dataclasses
from collections.abc import Iterable, Sequence
from itertools import chain, islice
from typing import NamedTuple

from belt_ros.drive_inputs import JOINT_STATE, Feed, InputSettings, feeds
from belt_ros.estimation import Joint
from belt_ros.node_tables import InputKind
from belt_ros.replay.contents import Contents
from belt_ros.replay.errors import BagError

_RECORD = "Record its speeds and torques with the drive running."
_LOOKED_AT = 1000  # messages: others may send on the same topic, and more often
Joints = tuple[Joint, Joint]


class Found(NamedTuple):
    """What a drive's measurements are read from; `topics` are those of `feeds`."""

    feeds: tuple[Feed, ...]
    topics: tuple[str, ...]
    joints: Joints
    note: str = ""


def find_inputs(
    contents: Contents, inputs: InputSettings, prefix: str, joints: Joints, wanted: str | None
) -> Found:
    """Return a drive's topics, or those of another kind if the bag has only those.

    Parameters
    ----------
    contents : Contents
    inputs : InputSettings
    prefix : str
        What the drive's topics begin with, e.g. ``drive_name/``.
    joints : tuple of Joint
    wanted : str, optional
        The topic of joint states, or the namespace of other topics, where there are several.

    Raises
    ------
    BagError
        If it is not clear which they are; the message lists them.
    """
    try:
        return _find(contents, inputs, prefix, joints, wanted)
    except BagError:
        others = [
            kind
            for kind in InputKind
            if kind is not inputs.kind and _full_namespaces(contents, kind, prefix, joints)
        ]
        if len(others) != 1 or _has_any(contents, inputs.kind, prefix, joints):
            raise
        found = _find(contents, dataclasses.replace(inputs, kind=others[0]), prefix, joints, wanted)
        note = (
            f"The description says input: {inputs.kind.value}, but the bag has only "
            f"{others[0].value}, which was read."
        )
        return found._replace(note=f"{note} {found.note}".rstrip())


def _has_any(contents: Contents, kind: InputKind, prefix: str, joints: Joints) -> bool:
    """Whether the bag holds a topic of a kind, if only one of several."""
    if kind is InputKind.JOINT_STATE:
        return bool(contents.names(JOINT_STATE))
    return any(
        name.endswith(f"/{feed.topic}")
        for feed in feeds(kind, prefix, joints, loads=False)
        for name in contents.names(feed.type_name)
    )


def _find(
    contents: Contents, inputs: InputSettings, prefix: str, joints: Joints, wanted: str | None
) -> Found:
    wired = feeds(inputs.kind, prefix, joints, loads=inputs.loads)
    if inputs.kind is not InputKind.JOINT_STATE:
        namespace = _namespace(contents, inputs.kind, prefix, joints, wanted)
        return _found(contents, wired, [f"{namespace}/{feed.topic}" for feed in wired], joints)
    topic = find_joint_states(contents, joints, wanted)
    seen = joints_on(contents, topic)
    called = tuple(_called(joint, seen) for joint in joints)
    note = ""
    if called[0].name != called[1].name and called != joints:
        pairs = zip(joints, called, strict=True)
        told = [f"{there.name} for {asked.name}" for asked, there in pairs if asked != there]
        note = f"Joints taken by the end of their names: {', '.join(told)}."
        joints = called[0], called[1]
        wired = feeds(inputs.kind, prefix, joints, loads=inputs.loads)
    names = [topic, *(_alone(contents, feed) for feed in wired[1:])]
    return _found(contents, wired, names, joints, note)


def _found(
    contents: Contents, wired: Iterable[Feed], names: Iterable[str], joints: Joints, note: str = ""
) -> Found:
    """Leave out what the bag does not have, or as another type, and what is not needed."""
    there = {(topic.name, topic.type_name) for topic in contents.topics}
    types = dict(sorted(there))
    pairs = []
    for feed, name in zip(wired, names, strict=True):
        if feed.needed or (name, feed.type_name) in there:
            pairs.append((feed, name))
        elif name in types:
            other = f"{name} is of type {types[name]}, not {feed.type_name}, and was not read."
            note = f"{note} {other}".lstrip()
    return Found(tuple(f for f, _ in pairs), tuple(name for _, name in pairs), joints, note)


def _alone(contents: Contents, feed: Feed) -> str:
    """Return the only topic that ends as a feed's; without one, as it would be called."""
    names = [name for name in contents.names(feed.type_name) if name.endswith(f"/{feed.topic}")]
    return names[0] if len(names) == 1 else f"/{feed.topic}"


def _full_namespaces(contents: Contents, kind: InputKind, prefix: str, joints: Joints) -> list[str]:
    """Return the namespaces that have all topics a kind needs."""
    wired = [feed for feed in feeds(kind, prefix, joints, loads=False) if feed.needed]
    spaces = [
        {
            name.removesuffix(f"/{feed.topic}")
            for name in contents.names(feed.type_name)
            if name.endswith(f"/{feed.topic}")
        }
        for feed in wired
    ]
    return sorted(set.intersection(*spaces))


def _namespace(
    contents: Contents, kind: InputKind, prefix: str, joints: Joints, wanted: str | None
) -> str:
    spaces = _full_namespaces(contents, kind, prefix, joints)
    needed = [feed for feed in feeds(kind, prefix, joints, loads=False) if feed.needed]
    topics = " and ".join(feed.topic for feed in needed)
    if wanted is not None:
        chosen = wanted.rstrip("/")
        if chosen in spaces:
            return chosen
        offer = f"Namespaces that have them: {_listed(spaces)}." if spaces else contents.offer()
        raise BagError(f"{contents.path}: {topics} are not in namespace {wanted}. {offer}")
    if not spaces:
        raise BagError(
            f"{contents.path}: no topics {topics} of type {needed[0].type_name}. "
            f"{contents.offer()} {_RECORD}"
        )
    if len(spaces) > 1 and "" not in spaces:
        raise BagError(
            f"{contents.path}: {len(spaces)} namespaces have {topics}. "
            f"Choose one with --topic: {_listed(spaces)}."
        )
    return "" if "" in spaces else spaces[0]


def _listed(spaces: Sequence[str]) -> str:
    return ", ".join(space or "/" for space in spaces)


def find_joint_states(contents: Contents, joints: Joints, wanted: str | None) -> str:
    """Return the topic of the joint states of both pulleys.

    Raises
    ------
    BagError
        If there is none, or several and none is `wanted`.
    """
    candidates = contents.names(JOINT_STATE)
    everything = {topic.name for topic in contents.topics if topic.type_name == JOINT_STATE}
    if wanted is not None:
        if wanted in everything:
            return wanted
        offer = _choice(everything) if everything else contents.offer()
        raise BagError(f"{contents.path}: no joint states on {wanted}. {offer}")
    if not candidates:
        raise BagError(
            f"{contents.path}: no topic of type sensor_msgs/JointState. {contents.offer()} "
            f"{_RECORD}"
        )
    if len(candidates) > 1:
        carrying = [name for name in candidates if _carries(contents, name, joints)]
        candidates = carrying or candidates
    if len(candidates) > 1:
        raise BagError(
            f"{contents.path}: {len(candidates)} topics carry joint states. {_choice(candidates)}"
        )
    return candidates[0]


def _choice(names: Iterable[str]) -> str:
    return f"Choose one with --topic: {', '.join(sorted(names))}."


def joints_on(contents: Contents, topic: str) -> list[str]:
    """Return the names of the joints in the first messages on a topic, whoever sent them."""
    reader = contents.reader(JOINT_STATE, ("name",))
    first = islice(contents.messages({topic: JOINT_STATE}), _LOOKED_AT)
    read = (reader.read(data) for _, _, data in first)
    names = (message.name for message in read if message is not None)
    return list(dict.fromkeys(chain.from_iterable(names)))


def _carries(contents: Contents, topic: str, joints: Joints) -> bool:
    seen = joints_on(contents, topic)
    return all(_called(joint, seen).name in seen for joint in joints)


def _called(joint: Joint, seen: Sequence[str]) -> Joint:
    """Return a joint by the name that messages have for it, if it is clear which that is."""
    if joint.name in seen:
        return joint
    near = [name for name in seen if name.endswith((f"/{joint.name}", f"_{joint.name}"))]
    return dataclasses.replace(joint, name=near[0]) if len(near) == 1 else joint
