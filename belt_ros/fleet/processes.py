"""Work shared between processes of this machine, any of which may die at any time.

`concurrent.futures` gives up all that is under way when one worker is killed, and does not say
which bag it was at. Here each worker has a pipe of its own, so that exactly its bag is known.
"""

import multiprocessing
import signal
from collections import deque
from collections.abc import Callable, Generator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any, NamedTuple

from belt_ros.fleet.work import Done, Job, do_job, failed

Told = Callable[[Job, float], None]
_START = multiprocessing.get_context("spawn")  # a fork would inherit threads' locks
_PATIENCE = 5.0  # [s] for a worker to end by itself
_STEPS = 100  # of progress within a bag


class _Worker(NamedTuple):
    process: SpawnProcess
    pipe: "Connection[Any, Any]"


class _Task(NamedTuple):
    job: Job
    attempt: int


def run_in_processes(
    jobs: Sequence[Job], workers: int, attempts: int, told: Told
) -> Generator[tuple[Job, Done], None, None]:
    """Yield every job with what came of it, as soon as it is done.

    A job whose worker dies is given to another, last of all, at most `attempts` times.

    Parameters
    ----------
    jobs : sequence of Job
    workers : int
        Number of processes.
    attempts : int
    told : callable
        Called now and then with a job under way, and how much of it is done, as a share.
    """
    waiting = deque(_Task(job, 1) for job in jobs)
    busy: dict[Connection[Any, Any], tuple[_Worker, _Task]] = {}
    try:
        while waiting or busy:
            while waiting and len(busy) < workers:
                _assign(_start(), waiting.popleft(), busy)
            for ready in wait(list(busy)):
                assert isinstance(ready, Connection)
                worker, task = busy[ready]
                message = _received(ready)
                if isinstance(message, float):
                    told(task.job, message)
                    continue
                del busy[ready]
                if message is None:
                    done = _died(worker, task, attempts, waiting)
                else:
                    done = message
                    _go_on(worker, waiting, busy)
                if done is not None:
                    yield task.job, done
    finally:
        for worker, _ in busy.values():
            worker.process.kill()
            _end(worker)


def _start() -> _Worker:
    ours, its = _START.Pipe()
    process = _START.Process(target=_serve, args=(its,), daemon=True)
    process.start()
    its.close()
    return _Worker(process, ours)


def _assign(
    worker: _Worker, task: _Task, busy: "dict[Connection[Any, Any], tuple[_Worker, _Task]]"
) -> None:
    with suppress(OSError):  # who has died is found out when its answer is waited for
        worker.pipe.send(task.job)
    busy[worker.pipe] = worker, task


def _go_on(
    worker: _Worker,
    waiting: "deque[_Task]",
    busy: "dict[Connection[Any, Any], tuple[_Worker, _Task]]",
) -> None:
    if waiting:
        _assign(worker, waiting.popleft(), busy)
    else:
        _end(worker)


def _received(pipe: "Connection[Any, Any]") -> Done | float | None:
    """Return what a worker says; None if it is no more."""
    try:
        message: Done | float = pipe.recv()
    except (EOFError, OSError):
        return None
    return message


def _died(worker: _Worker, task: _Task, attempts: int, waiting: "deque[_Task]") -> Done | None:
    """Try again what a worker died of, unless it has been tried often enough."""
    _end(worker)
    if task.attempt < attempts:
        waiting.append(_Task(task.job, task.attempt + 1))
        return None
    return failed(
        task.job,
        f"{task.job.bag}: its worker ended unexpectedly {attempts} times, the last time with "
        f"exit code {worker.process.exitcode}. Is there enough memory?",
    )


def _end(worker: _Worker) -> None:
    worker.pipe.close()
    worker.process.join(_PATIENCE)
    if worker.process.is_alive():
        worker.process.kill()
        worker.process.join()


def _serve(pipe: "Connection[Any, Any]") -> None:
    """Do jobs until the pipe is closed; interrupting is for the one at its other end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(EOFError, OSError):
        while True:
            job: Job = pipe.recv()
            step = 0

            def progress(done: int, total: int) -> None:
                nonlocal step
                now = _STEPS * done // max(total, 1)
                if now != step:
                    step = now
                    pipe.send(now / _STEPS)

            pipe.send(do_job(job, progress))
