"""A fleet: every bag replayed once, whatever happens, and what all of them say together."""

import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from belt_ros.fleet.cluster import run_on_cluster
from belt_ros.fleet.errors import FleetError
from belt_ros.fleet.files import alone_in
from belt_ros.fleet.page import write_page
from belt_ros.fleet.processes import run_in_processes
from belt_ros.fleet.records import Row, configuration_hash
from belt_ros.fleet.table import write_tables
from belt_ros.fleet.trends import DriveTrend, trends
from belt_ros.fleet.work import Done, Job
from belt_ros.replay.bags import Tell, find_bags, size_of
from belt_ros.replay.drives import load_drives

BAGS_NAME = "bags"
ATTEMPTS = 3
"""How often a bag is tried whose worker dies of it."""

Progress = Callable[[float, float], None]

__all__ = ["FleetError", "FleetResult", "run_fleet"]


@dataclass(frozen=True)
class FleetResult:
    """What came of a fleet.

    Attributes
    ----------
    out : Path
        With ``fleet.parquet``, ``fleet.csv`` and ``fleet.html``, and a directory of results for
        each bag below ``bags/``.
    rows : tuple of Row
        One for each bag and drive, in the order of the bags.
    trends : tuple of DriveTrend
        The drive with the worst margin first.
    done, skipped : int
        Bags replayed now, and finished before.
    """

    out: Path
    rows: tuple[Row, ...]
    trends: tuple[DriveTrend, ...]
    done: int
    skipped: int

    @property
    def failed(self) -> int:
        """How many of `rows` have no result."""
        return sum(trend.failed for trend in self.trends)


def run_fleet(
    bags: Iterable[str | Path],
    config: str | Path,
    out: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    smooth: bool = True,
    topic: str | None = None,
    attempts: int = ATTEMPTS,
    progress: Progress | None = None,
    tell: Tell | None = None,
) -> FleetResult:
    """Replay many bags, and sum up what they say of each drive over the months.

    Run again, it goes on where it was: a bag is known by a hash of its content and configuration.
    Results of a bag appear complete or not at all. A worker that dies costs only the bag it was at,
    which is tried again. Interrupted, it leaves what is finished. Long bags come first.

    Parameters
    ----------
    bags : iterable of path
        Bags, directories of bags, patterns.
    config : path
        YAML of one drive or of several.
    out : path
        Directory of all results.
    workers : int, optional
        Processes on this machine; by default one for each core.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers are used instead; they must see the same files
        under the same names.
    smooth : bool
        Whether to say what is known with hindsight, too.
    topic : str, optional
        As in `belt_ros.replay.replay`.
    attempts : int
        How often a bag is tried whose worker dies of it.
    progress : callable, optional
        Given the bags done, parts of one included, and their number, now and then.
    tell : callable, optional
        Given lines for the user.

    Raises
    ------
    BagError
        If a pattern matches nothing, or no bag.
    SettingsError
        If the description cannot be used.
    FleetError
        If results cannot be written, or the cluster cannot be used.
    """
    if attempts < 1 or (workers is not None and workers < 1):
        raise FleetError("there is at least one worker, and at least one attempt")
    drives = load_drives(config)
    folder = Path(out).absolute()
    configuration = configuration_hash(drives, smooth=smooth, topic=topic)
    jobs = [
        Job(bag.absolute(), drives, folder / BAGS_NAME, configuration, smooth, topic)
        for bag in find_bags(bags, tell=tell)
    ]
    # A long bag begun last would keep one worker at it while all others have nothing to do.
    longest = sorted(jobs, key=lambda job: size_of(job.bag), reverse=True)
    told = _Progress(len(jobs), progress)
    finished: dict[Path, Done] = {}
    with alone_in(folder / BAGS_NAME):
        if scheduler is None:
            count = min(workers or _cores(), len(jobs))
            running = run_in_processes(longest, count, attempts, told.part)
        else:
            running = run_on_cluster(longest, scheduler, attempts)
        with closing(running):
            for job, done in running:
                finished[job.bag] = done
                told.whole(job)
        return _summed_up(folder, [finished[job.bag] for job in jobs])


def _cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0))


class _Progress:
    """Adds up what is done of every bag."""

    def __init__(self, total: int, progress: Progress | None) -> None:
        self._total = total
        self._progress = progress
        self._done = 0
        self._parts: dict[Path, float] = {}

    def part(self, job: Job, share: float) -> None:
        """Take in how much of a bag is done."""
        self._parts[job.bag] = share
        self._tell()

    def whole(self, job: Job) -> None:
        """Take in that a bag is done."""
        self._parts.pop(job.bag, None)
        self._done += 1
        self._tell()

    def _tell(self) -> None:
        if self._progress is not None:
            self._progress(self._done + sum(self._parts.values()), self._total)


def _summed_up(folder: Path, finished: Sequence[Done]) -> FleetResult:
    rows = tuple(row for done in finished for row in done.rows)
    over_all = trends(rows)
    write_tables(folder, rows)
    write_page(folder, rows, over_all)
    skipped = sum(done.skipped for done in finished)
    return FleetResult(
        out=folder,
        rows=rows,
        trends=over_all,
        done=len(finished) - skipped,
        skipped=skipped,
    )
