"""A drive's memory file: read when the node is configured, written beside the work.

Dates are those of the wall clock, also where the node runs on simulated time: it is the machine
that ages, and a file outlives a simulation. Nothing that a file holds, or a disk does, raises here.
"""

import math
import shutil
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from belt_ros.estimation import Learned, MemoryRefusedError
from belt_ros.estimation.memory_file import MemoryFileError, load, save

BEFORE_RESET = ".before_reset"
BEFORE_FAILURE = ".before_failure"
_REFUSED = ".refused"
_BEFORE_JUMP = ".before_jump"
_NUMERICAL = (ArithmeticError, np.linalg.LinAlgError)
_UNITS = (("days", 86400.0), ("h", 3600.0), ("min", 60.0))


class Learner(Protocol):
    """Who learns what a memory keeps."""

    @property
    def drive_name(self) -> str:
        """Name of the drive."""

    @property
    def taken_in(self) -> int:
        """Grows with all that is learned."""

    def learned(self, now: float) -> Learned | None:
        """Return what has been learned by wall time `now` [s]; None: nothing yet."""

    def restore(self, learned: Learned, elapsed: float) -> str:
        """Start from what was learned `elapsed` [s] ago; return a note for the log, or ""."""


@dataclass(frozen=True)
class MemoryReport:
    """The state of a memory, for diagnostics.

    Attributes
    ----------
    path : str
    restored_age : float
        Of what the run began with, then [s]; NaN: it began with the priors.
    since_saved : float
        Since what was learned was last written [s]; NaN: not yet.
    saves : int
        How often it was, since the node was configured.
    trouble : str
        Why the file could not be used, or written, or "".
    """

    path: str
    restored_age: float
    since_saved: float
    saves: int
    trouble: str


class _Written(NamedTuple):
    when: float  # on the steady clock [s]
    trouble: str


class Memory:
    """Keeps what one drive has taught from one run to the next.

    The file is written in a thread of its own, so that no measurement waits for a disk.

    Parameters
    ----------
    path : Path
        Of the file, absolute.
    learner : Learner
    warn : callable
        Is told of trouble with the file, in one line, when it begins.
    wall, steady : callable
        Clocks [s]: since the Unix epoch, and one that is never set.
    """

    def __init__(
        self,
        path: Path,
        learner: Learner,
        warn: Callable[[str], object],
        wall: Callable[[], float] = time.time,
        steady: Callable[[], float] = time.monotonic,
    ) -> None:
        self._path = path
        self._learner = learner
        self._warn = warn
        self._wall = wall
        self._steady = steady
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="belt_memory")
        self._writing: Future[_Written] | None = None
        self._kept = learner.taken_in
        self._refused = self._failed = False
        self._restored_age = self._saved_at = math.nan
        self._saves = 0
        self._trouble = ""

    @property
    def trouble(self) -> str:
        """Why the file could not be used, or written, in one line; "" if it could."""
        return self._trouble

    def report(self) -> MemoryReport:
        """Return the present state, without waiting for a write that is under way."""
        if self._writing is not None and self._writing.done():
            self._settle()
        since = self._steady() - self._saved_at
        return MemoryReport(str(self._path), self._restored_age, since, self._saves, self._trouble)

    def restore(self) -> str:
        """Start the learner from the file; return a sentence for the log, "" after a warning.

        A file that cannot be used stays as it is until there is something to write. Then it is
        renamed.
        """
        name, path = self._learner.drive_name, f"{str(self._path)!a}"
        try:
            learned = load(self._path, name)
            if learned is None:
                return f"{name}: no memory yet in {path}"
            age = self._wall() - learned.date
            note = self._learner.restore(learned, age)
        except (MemoryRefusedError, *_NUMERICAL) as error:
            self._refused = True
            reason = error if isinstance(error, MemoryFileError) else f"{path}: {error}"
            self._have_trouble(f"{reason}; starting at the priors, it is to be kept as *{_REFUSED}")
            return ""
        self._restored_age = max(age, 0.0)
        note = note and f"; {note}"
        return f"{name}: restored what was learned {span(self._restored_age)} ago, {path}{note}"

    def save(self) -> None:
        """Begin to write what has been learned since, unless a write is under way."""
        if self._writing is not None and not self._writing.done():
            return
        self._settle()
        taken_in = self._learner.taken_in
        if taken_in == self._kept:
            return
        try:
            learned = self._learner.learned(self._wall())
        except (MemoryRefusedError, *_NUMERICAL) as error:
            self._have_trouble(f"what was learned is not fit to be kept: {error}")
            return
        if learned is not None:
            self._kept = taken_in
            self._writing = self._writer.submit(self._write, learned)

    def finish(self) -> None:
        """Write what has been learned since, and wait until that is done."""
        self._settle()
        self.save()
        self._settle()

    def close(self) -> None:
        """Finish for good."""
        self.finish()
        self._writer.shutdown()

    def forget(self, ending: str = BEFORE_RESET) -> str:
        """Rename the file, so that no run begins with it; return a clause for the log, or "".

        Failures follow each other, such as those of a wrong parameter: what was learned between two
        of them does not take the place of what was learned before the first of a run.
        """
        if ending == BEFORE_FAILURE:
            if self._failed:
                return ""
            self._failed = True
        self._settle()
        self._restored_age = math.nan
        self._kept = self._learner.taken_in
        try:
            kept_as = self._set_aside(ending)
        except (OSError, ValueError) as error:
            self._have_trouble(f"{str(self._path)!a} cannot be renamed: {error}")
            return self._trouble
        return f"what was learned before is kept as {kept_as}" if kept_as else ""

    def copy(self) -> str:
        """Keep the file as it is beside what is to come; return a clause for the log, or "".

        Where time goes back, estimation starts where the run began, and what the file has of this
        run would be overwritten by less.
        """
        self._settle()
        if self._saves == 0 or not self._path.is_file():
            return ""
        copy = self._path.with_name(self._path.name + _BEFORE_JUMP)
        part = copy.with_name(copy.name + ".part")
        try:
            shutil.copyfile(self._path, part)
            part.replace(copy)
        except OSError as error:
            self._have_trouble(f"{str(self._path)!a} cannot be copied: {error}")
            return self._trouble
        return f"what was learned until then is kept as {copy}"

    def _settle(self) -> None:
        """Take note of the last write, waiting for it."""
        if self._writing is None:
            return
        written = self._writing.result()
        self._writing = None
        self._have_trouble(written.trouble)
        if written.trouble:
            self._kept = -1  # so that it is tried again
        else:
            self._saved_at = written.when
            self._saves += 1

    def _have_trouble(self, trouble: str) -> None:
        if trouble and trouble != self._trouble:
            self._warn(trouble)
        self._trouble = trouble

    def _write(self, learned: Learned) -> _Written:
        trouble = ""
        try:
            if self._path.exists() and not self._path.is_file():
                raise MemoryFileError(f"{str(self._path)!a} is no regular file: nothing is kept")
            if self._refused:
                self._set_aside(_REFUSED)
                self._refused = False
            save(learned, self._path)
        except (OSError, ValueError) as error:
            trouble = str(error)
        return _Written(self._steady(), trouble)

    def _set_aside(self, ending: str) -> str:
        """Rename the file, if there is one; return its new name, or ""."""
        if not self._path.is_file():
            return ""
        return str(self._path.replace(self._path.with_name(self._path.name + ending)))


def span(seconds: float) -> str:
    """Return a time in the unit that suits it."""
    for unit, length in _UNITS:
        if seconds >= 2.0 * length:
            return f"{seconds / length:.0f} {unit}"
    return f"{seconds:.0f} s"
