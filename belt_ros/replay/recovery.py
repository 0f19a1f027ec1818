"""What is left of an MCAP file that lost its end, or a part of its middle.

Every seeking reader needs the index at the end of the file. Here the file is read from its
beginning, and every chunk that is whole and passes its checksum is used.
"""

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, TypeGuard

from mcap.exceptions import McapError
from mcap.records import Channel, Chunk, DataEnd, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

from belt_ros.replay.errors import BagError
from belt_ros.replay.sources import Topic, Wanted

_LARGEST_RECORD = 2**30  # [bytes] beyond it, a length is taken for damage


class RecoveredMcap:
    """All whole chunks of a damaged MCAP file, in file order.

    Raises
    ------
    BagError
        If not a single message can be read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._damaged_chunks = 0
        self._whole_bytes = 0
        self._ended = False  # as a writer ends a file that it completes
        self.end_ns = 0
        counts: dict[int, int] = {}
        for message in self._scan():
            self.end_ns = max(self.end_ns, message.log_time)
            counts[message.channel_id] = counts.get(message.channel_id, 0) + 1
        if not counts:
            raise BagError(
                f"{path}: not one whole chunk of messages is left in it. "
                "Copy it again from where it was recorded."
            )
        self.topics = [self._topic(channel, count) for channel, count in counts.items()]
        self.note = self._describe(sum(counts.values()))

    def _topic(self, channel_id: int, count: int) -> Topic:
        channel = self._channels[channel_id]
        schema = self._schemas.get(channel.schema_id)
        if schema is None:
            return Topic(channel.topic, "", "", count)
        text = schema.data.decode(errors="replace") if schema.encoding == "ros2msg" else ""
        return Topic(channel.topic, schema.name, text, count)

    def _type_of(self, channel: Channel) -> str:
        """Return the type of a channel's messages; "" where that is lost."""
        schema = self._schemas.get(channel.schema_id)
        return "" if schema is None else schema.name

    def _describe(self, count: int) -> str:
        lost = self._path.stat().st_size - self._whole_bytes
        parts = [f"{self._path.name} is damaged: {count} messages recovered"]
        if not self._ended:
            parts.append(f"the last {lost} bytes and whatever was never written are lost")
        if self._damaged_chunks:
            parts.append(f"{self._damaged_chunks} chunks are unreadable and left out")
        return ", ".join(parts) + "."

    def messages(self, wanted: Wanted) -> Iterator[tuple[str, int, bytes]]:
        """Yield topic, log time [ns] and CDR bytes of every recovered message that is wanted."""
        for message in self._scan():
            channel = self._channels[message.channel_id]
            if wanted.get(channel.topic) == self._type_of(channel):
                yield channel.topic, message.log_time, message.data

    def close(self) -> None:
        """Nothing stays open between passes."""

    def _scan(self) -> Iterator[Message]:
        """Pass through the file; messages in order of log time within each chunk."""
        self._damaged_chunks = 0
        with self._path.open("rb") as file:
            for record in self._records(file):
                contents = self._contents(record) if isinstance(record, Chunk) else [record]
                messages = [item for item in contents if self._is_readable(item)]
                yield from sorted(messages, key=lambda message: message.log_time)

    def _records(self, file: BinaryIO) -> Iterator[McapRecord]:
        """Top-level records up to the first one that is cut off."""
        stream = StreamReader(file, emit_chunks=True, record_size_limit=_LARGEST_RECORD)
        records = stream.records
        while True:
            try:
                record = next(records)
            except (
                StopIteration,
                McapError,
                struct.error,
                ValueError,
                ArithmeticError,
                MemoryError,
            ):
                return
            if isinstance(record, DataEnd):
                self._ended = True
                return
            self._whole_bytes = file.tell()
            yield record

    def _contents(self, chunk: Chunk) -> list[McapRecord]:
        try:
            return breakup_chunk(chunk, validate_crc=True)
        # Decompressors raise classes of their own.
        except Exception:  # noqa: BLE001
            self._damaged_chunks += 1
            return []

    def _is_readable(self, record: McapRecord) -> TypeGuard[Message]:
        """Note schemas and channels on the way; a message needs its channel to be read."""
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel):
            self._channels[record.id] = record
        return isinstance(record, Message) and record.channel_id in self._channels
