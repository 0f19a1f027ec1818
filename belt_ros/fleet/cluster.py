"""Work shared between the workers of a Dask cluster, which see the same files."""

from collections.abc import Generator, Iterator, Sequence
from importlib import import_module
from typing import Any

from belt_ros.fleet.errors import FleetError
from belt_ros.fleet.work import Done, Job, do_job, failed

_PATIENCE = 30.0  # [s] to reach the scheduler


def run_on_cluster(
    jobs: Sequence[Job], address: str, attempts: int
) -> Generator[tuple[Job, Done], None, None]:
    """Yield every job with what came of it, as soon as it is done.

    A job whose worker dies is given to another by the scheduler, as often as that is configured to
    (``distributed.scheduler.allowed-failures``), and again by us, at most `attempts` times in all.

    Parameters
    ----------
    jobs : sequence of Job
    address : str
        Of the scheduler, e.g. ``tcp://head:8786``.
    attempts : int

    Raises
    ------
    FleetError
        If Dask is not installed, the scheduler cannot be reached, or it is lost.
    """
    try:
        distributed: Any = import_module("distributed")
    except ImportError as error:
        raise FleetError(
            "a cluster needs Dask: pip install belt_ros[fleet], here and on its workers"
        ) from error
    try:
        client = distributed.Client(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise FleetError(f"{address}: no Dask scheduler can be reached there ({error})") from error
    with client:
        yield from _results(distributed, client, jobs, attempts)


def _results(
    distributed: Any, client: Any, jobs: Sequence[Job], attempts: int
) -> Iterator[tuple[Job, Done]]:
    # Not pure: what is done is known by its record on disk, not by the scheduler's memory.
    tried = {client.submit(do_job, job, pure=False): (job, 1) for job in jobs}
    completed = distributed.as_completed(list(tried), loop=client.loop)
    for future in completed:
        job, attempt = tried.pop(future)
        error = future.exception() if future.status == "error" else None
        if future.status == "finished":
            yield job, future.result()
        elif type(error).__name__ == "KilledWorker" and attempt < attempts:
            again = client.submit(do_job, job, pure=False)
            tried[again] = job, attempt + 1
            completed.add(again)
        else:
            yield job, failed(job, f"{job.bag}: {error or future.status}")
        future.release()
