"""One pass through a table of states, in batches, so that memory stays flat.

Time is that of the summary: seconds after the first row, without what was jumped back.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from belt_ros.report.result_directory import ReportError, open_table

Floats = NDArray[np.float64]
_ROWS = 32768
_SECONDS = 1e-9


class Batch(NamedTuple):
    """Some rows of a table; arrays of one length n."""

    elapsed: Floats  # [s]
    step: Floats  # [s] since the row before; 0 for the first and where time jumped back
    log_ns: NDArray[np.int64]  # [ns]; the stamp, where the table has no log time
    columns: Mapping[str, Floats]  # SI


class Tally(Protocol):
    """What is gathered on the way through a table."""

    columns: Sequence[str]  # that it needs

    def add(self, batch: Batch) -> None:
        """Take in the next rows."""


def row_count(table: Path) -> int:
    """Return the number of rows."""
    return int(open_table(table).metadata.num_rows)


def extremes(table: Path, name: str) -> tuple[float, float]:
    """Return the least and the greatest value of a column as its statistics tell; else NaN."""
    metadata = open_table(table).metadata
    names = [metadata.schema.column(i).name for i in range(metadata.num_columns)]
    if name not in names:
        raise ReportError(f"{table} has no column {name}; replay the bag anew")
    place = names.index(name)
    groups = [metadata.row_group(i).column(place) for i in range(metadata.num_row_groups)]
    found = [group.statistics for group in groups if group.is_stats_set]
    bounds = [(stats.min, stats.max) for stats in found if stats.has_min_max]
    if not bounds:
        return np.nan, np.nan
    return float(min(low for low, _ in bounds)), float(max(high for _, high in bounds))


def scan(table: Path, start_ns: int, *tallies: Tally) -> None:
    """Lead `tallies` through a table whose time begins at `start_ns`.

    Raises
    ------
    ReportError
        If the table is damaged, or lacks a column.
    """
    wanted = {name for tally in tallies for name in tally.columns}
    for batch in batches(table, start_ns, sorted(wanted)):
        for tally in tallies:
            tally.add(batch)


def batches(table: Path, start_ns: int, names: Sequence[str]) -> Iterator[Batch]:
    """Yield a table's rows with the columns `names`, and the time since `start_ns`."""
    file = open_table(table)
    present = set(file.schema_arrow.names)
    if missing := sorted({"stamp_ns", *names} - present):
        raise ReportError(f"{table} has no column {missing[0]}; replay the bag anew")
    times = [name for name in ("stamp_ns", "log_time_ns") if name in present]
    before_ns, elapsed_ns = start_ns, 0
    try:
        for record in file.iter_batches(_ROWS, columns=[*times, *names]):
            stamps = record["stamp_ns"].to_numpy().astype(np.int64)
            if not len(stamps):
                continue
            step_ns = np.maximum(np.diff(stamps, prepend=before_ns), 0)
            clock_ns = elapsed_ns + np.cumsum(step_ns)
            before_ns, elapsed_ns = int(stamps[-1]), int(clock_ns[-1])
            columns = {name: _floats(record[name]) for name in names}
            log_ns = record[times[-1]].to_numpy().astype(np.int64)
            yield Batch(clock_ns * _SECONDS, step_ns * _SECONDS, log_ns, columns)
    except (pa.ArrowException, OSError, TypeError, ValueError) as error:
        raise ReportError(f"{table} is damaged: {error}") from error


def _floats(column: pa.Array) -> Floats:
    values = column.to_numpy(zero_copy_only=False)
    return np.asarray(values, dtype=np.float64)
