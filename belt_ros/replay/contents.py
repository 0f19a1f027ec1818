"""What a bag holds: its topics, and their messages with the types that the bag itself carries."""

from collections.abc import Collection, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from belt_ros.drive_inputs import JOINT_STATE
from belt_ros.message_types import belt_typestore
from belt_ros.replay.errors import BagError, damage_reported
from belt_ros.replay.joint_states import JointStateReader, Reader
from belt_ros.replay.sources import Topic, Wanted, close_all, open_sources

_DEFINITIONS = 16  # kept for the next bag


class Contents:
    """A bag that is open for reading.

    Parameters
    ----------
    path : Path
        A rosbag2 directory (MCAP or sqlite3), or a bare .mcap or .db3 file.
    salvage : bool
        Whether it is known to be damaged inside: then every MCAP file is read chunk by chunk.

    Attributes
    ----------
    note : str
        What of it is lost; empty if nothing is.

    Raises
    ------
    BagError
        If nothing of it can be read.
    """

    def __init__(self, path: Path, *, salvage: bool = False) -> None:
        self.path = path
        self._sources = open_sources(path, salvage=salvage)
        self.note = " ".join(source.note for source in self._sources if source.note)

    def close(self) -> None:
        """Release the files."""
        close_all(self._sources)

    @property
    def topics(self) -> list[Topic]:
        """All topics, once for each file that has them."""
        return [topic for source in self._sources for topic in source.topics]

    @property
    def end_ns(self) -> int:
        """Log time [ns] of the last message on any topic; 0 without one."""
        return max((source.end_ns for source in self._sources), default=0)

    def names(self, type_name: str) -> list[str]:
        """Return the topics of a type: those with messages, or all if none has any."""
        found = [topic for topic in self.topics if topic.type_name == type_name]
        return sorted({topic.name for topic in found if topic.messages} or {t.name for t in found})

    def count(self, wanted: Wanted) -> int:
        """Return the number of messages that are wanted."""
        return sum(t.messages for t in self.topics if wanted.get(t.name) == t.type_name)

    def messages(self, wanted: Wanted) -> Iterator[tuple[str, int, bytes]]:
        """Yield topic, log time [ns] and bytes of all messages that are wanted, in bag order."""
        for source in self._sources:
            yield from source.messages(wanted)

    def reader(self, type_name: str, fields: Collection[str] = ()) -> Reader:
        """Return what decodes messages of a type, as the bag itself defines it.

        Raises
        ------
        BagError
            If the bag's definition is broken, or lacks one of `fields`.
        """
        types = self._types(type_name)
        try:
            known = {name for name, _ in types.fielddefs[type_name][1]}
        except KeyError:
            raise BagError(f"{self.path}: {type_name} is not defined in it.") from None
        missing = [name for name in fields if name not in known]
        if missing:
            raise BagError(
                f"{self.path}: its definition of {type_name} has no {', '.join(missing)}; it was "
                "recorded with another version of that message."
            )
        reader = MessageReader(types, type_name)
        return JointStateReader(reader) if _is_joint_state(types, type_name) else reader

    def _types(self, type_name: str) -> Typestore:
        """Take the type from the bag; from this package and Jazzy where it carries none."""
        for topic in self.topics:
            if topic.type_name == type_name and topic.definition:
                advice = f"Its definition of {type_name} is broken; record the bag anew."
                with damage_reported(self.path, advice):
                    return _defined(topic.definition, type_name)
        return belt_typestore()

    def offer(self) -> str:
        """Return what it holds, in a sentence."""
        names = sorted({f"{topic.name} [{topic.type_name}]" for topic in self.topics})
        shown = ", ".join(names[:10]) + (", ..." if len(names) > 10 else "")
        return f"The bag holds: {shown or 'no topics'}."


@lru_cache(_DEFINITIONS)
def _defined(definition: str, type_name: str) -> Typestore:
    types = get_typestore(Stores.EMPTY)
    types.register(get_types_from_msg(definition, type_name))
    types.get_msgdef(type_name)  # which finds out whether all its parts are there
    return types


def _is_joint_state(types: Typestore, type_name: str) -> bool:
    """Whether a type is the JointState of sensor_msgs, defined as it is there."""
    ours, theirs = belt_typestore().fielddefs, types.fielddefs
    return type_name == JOINT_STATE and all(
        theirs.get(name) == ours[name]
        for name in (JOINT_STATE, "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )


class MessageReader:
    """Decodes messages of one type."""

    def __init__(self, types: Typestore, type_name: str) -> None:
        self._types = types
        self._type_name = type_name

    def read(self, data: bytes) -> Any:
        """Return a message; None if the bytes are none."""
        try:
            return self._types.deserialize_cdr(data, self._type_name)
        except (SerdeError, ValueError, IndexError):
            return None
