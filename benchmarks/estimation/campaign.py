"""Many runs, several at a time; what a results file already holds is not run again."""

import multiprocessing
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from benchmarks.estimation import store
from benchmarks.estimation.judged import Row
from benchmarks.estimation.store import Format


class Keyed(Protocol):
    """What every row of results says of itself."""

    @property
    def method(self) -> str:
        """What was run."""

    @property
    def case(self) -> str:
        """On which drive and load."""

    @property
    def seed(self) -> int:
        """With which random numbers."""

    @property
    def sources(self) -> str:
        """Digest of the code that was judged."""


_Row = TypeVar("_Row", bound=Keyed)


@dataclass(frozen=True)
class Task(Generic[_Row]):
    """One run: what is to be called, in another process, and the rows that it will give."""

    method: str
    case: str
    seed: int
    call: Callable[..., list[_Row]]
    arguments: tuple[Any, ...]


Job = Task[Row]


def run(
    jobs: list[Task[_Row]], path: Path, workers: int, description: str, form: Format[_Row]
) -> list[_Row]:
    """Run the jobs that `path` does not hold yet; return all its rows."""
    done = {(row.method, row.case, row.seed) for row in store.load(path, form)}
    missing = [job for job in jobs if (job.method, job.case, job.seed) not in done]
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeRemainingColumn()) as progress:
        task = progress.add_task(description, total=len(jobs), completed=len(jobs) - len(missing))
        context = multiprocessing.get_context("spawn")  # the progress bar has a thread
        with ProcessPoolExecutor(workers, context) as pool:
            futures = [pool.submit(job.call, *job.arguments) for job in missing]
            try:
                for future in as_completed(futures):
                    store.append(path, future.result(), form)
                    progress.advance(task)
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise
    return store.load(path, form)
