"""The states of one replay as a Parquet table, written in row groups so that memory stays flat."""

import re
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from belt_ros.estimation import Rejection
from belt_ros.message_types import belt_typestore, message_texts

STATE_TYPE = "belt_msgs/msg/BeltState"
_ROW_GROUP = 8192
_FIELD_WITH_UNIT = re.compile(r"^\s*\S+\s+(\w+)\s+#\s*\[([^\]]+)\]", re.MULTILINE)
_NOT_TABULATED = ("header", "drive_name", "rejection_counts")
_REASONS = [reason for reason in Rejection if reason is not Rejection.NONE]


def state_units() -> dict[str, str]:
    """Return the units of the state's fields, as its message definition states them."""
    return dict(_FIELD_WITH_UNIT.findall(message_texts()[STATE_TYPE]))


def scalar_fields() -> dict[str, str]:
    """Return names and ROS types of all scalar fields of the state, in their order."""
    _, fields = belt_typestore().fielddefs[STATE_TYPE]
    return {
        name: str(description[1][0]) for name, description in fields if name not in _NOT_TABULATED
    }


def rejection_column(reason: Rejection) -> str:
    """Return the name of the column that counts `reason`."""
    return f"rejected_{reason.name.lower()}"


def state_schema(drive_name: str) -> pa.Schema:
    """Return the table's columns: two times, every scalar of the state, one count per rejection."""
    units = state_units()

    def column(name: str, kind: pa.DataType, unit: str) -> pa.Field:
        return pa.field(name, kind, nullable=False, metadata={"unit": unit} if unit else None)

    columns = [
        column("stamp_ns", pa.int64(), "ns"),
        column("log_time_ns", pa.int64(), "ns"),
        *(
            column(name, pa.type_for_alias(kind), units.get(name, ""))
            for name, kind in scalar_fields().items()
        ),
        *(column(rejection_column(reason), pa.uint64(), "") for reason in _REASONS),
    ]
    return pa.schema(columns, metadata={"drive_name": drive_name, "message": STATE_TYPE})


class StateTable:
    """A growing Parquet file of states."""

    def __init__(self, path: Path, drive_name: str) -> None:
        self._schema = state_schema(drive_name)
        self._names = list(scalar_fields())
        self._writer = pq.ParquetWriter(path, self._schema, compression="zstd")
        self._rows: list[tuple[Any, ...]] = []

    def append(self, log_ns: int, stamp_ns: int, fields: dict[str, Any]) -> None:
        """Add one state, given as the fields of its message."""
        counts = fields["rejection_counts"]
        self._rows.append(
            (
                stamp_ns,
                log_ns,
                *(fields[name] for name in self._names),
                *(counts[reason] for reason in _REASONS),
            )
        )
        if len(self._rows) >= _ROW_GROUP:
            self._flush()

    def _flush(self) -> None:
        columns = [
            pa.array(values, field.type)
            for values, field in zip(zip(*self._rows, strict=True), self._schema, strict=True)
        ]
        self._writer.write_batch(pa.record_batch(columns, schema=self._schema))
        self._rows.clear()

    def close(self) -> None:
        """Write what is pending, and the index."""
        if self._rows:
            self._flush()
        self._writer.close()

    def abort(self) -> None:
        """Let go of the file without caring for its content."""
        self._writer.close()
