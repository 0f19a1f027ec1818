"""Folders that only one fleet works in."""

import fcntl
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from belt_ros.appearing import PART
from belt_ros.fleet.errors import FleetError

_LOCK = ".lock"


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Keep others out of a folder, and clear away what a run that was killed has left there.

    Raises
    ------
    FleetError
        If another fleet works there, or it cannot be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = (folder / _LOCK).open("a", encoding="utf-8")
    except OSError as error:
        raise FleetError(f"cannot write to {folder}: {error.strerror or error}") from error
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise FleetError(f"{folder}: another fleet is being run there") from error
        _clear_parts(folder)
        try:
            yield
        finally:
            _clear_parts(folder)


def _clear_parts(folder: Path) -> None:
    for part in folder.glob(f".*{PART}"):
        shutil.rmtree(part, ignore_errors=True)
