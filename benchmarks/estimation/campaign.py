"""Many runs, several at a time; what a results file already holds is not run again."""

import multiprocessing
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any, NamedTuple

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from benchmarks.estimation import store
from benchmarks.estimation.judged import Row


class Job(NamedTuple):
    """One run: what is to be called, in another process, and the rows that it will give."""

    method: str
    case: str
    seed: int
    call: Callable[..., list[Row]]
    arguments: tuple[Any, ...]


def run(jobs: list[Job], path: Path, workers: int, description: str) -> list[Row]:
    """Run the jobs that `path` does not hold yet; return all its rows."""
    done = {(row.method, row.case, row.seed) for row in store.load(path)}
    missing = [job for job in jobs if (job.method, job.case, job.seed) not in done]
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeRemainingColumn()) as progress:
        task = progress.add_task(description, total=len(jobs), completed=len(jobs) - len(missing))
        context = multiprocessing.get_context("spawn")  # the progress bar has a thread
        with ProcessPoolExecutor(workers, context) as pool:
            futures = [pool.submit(job.call, *job.arguments) for job in missing]
            try:
                for future in as_completed(futures):
                    store.append(path, future.result())
                    progress.advance(task)
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise
    return store.load(path)
