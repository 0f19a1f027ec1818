"""Messages of a running graph into a rosbag2 MCAP bag, byte for byte as they came."""

from pathlib import Path
from types import TracebackType

from rosbags.rosbag2 import StoragePlugin, Writer

from belt_ros.message_types import belt_typestore


class Recorder:
    """Write serialised messages to a new bag.

    Parameters
    ----------
    path : Path
        Directory of the bag; it must not exist yet.
    topics : dict of str
        Type name, e.g. ``belt_msgs/msg/BeltState``, of each topic.
    """

    def __init__(self, path: Path, topics: dict[str, str]) -> None:
        self._writer = Writer(path, version=8, storage_plugin=StoragePlugin.MCAP)
        self._writer.open()
        store = belt_typestore()
        self._connections = {
            topic: self._writer.add_connection(topic, kind, typestore=store)
            for topic, kind in topics.items()
        }
        self.counts = dict.fromkeys(topics, 0)

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._writer.close()

    def write(self, topic: str, received_ns: int, content: bytes) -> None:
        """Add one message as it came at `received_ns` [ns]."""
        self._writer.write(self._connections[topic], received_ns, content)
        self.counts[topic] += 1
