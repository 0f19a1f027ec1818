"""What can be wrong with a bag, and with the place of its results."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rosbags.rosbag2 import ReaderError


class BagError(Exception):
    """A bag that cannot be used; the message names the file and what to do."""


class DamagedInsideError(BagError):
    """A bag that turned out to be damaged while it was being read."""


class ResultsError(Exception):
    """A place where results cannot be written; the message says why."""


@contextmanager
def damage_reported(path: Path, advice: str, kind: type[BagError] = BagError) -> Iterator[None]:
    """Turn whatever a parser makes of damaged bytes into a `BagError` that names `path`."""
    try:
        yield
    except BagError:
        raise
    # Parsers of broken bytes fail as struct.error, TypeError, KeyError, zstd's own and many more.
    except Exception as error:
        told = isinstance(error, ReaderError | OSError)
        reason = str(error).rstrip(".") if told else f"unreadable ({type(error).__name__}: {error})"
        raise kind(f"{path}: {reason}. {advice}") from error
