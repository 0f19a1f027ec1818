"""Timing on one core: medians of repeats, processor time beside wall time."""

import statistics
import time
from collections.abc import Callable
from typing import NamedTuple


class Seconds(NamedTuple):
    """Time that something took [s]."""

    processor: float
    wall: float


def timed(call: Callable[[], object]) -> Seconds:
    """Run once."""
    processor, wall = time.process_time(), time.perf_counter()
    call()
    return Seconds(time.process_time() - processor, time.perf_counter() - wall)


def median_time(call: Callable[[], object], repeats: int, *, warm: bool = False) -> Seconds:
    """Return the medians of `repeats` runs, after one that is not counted unless it is `warm`."""
    if not warm:
        call()
    runs = [timed(call) for _ in range(repeats)]
    return Seconds(*(statistics.median(values) for values in zip(*runs, strict=True)))
