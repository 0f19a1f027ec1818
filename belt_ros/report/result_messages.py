"""Messages of a result bag, and the time at which they were logged in the run."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader

from belt_ros.message_types import belt_typestore
from belt_ros.replay.errors import BagError, damage_reported
from belt_ros.report.result_directory import ReportError
from belt_ros.report.table_scan import Batch, Floats


def result_messages(bag: Path, kind: str, most: int | None = None) -> Iterator[tuple[int, Any]]:
    """Yield log time [ns] and message of each of one type, in their order; none without a bag.

    Parameters
    ----------
    bag : Path
    kind : str
        Name of the message type.
    most : int, optional
        If there are more, every second, third or so of them is left.

    Raises
    ------
    ReportError
        If the bag is damaged.
    """
    if not bag.exists():
        return
    try:
        with (
            damage_reported(bag, "Replay the bag anew."),
            AnyReader([bag], default_typestore=belt_typestore()) as reader,
        ):
            chosen = [found for found in reader.connections if found.msgtype == kind]
            number = sum(connection.msgcount for connection in chosen)
            step = 1 if most is None else max(-(-number // most), 1)
            raw = reader.messages(chosen) if chosen else ()
            for place, (connection, log_ns, data) in enumerate(raw):
                if place % step == 0:
                    yield log_ns, reader.deserialize(data, connection.msgtype)
    except BagError as error:
        raise ReportError(str(error)) from error


class LogTimes:
    """Puts log times on the time of a table.

    Parameters
    ----------
    log_ns : sequence of int
        [ns], in any order.
    """

    columns: Sequence[str] = ()

    def __init__(self, log_ns: Sequence[int]) -> None:
        self._log_ns = np.array(log_ns, dtype=np.int64)
        self._times: Floats = np.zeros(len(self._log_ns))

    def add(self, batch: Batch) -> None:
        """Take in the next rows: what was logged counts from the row then or the next before."""
        places = np.searchsorted(batch.log_ns, self._log_ns, side="right") - 1
        here = places >= 0
        self._times[here] = batch.elapsed[places[here]]

    @property
    def seconds(self) -> list[float]:
        """Times in the run [s]; 0 for what was logged before its first row."""
        found: list[float] = self._times.tolist()
        return found
