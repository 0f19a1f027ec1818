"""Which bags a user means by names, directories and patterns."""

import glob
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path

from belt_ros.replay.errors import BagError
from belt_ros.replay.sqlite_files import log_of

_STORAGE = (".mcap", ".db3")
_COMPRESSED = ".zstd"
_METADATA = "metadata.yaml"
_MOST_NAMED = 5
_RESULTS = ("summary.json", "record.json", "fleet.json")
Tell = Callable[[str], None]


def find_bags(given: Iterable[str | Path], *, tell: Tell | None = None) -> list[Path]:
    """Return the bags that are meant, each once, in the order given; those of a pattern sorted.

    A directory is a bag if it has a metadata.yaml, or nothing but storage files numbered as parts
    of one; else it stands for all bags below it. Results of this package are passed over. What is
    given by name is returned whether or not it is a bag: who reads it says what is wrong with it.
    What a pattern matches beside bags is left alone.

    Parameters
    ----------
    given : iterable of path
    tell : callable, optional
        Given a line for the user on what is left alone.

    Raises
    ------
    BagError
        If a pattern matches nothing, or no bag.
    """
    told = tell or (lambda _line: None)
    found = chain.from_iterable(_meant(str(each), told) for each in given)
    unique = {path.resolve(): path for path in found}
    # Files of a bag that is meant as a whole: a pattern may match both.
    return [path for place, path in unique.items() if place.parent not in unique]


def result_names(bags: Sequence[Path]) -> list[str]:
    """Return a name for the results of each bag: its own, after its folders' where that is taken.

    Raises
    ------
    BagError
        If two bags cannot be told apart by that.
    """
    whole = [bag.resolve() for bag in bags]
    parts = [(*p.parent.parts[1:], p.name if p.is_dir() else p.stem) for p in whole]
    depths = [1] * len(parts)
    while True:
        names = ["_".join(part[-depth:]) for part, depth in zip(parts, depths, strict=True)]
        times = Counter(names)
        twice = [at for at, name in enumerate(names) if times[name] > 1]
        if not twice:
            return names
        if all(depths[at] == len(parts[at]) for at in twice):
            raise BagError(f"{bags[twice[0]]} and {bags[twice[1]]}: rename one, or replay it alone")
        for at in twice:
            depths[at] = min(depths[at] + 1, len(parts[at]))


def _meant(text: str, tell: Tell) -> list[Path]:
    path = Path(text).expanduser()
    if path.exists() or not glob.has_magic(text):
        return _bags_at(path) or [path]
    root = Path(path.anchor)
    matching = root.glob(str(path.relative_to(root))) if path.name else ()
    matches = sorted(match for match in matching if _hidden(match) <= _hidden(path))
    if not matches:
        raise BagError(f"{text}: nothing matches it. Check the pattern.")
    found = {match: _bags_at(match) for match in matches}
    others = [match.name for match, bags in found.items() if not bags]
    named = ", ".join(others[:_MOST_NAMED]) + (", ..." if len(others) > _MOST_NAMED else "")
    if len(others) == len(matches):
        raise BagError(f"{text}: nothing that matches it is a bag: {named}. Check the pattern.")
    if others:
        share = f"{len(others)} of {len(matches)} matches"
        tell(f"{text}: {share} are no bags and are left alone: {named}")
    return list(chain.from_iterable(found.values()))


def _hidden(path: Path) -> int:
    """Return how many parts of a path are hidden, as is what a run that was killed has left."""
    return sum(part.startswith(".") for part in path.parts)


def _bags_at(path: Path) -> list[Path]:
    """Return the bag that is at a path, or those below it."""
    if not path.is_dir():
        return [path] if path.suffix in _STORAGE else []
    return [path] if _is_bag(path) else list(_below(path))


def _below(folder: Path) -> Iterator[Path]:
    """Yield the bags below a directory that is none itself."""
    entries = sorted(folder.iterdir())
    if any(entry.name in _RESULTS for entry in entries):
        return
    for entry in entries:
        if entry.name.startswith("."):
            continue
        if entry.is_dir():
            if _is_bag(entry):
                yield entry
            else:
                yield from _below(entry)
        elif entry.suffix in _STORAGE:
            yield entry


def _is_bag(folder: Path) -> bool:
    if (folder / _METADATA).is_file():
        return True
    entries = list(folder.iterdir())
    parts = [re.fullmatch(r"(.+)_(\d+)", file.stem) for file in entries if file.suffix in _STORAGE]
    if not parts or any(entry.is_dir() for entry in entries):
        return False
    names = {part[1] if part else "" for part in parts}
    numbers = sorted(int(part[2]) for part in parts if part)
    return names == {folder.name} or (len(names) == 1 and numbers == list(range(len(parts))))


def files_of(bag: Path) -> list[Path]:
    """Return the files that make up a bag, sorted; those that are read or say how to read them."""
    files = [bag] if bag.is_file() else [file for file in bag.iterdir() if _is_part(file)]
    logs = (log_of(file) for file in files)
    return sorted([*files, *(log for log in logs if log is not None)])


def _is_part(file: Path) -> bool:
    known = file.name == _METADATA or file.suffix in (*_STORAGE, _COMPRESSED)
    return known and file.is_file()


def size_of(bag: Path) -> int:
    """Return how many bytes a bag takes; 0 if that cannot be said."""
    try:
        return sum(file.stat().st_size for file in files_of(bag))
    except OSError:
        return 0
