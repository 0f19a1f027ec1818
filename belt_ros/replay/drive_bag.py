"""One drive's measurements in a bag, made of whatever topics they came on, as in the live node."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from belt_ros.drive_inputs import (
    FLOAT64,
    JOINT_STATE,
    PULLEY_STATE,
    InputSettings,
    feeds,
    stamp_of,
)
from belt_ros.estimation import Measurement, Rejection
from belt_ros.estimation.assembler import Assembler, Dropped
from belt_ros.estimation.joint_readings import JointReadings
from belt_ros.node_tables import InputKind
from belt_ros.replay.contents import Contents
from belt_ros.replay.discovery import find_inputs, joints_on
from belt_ros.settings import DriveSettings

_MOST_WAITING = 10_000  # as in the live node
_QUIET_NS = 200_000_000  # without a message, after which the live node waits no longer
_SECONDS = 1e-9
_KINDS = {
    JOINT_STATE: InputKind.JOINT_STATE,
    PULLEY_STATE: InputKind.PULLEY_STATE,
    FLOAT64: InputKind.FLOAT64,
}


class Sample(NamedTuple):
    """A measurement, or why there is none; when what led to it was logged, and its age then."""

    log_ns: int
    content: Measurement | Rejection
    age: float  # [s] log time less stamp


class DriveBag:
    """One drive's measurements in a bag. A context manager.

    Parameters
    ----------
    path : Path
        A rosbag2 directory (MCAP or sqlite3), or a bare .mcap or .db3 file.
    settings : DriveSettings
    inputs : InputSettings, optional
        How its measurements arrive; by default as joint states.
    prefix : str
        What the drive's topics begin with, where there are several drives: ``drive_name/``.
    topic : str, optional
        The topic of joint states, or the namespace of other topics, where there are several.
    salvage : bool
        Whether it is known to be damaged inside.

    Attributes
    ----------
    topics : tuple of str
        The topics read.
    count : int
        Number of messages on them.
    note : str
        What of the bag is lost, and what was not read as described; empty if there is nothing.

    Raises
    ------
    BagError
        If the bag cannot be read, or it is not clear which topics to read.
    """

    def __init__(
        self,
        path: Path,
        settings: DriveSettings,
        inputs: InputSettings | None = None,
        *,
        prefix: str = "",
        topic: str | None = None,
        salvage: bool = False,
    ) -> None:
        inputs = inputs or InputSettings()
        self.path = path
        self._contents = Contents(path, salvage=salvage)
        try:
            joints = settings.driver, settings.driven
            found = find_inputs(self._contents, inputs, prefix, joints, topic)
            self._readers = [
                self._contents.reader(feed.type_name, feed.fields) for feed in found.feeds
            ]
        except BaseException:
            self.close()
            raise
        self._feeds, self.topics = found.feeds, found.topics
        self._places = {name: place for place, name in enumerate(found.topics)}
        kind = _KINDS[self._feeds[0].type_name]
        self._at_joints = kind is not InputKind.JOINT_STATE
        self._readings = JointReadings(*found.joints)
        # The live node waits for all topics of a kind, whether or not anyone sends them.
        awaited = feeds(kind, prefix, found.joints, loads=inputs.loads)
        self._assembler = Assembler(
            inputs.reorder_window,
            inputs.slop,
            len(awaited),
            _MOST_WAITING,
            inputs.disorder,
            settings.limits.greatest_gap,
        )
        self.note = f"{self._contents.note} {found.note}".strip()
        self._wanted = {
            name: feed.type_name for feed, name in zip(found.feeds, found.topics, strict=True)
        }
        self.count = self._contents.count(self._wanted)

    def __enter__(self) -> "DriveBag":
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

    @property
    def end_ns(self) -> int:
        """Log time [ns] of the last message in the bag, also if it is of others."""
        return self._contents.end_ns

    @property
    def joints_seen(self) -> list[str]:
        """Names of the joints in the first joint states; none if there are no joint states."""
        return [] if self._at_joints else joints_on(self._contents, self.topics[0])

    def samples(self) -> Iterator[Sample]:
        """Yield measurements as soon as the live node would have them; memory stays flat.

        What waits for other topics leaves at the end, and where nothing was logged for a while.
        """
        before_ns: int | None = None
        for topic, log_ns, data in self._contents.messages(self._wanted):
            if before_ns is not None and abs(log_ns - before_ns) > _QUIET_NS:
                yield from self._ready(self._assembler.flush(), before_ns)
            before_ns = log_ns
            yield from self._take(self._places[topic], log_ns, data)
        if before_ns is not None:
            yield from self._ready(self._assembler.flush(), before_ns)

    def _take(self, place: int, log_ns: int, data: bytes) -> Iterable[Sample]:
        feed, message = self._feeds[place], self._readers[place].read(data)
        if message is None:
            return (Sample(log_ns, Rejection.MALFORMED, 0.0),)
        read = feed.read(message, log_ns)
        if read is None:
            return ()
        if not isinstance(read, Rejection):
            return self._ready(self._assembler.add(place, read), log_ns)
        stamp_ns = stamp_of(message) if feed.stamped else log_ns
        age = 0.0 if stamp_ns is None else (log_ns - stamp_ns) * _SECONDS
        return (Sample(log_ns, read, age),)

    def _ready(self, items: Iterable[Measurement | Dropped], log_ns: int) -> Iterator[Sample]:
        for item in items:
            age = (log_ns - item.stamp_ns) * _SECONDS
            if isinstance(item, Dropped):
                yield Sample(log_ns, Rejection.OUT_OF_ORDER, age)
            else:
                measured = self._readings.at_pulleys(item) if self._at_joints else item
                yield Sample(log_ns, measured, age)
