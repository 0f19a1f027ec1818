"""Files and directories that appear complete or not at all.

What is written lies in a hidden directory beside its place until it is renamed. It has its own name
there, which a bag's files have in theirs, and the permissions of anything new.
"""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PART = ".part"
"""How the names of hidden directories end; of a process that was killed, one may be left."""


def beside(place: Path, mark: str = "") -> "tempfile.TemporaryDirectory[str]":
    """Return a hidden directory beside `place`, whose own parent is made where there is none.

    Parameters
    ----------
    place : Path
    mark : str
        What stands in its name after that of `place`.

    Raises
    ------
    OSError
        If there can be none.
    """
    place.parent.mkdir(parents=True, exist_ok=True)
    return tempfile.TemporaryDirectory(
        prefix=f".{place.name}.{mark}", suffix=PART, dir=place.parent, ignore_cleanup_errors=True
    )


def put_in_place(part: Path, place: Path) -> None:
    """Rename what is complete to `place`, where a file may replace a file, a directory a directory.

    Raises
    ------
    OSError
        If that is not possible; what was at `place` is still there.
    """
    old = part.with_name(f"{part.name}.old")
    if part.is_dir() and place.is_dir():
        place.rename(old)  # which is removed with the hidden directory
    try:
        part.replace(place)
    except OSError:
        if old.exists():
            old.rename(place)
        raise


@contextmanager
def appearing(place: Path) -> Iterator[Path]:
    """Yield where to write a file or directory that is to appear at `place`, unless that fails."""
    with beside(place) as folder:
        part = Path(folder) / place.name
        yield part
        put_in_place(part, place)
