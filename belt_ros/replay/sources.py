"""Where messages come from: a whole bag, its files one by one, or what is left of a broken one."""

import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple, Protocol

from rosbags.interfaces import MessageDefinitionFormat

from belt_ros.replay.errors import BagError, DamagedInsideError, damage_reported
from belt_ros.replay.sqlite_files import BagReader

_NOT_A_BAG = (
    "Give a rosbag2 directory (with metadata.yaml), an .mcap or a .db3 file; if it is one, it is "
    "damaged: copy it again from where it was recorded."
)
_DAMAGED_INSIDE = (
    "The recording is damaged inside. Copy it again, or repair it with `mcap recover` and replay "
    "the repaired file."
)
Wanted = Mapping[str, str]
"""Topics by their names, and of which type: one topic may have messages of several."""


class Topic(NamedTuple):
    """One topic of a source. `definition` is empty unless the source carries it as .msg text."""

    name: str
    type_name: str
    definition: str
    messages: int


class Source(Protocol):
    """Messages in the order of their log time."""

    topics: list[Topic]
    note: str  # what is missing; empty if nothing is
    end_ns: int  # log time [ns] of the last message on any topic; 0 without one

    def messages(self, wanted: Wanted) -> Iterator[tuple[str, int, bytes]]:
        """Yield topic, log time [ns] and CDR bytes of every message that is wanted."""

    def close(self) -> None:
        """Release the files."""


class IntactSource:
    """A rosbag2 directory, or a single storage file, as rosbags reads it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._reader = BagReader(path)
        self._reader.open()
        self.note = ""
        self.end_ns = max(self._reader.end_time - 1, 0)  # rosbags says when it is over
        self.topics = [
            Topic(
                connection.topic,
                connection.msgtype,
                connection.msgdef.data
                if connection.msgdef.format is MessageDefinitionFormat.MSG
                else "",
                connection.msgcount,
            )
            for connection in self._reader.connections
        ]

    def messages(self, wanted: Wanted) -> Iterator[tuple[str, int, bytes]]:
        """Yield topic, log time [ns] and CDR bytes of every message that is wanted."""
        chosen = [
            item for item in self._reader.connections if wanted.get(item.topic) == item.msgtype
        ]
        if not chosen:
            return
        # Only reading is watched: what the taker of a message raises does not come through here.
        with damage_reported(self._path, _DAMAGED_INSIDE, DamagedInsideError):
            for connection, log_ns, data in self._reader.messages(chosen):
                yield connection.topic, log_ns, data

    def close(self) -> None:
        """Release the files."""
        self._reader.close()


def open_sources(path: Path, *, salvage: bool = False) -> list[Source]:
    """Open a bag: whole if it is whole, otherwise file by file.

    A recorder that loses power leaves a directory without metadata.yaml and a last MCAP file
    without its index; both are read here. With `salvage` no index is trusted: every MCAP file is
    read chunk by chunk, and what is damaged is left out.

    Raises
    ------
    BagError
        If nothing of it can be read.
    """
    if not path.exists():
        raise BagError(f"{path}: no such file or directory. Check the path.")
    if salvage:
        return _salvaged(path)
    try:
        with damage_reported(path, _NOT_A_BAG):
            return [IntactSource(path)]
    except BagError as error:
        sources = _open_files(_storage_files(path))
        if not sources:
            raise
        if path.is_dir():
            reason = str(error.__cause__).rstrip(".")
            sources[0].note = f"Read file by file: {reason}. {sources[0].note}".rstrip()
        return sources


def close_all(sources: list[Source]) -> None:
    """Release the files of all sources."""
    for source in sources:
        source.close()


def _storage_files(path: Path) -> list[Path]:
    """Storage files at `path`, in the order in which rosbag2 numbers them."""
    if path.is_file():
        return [path] if path.suffix == ".mcap" else []
    files = [file for file in path.iterdir() if file.suffix in (".mcap", ".db3")]

    def number(file: Path) -> tuple[int, str]:
        match = re.search(r"_(\d+)$", file.stem)
        return (int(match[1]) if match else -1), file.name

    return sorted(files, key=number)


def _open_files(files: list[Path], *, salvage: bool = False) -> list[Source]:
    """Open those of `files` in which there is anything; the others become a note."""
    opened = {file.name: _open_file(file, salvage=salvage) for file in files}
    sources = [source for source in opened.values() if source is not None]
    hopeless = [name for name, source in opened.items() if source is None]
    if sources and hopeless:
        note = f"{sources[-1].note} Nothing can be read of {', '.join(hopeless)}."
        sources[-1].note = note.lstrip()
    return sources


def _salvaged(path: Path) -> list[Source]:
    sources = _open_files(_storage_files(path), salvage=True)
    if not sources:
        raise BagError(f"{path}: {_DAMAGED_INSIDE}")
    return sources


def _open_file(file: Path, *, salvage: bool = False) -> Source | None:
    if not (salvage and file.suffix == ".mcap"):
        with suppress(BagError), damage_reported(file, _NOT_A_BAG):
            return IntactSource(file)
    if file.suffix == ".mcap":
        # mcap's record classes are needed for broken files only.
        from belt_ros.replay.recovery import RecoveredMcap  # noqa: PLC0415

        with suppress(BagError):
            return RecoveredMcap(file)
    return None
