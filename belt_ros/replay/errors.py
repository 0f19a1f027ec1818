"""What can be wrong with a bag, in one class."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class BagError(Exception):
    """A bag that cannot be used; the message names the file and what to do."""


@contextmanager
def damage_reported(path: Path, advice: str) -> Iterator[None]:
    """Turn whatever a parser makes of damaged bytes into a `BagError` that names `path`."""
    try:
        yield
    except BagError:
        raise
    # Parsers of broken bytes fail as struct.error, TypeError, KeyError, zstd's own and many more.
    except Exception as error:
        reason = str(error).rstrip(".") or type(error).__name__
        raise BagError(f"{path}: {reason}. {advice}") from error
