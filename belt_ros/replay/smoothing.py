"""The bag with hindsight: what the smoother says of it, in the order of time.

The smoother gives the newest first, so its rows go to a spool from which they are read backwards.
"""

import dataclasses
import tempfile
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import NamedTuple

import numpy as np

from belt_ros.estimation import Quantity
from belt_ros.estimation.hindsight import HindsightEstimate, HindsightReader
from belt_ros.estimation.smoother import Smoother
from belt_ros.estimation.tape import Record, Tape
from belt_ros.replay.errors import ResultsError

_IN_MEMORY = 16_000_000  # [bytes]
_ROW = 0


class SmoothedRow(NamedTuple):
    """What is known of one moment with hindsight, as flat fields named as in belt_msgs."""

    stamp_ns: int
    resets: int  # how often time had jumped back before
    fields: dict[str, float]


def _names() -> Iterator[str]:
    for field in dataclasses.fields(HindsightEstimate):
        if field.name != "stamp_ns":
            yield field.name
            if field.type is Quantity:
                yield f"{field.name}_stddev"


SMOOTHED_FIELDS = tuple(_names())


def no_room_for_hindsight(error: OSError) -> ResultsError:
    """Return which disk it is on which the smoother finds no room."""
    return ResultsError(
        f"{tempfile.gettempdir()}: no room for what smoothing keeps there, some 40 MB for an hour "
        f"of the bag ({error.strerror or error}). Make room, set TMPDIR to another place, or leave "
        "smoothing out with --no-smooth."
    )


def smoothed_rows(
    smoother: Smoother, reader: HindsightReader, told: Callable[[int], None]
) -> Iterator[SmoothedRow]:
    """Yield what a smoother says after the last measurement, the oldest first.

    `told` is called with the number of moments smoothed so far. Memory stays flat.

    Raises
    ------
    ResultsError
        If there is no room for temporary files.
    """
    with closing(Tape(_IN_MEMORY)) as spool:
        for count, smoothed in enumerate(smoother.smoothed(), 1):
            values = _values(reader.read(smoothed))
            try:
                spool.append(Record(_ROW, smoothed.stamp_ns, values))
            except OSError as error:
                raise no_room_for_hindsight(error) from error
            told(count)
        resets, before_ns = 0, None
        for _, stamp_ns, values in spool.backwards():
            resets += before_ns is not None and stamp_ns < before_ns
            before_ns = stamp_ns
            yield SmoothedRow(
                stamp_ns, resets, dict(zip(SMOOTHED_FIELDS, values.tolist(), strict=True))
            )


def _values(estimate: HindsightEstimate) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Values of `SMOOTHED_FIELDS`."""
    values: list[float] = []
    for field in dataclasses.fields(estimate):
        value = getattr(estimate, field.name)
        if field.name != "stamp_ns":
            values += value if field.type is Quantity else [value]
    return np.array(values)
