"""SQLite files as recorders leave them: with a write-ahead log, and under any name.

rosbags opens them as immutable, so that nothing is written beside them, and a log is not read. It
holds the newest messages where a recorder was killed. SQLite would read it, but makes files beside
it, and cannot where the place is read-only: so a copy of both is opened.
"""

import shutil
import sqlite3
import tempfile
from collections.abc import Mapping
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

from rosbags.rosbag2 import Reader
from rosbags.rosbag2.reader import DirectoryReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

from belt_ros.replay.errors import BagError

_OF_URIS = "#?%"  # rosbags makes a URI of a name as it stands
_NAME = "bag.db3"


def log_of(file: Path) -> Path | None:
    """Return the write-ahead log of a storage file; None if there is nothing in any."""
    log = file.with_name(f"{file.name}-wal")
    return log if file.suffix == ".db3" and log.is_file() and log.stat().st_size else None


class SqliteFile(Sqlite3Reader):
    """A .db3 file, read through another one where rosbags could not read all of it."""

    def open(self) -> None:
        """Open it, or what stands for it."""
        self._made = ExitStack()
        with self._made as made:
            self.path = _readable(Path(str(self.path)), made)
            super().open()
            self._made = made.pop_all()

    def close(self) -> None:
        """Release it, and remove what stands for it."""
        with self._made:
            super().close()


class _Directory(DirectoryReader):
    STORAGE_PLUGINS: Mapping[str, Any] = {
        **DirectoryReader.STORAGE_PLUGINS,
        "sqlite3": SqliteFile,
    }


class BagReader(Reader):
    """The reader of rosbags, but for SQLite files."""

    STORAGE_PLUGINS: Mapping[str, Any] = {
        **Reader.STORAGE_PLUGINS,
        "dir": _Directory,
        ".db3": SqliteFile,
    }


def _readable(file: Path, made: ExitStack) -> Path:
    """Return what to open for a file; what has to be made for that is removed by `made`."""
    log = log_of(file)
    if log is None and not set(str(file)) & set(_OF_URIS):
        return file
    try:
        place = Path(made.enter_context(tempfile.TemporaryDirectory())) / _NAME
        if log is None:
            place.symlink_to(file.absolute())
        else:
            _copy(file, log, place)
    except (OSError, sqlite3.OperationalError) as error:
        raise BagError(
            f"{file}: cannot be read by way of {tempfile.gettempdir()} ({_reason(error)}). "
            "Make room there for a copy of it, or set TMPDIR to another place."
        ) from error
    return place


def _copy(file: Path, log: Path, place: Path) -> None:
    """Make one file of a file and its log."""
    shutil.copyfile(file, place)
    shutil.copyfile(log, place.with_name(f"{place.name}-wal"))
    with closing(sqlite3.connect(place)) as database:
        database.execute("PRAGMA journal_mode=DELETE")  # takes in the log


def _reason(error: Exception) -> str:
    return (isinstance(error, OSError) and error.strerror) or str(error)
