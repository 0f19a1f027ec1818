"""Joint states of a bag as measurements, one at a time and in the order of their log time."""

from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple

from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from belt_ros.estimation import Joint, Measurement, Rejection, measurement_from_joints
from belt_ros.replay.errors import BagError, damage_reported
from belt_ros.replay.sources import Topic, close_all, open_sources

JOINT_STATE = "sensor_msgs/msg/JointState"
_SECOND_NS = 1_000_000_000
_MOST_JOINTS = 1000  # as in the live node
_BROKEN_TYPE = "Its definition of sensor_msgs/JointState is broken; record the bag anew."


class JointSample(NamedTuple):
    """One joint state: when the bag received it [ns], and what it says or why it says nothing."""

    log_ns: int
    content: Measurement | Rejection


class JointStateBag:
    """A bag's joint states of two pulleys. A context manager.

    Parameters
    ----------
    path : Path
        A rosbag2 directory (MCAP or sqlite3), or a bare .mcap or .db3 file.
    driver, driven : Joint
        Which joints are the pulleys.
    topic : str, optional
        Needed where several topics carry joint states of both pulleys.

    Attributes
    ----------
    topic : str
        The topic read.
    count : int
        Number of messages on it.
    note : str
        What of the bag is lost; empty if nothing is.
    joints_seen : list of str
        Names in the first message read.

    Raises
    ------
    BagError
        If the bag cannot be read, or it is not clear which topic to read.
    """

    def __init__(self, path: Path, driver: Joint, driven: Joint, topic: str | None = None) -> None:
        self.path = path
        self._driver = driver
        self._driven = driven
        self.joints_seen: list[str] = []
        self._sources = open_sources(path)
        try:
            self._types = self._joint_state_types()
            self.topic = self._choose(topic)
        except BaseException:
            self.close()
            raise
        self.note = " ".join(source.note for source in self._sources if source.note)
        self.count = sum(item.messages for item in self._topics() if item.name == self.topic)
        self.joints_seen = []  # of the topic chosen, not of those looked into

    def __enter__(self) -> "JointStateBag":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Release the files."""
        close_all(self._sources)

    def samples(self) -> Iterator[JointSample]:
        """Yield every message on the topic, in bag order; memory stays flat."""
        for log_ns, data in self._raw(self.topic):
            yield JointSample(log_ns, self._read(data))

    def serialised(self) -> Iterator[tuple[int, bytes]]:
        """Yield log time [ns] and bytes of every message on the topic, in bag order."""
        yield from self._raw(self.topic)

    def _topics(self) -> list[Topic]:
        return [topic for source in self._sources for topic in source.topics]

    def _raw(self, topic: str) -> Iterator[tuple[int, bytes]]:
        for source in self._sources:
            yield from source.messages(topic)

    def _joint_state_types(self) -> Typestore:
        """Take the type from the bag; from ROS 2 Jazzy for bags that carry no definitions."""
        for topic in self._topics():
            if topic.type_name == JOINT_STATE and topic.definition:
                with damage_reported(self.path, _BROKEN_TYPE):
                    types = get_typestore(Stores.EMPTY)
                    types.register(get_types_from_msg(topic.definition, JOINT_STATE))
                return types
        return get_typestore(Stores.ROS2_JAZZY)

    def _choose(self, wanted: str | None) -> str:
        found = {topic.name for topic in self._topics() if topic.type_name == JOINT_STATE}
        filled = {topic.name for topic in self._topics() if topic.messages and topic.name in found}
        candidates = sorted(filled or found)
        if wanted is not None:
            if wanted in found:
                return wanted
            raise BagError(
                f"{self.path}: no joint states on {wanted}. {self._offer(sorted(found))}"
            )
        if not candidates:
            raise BagError(
                f"{self.path}: no topic of type sensor_msgs/JointState. {self._contents()}"
            )
        if len(candidates) > 1:
            candidates = [name for name in candidates if self._carries_pulleys(name)] or candidates
        if len(candidates) > 1:
            raise BagError(
                f"{self.path}: {len(candidates)} topics carry joint states. "
                f"{self._offer(candidates)}"
            )
        return candidates[0]

    def _offer(self, names: list[str]) -> str:
        return f"Choose one with --topic: {', '.join(names)}." if names else self._contents()

    def _contents(self) -> str:
        names = sorted({f"{topic.name} [{topic.type_name}]" for topic in self._topics()})
        shown = ", ".join(names[:10]) + (", ..." if len(names) > 10 else "")
        return f"The bag holds: {shown or 'no topics'}. Record joint states with the drive running."

    def _carries_pulleys(self, topic: str) -> bool:
        _, data = next(self._raw(topic), (0, b""))
        content = self._read(data)
        return isinstance(content, Measurement)

    def _read(self, data: bytes) -> Measurement | Rejection:
        try:
            message: Any = self._types.deserialize_cdr(data, JOINT_STATE)
        except (SerdeError, ValueError, IndexError):
            return Rejection.MALFORMED
        if not self.joints_seen:
            self.joints_seen = list(message.name)
        stamp = message.header.stamp
        if len(message.name) > _MOST_JOINTS or stamp.sec < 0 or stamp.nanosec >= _SECOND_NS:
            return Rejection.MALFORMED
        return measurement_from_joints(
            self._driver,
            self._driven,
            stamp.sec * _SECOND_NS + stamp.nanosec,
            message.name,
            message.velocity,
            message.effort,
            message.position,
        )
