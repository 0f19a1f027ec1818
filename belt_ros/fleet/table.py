"""One table over all bags, as Parquet and as CSV."""

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.csv as pc
import pyarrow.parquet as pq

from belt_ros.appearing import appearing
from belt_ros.fleet.records import Row

_KINDS = {"str": pa.string(), "int": pa.int64(), "float": pa.float64(), "bool": pa.bool_()}
PARQUET_NAME = "fleet.parquet"
CSV_NAME = "fleet.csv"


def write_tables(folder: Path, rows: Sequence[Row]) -> tuple[Path, Path]:
    """Write both tables, each in one go; return where they are.

    Columns are the fields of `Row`, after the start as a date. What is not known is null.
    """
    columns = {
        field.name: pa.array(
            [getattr(row, field.name) for row in rows],
            _KINDS[_type_name(field.type)],
            from_pandas=True,  # NaN is null
        )
        for field in dataclasses.fields(Row)
    }
    start = pa.array([row.start_ns or None for row in rows], pa.timestamp("ns", "UTC"))
    table = pa.table({"start": start, **columns})
    parquet, text = folder / PARQUET_NAME, folder / CSV_NAME
    with appearing(parquet) as part:
        pq.write_table(table, part)
    with appearing(text) as part:
        pc.write_csv(table, part)
    return parquet, text


def _type_name(kind: object) -> str:
    return kind.__name__ if isinstance(kind, type) else str(kind)
