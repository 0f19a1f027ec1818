"""Joint states of a bag as measurements, one at a time and in the order of their log time."""

from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from belt_ros.drive_inputs import JOINT_STATE, InputKind, feeds
from belt_ros.estimation import Joint, Measurement, Rejection
from belt_ros.replay.contents import Contents
from belt_ros.replay.discovery import find_joint_states


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
        self.joints_seen: list[str] = []
        self._contents = Contents(path)
        (self._feed,) = feeds(InputKind.JOINT_STATE, "", (driver, driven), loads=False)
        try:
            self.topic = find_joint_states(self._contents, (driver, driven), topic)
            self._reader = self._contents.reader(JOINT_STATE, self._feed.fields)
        except BaseException:
            self.close()
            raise
        self.note = self._contents.note
        self.count = self._contents.count((self.topic,))

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
        self._contents.close()

    def samples(self) -> Iterator[JointSample]:
        """Yield every message on the topic, in bag order; memory stays flat."""
        for log_ns, data in self.serialised():
            yield JointSample(log_ns, self._read(data))

    def serialised(self) -> Iterator[tuple[int, bytes]]:
        """Yield log time [ns] and bytes of every message on the topic, in bag order."""
        for _, log_ns, data in self._contents.messages((self.topic,)):
            yield log_ns, data

    def _read(self, data: bytes) -> Measurement | Rejection:
        message = self._reader.read(data)
        if message is None:
            return Rejection.MALFORMED
        if not self.joints_seen:
            self.joints_seen = list(message.name)
        return self._feed.read(message, 0)
