"""One bag's share of the work of a fleet; runs wherever a worker is."""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from belt_ros.appearing import beside, put_in_place
from belt_ros.fleet.records import (
    Row,
    content_hash,
    failed_row,
    read_record,
    row_of,
    write_record,
)
from belt_ros.replay.drives import Described, Outcome, replay_drives


class Job(NamedTuple):
    """One bag, and all that its results depend on. `folder` is where all results are."""

    bag: Path
    drives: tuple[Described, ...]
    folder: Path
    configuration: str
    smooth: bool
    topic: str | None = None

    @property
    def place(self) -> Path:
        """Directory of its results: named as the bag, and told apart by where that lies."""
        mark = hashlib.blake2b(str(self.bag).encode(), digest_size=4).hexdigest()
        return self.folder / f"{self.bag.stem if self.bag.is_file() else self.bag.name}-{mark}"


class Done(NamedTuple):
    """What came of a job. `skipped`: it had been finished before."""

    rows: tuple[Row, ...]
    skipped: bool = False


def failed(job: Job, error: str) -> Done:
    """Return what came of a job that could not be done; nothing of it is kept."""
    return Done(tuple(failed_row(drive.settings.name, job.bag, error) for drive in job.drives))


def do_job(job: Job, progress: Callable[[int, int], None] | None = None) -> Done:
    """Replay one bag, unless that has been done; put its results into place all at once.

    A bag that cannot be used is a result too. What is wrong with the machine is not: it is told,
    and the bag tried again when the fleet is run again.
    """
    try:
        return _do(job, progress)
    except Exception as error:  # noqa: BLE001  one bag must not hinder the others
        return failed(job, f"{job.bag}: {error} ({type(error).__name__})")


def _do(job: Job, progress: Callable[[int, int], None] | None) -> Done:
    key = f"{content_hash(job.bag)}-{job.configuration}" if job.bag.exists() else "missing"
    known = read_record(job.place, key)
    if known is not None:
        return Done(known, skipped=True)
    with beside(job.place, f"{os.getpid()}.") as folder:
        part = Path(folder) / job.place.name
        part.mkdir()
        rows = _rows(job, part, progress)
        if key != "missing":  # it may come
            write_record(part, key, rows)
            put_in_place(part, job.place)
    return Done(rows)


def _rows(job: Job, part: Path, progress: Callable[[int, int], None] | None) -> tuple[Row, ...]:
    outcomes = replay_drives(
        job.bag,
        job.drives,
        part / "results",
        topic=job.topic,
        smooth=job.smooth,
        progress=progress,
    )
    return tuple(_row(job, part, outcome) for outcome in outcomes)


def _row(job: Job, part: Path, outcome: Outcome) -> Row:
    if outcome.summary is None:
        return failed_row(outcome.drive, job.bag, outcome.error)
    place = job.place / outcome.place.relative_to(part)
    return row_of(job.bag, outcome.summary, str(place.relative_to(job.folder.parent)))
