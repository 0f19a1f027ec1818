"""The states of one replay as Parquet tables, written in row groups so that memory stays flat.

One holds the filter's state at every estimate, the other what is known with hindsight.
"""

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from belt_ros.estimation import Rejection
from belt_ros.message_types import belt_typestore, message_texts
from belt_ros.state_bytes import PLAIN_CDR

STATE_TYPE = "belt_msgs/msg/BeltState"
_Row = TypeVar("_Row")
_ROW_GROUP = 8192
_STRINGS = ("header", "drive_name")
_COUNTS = "rejection_counts"
_SECOND_NS = 1_000_000_000
_FIELD_WITH_UNIT = re.compile(r"^\s*\S+\s+(\w+)\s+#\s*\[([^\]]+)\]", re.MULTILINE)
_REASONS = [reason for reason in Rejection if reason is not Rejection.NONE]


@cache
def state_units() -> dict[str, str]:
    """Return the units of the state's fields, as its message definition states them."""
    return dict(_FIELD_WITH_UNIT.findall(message_texts()[STATE_TYPE]))


@cache
def state_kinds() -> dict[str, str]:
    """Return names and ROS types of all numbers of the state, in their order."""
    _, fields = belt_typestore().fielddefs[STATE_TYPE]
    kinds = {name: str(description[1][0]) for name, description in fields if name not in _STRINGS}
    return kinds | {_COUNTS: f"uint64[{len(Rejection)}]"}


def _message_dtype(drive_name: str) -> np.dtype[Any]:
    """Return as what a drive's states are seen: aligned, as CDR aligns, behind its first bytes."""
    kinds = state_kinds()
    numbers = [(name, kind) for name, kind in kinds.items() if name != _COUNTS]
    head = [("sec", "i4"), ("nanosec", "u4"), ("", "u4"), ("", "S1"), ("", "u4")]
    name = ("drive_name", f"S{len(drive_name.encode()) + 1}")
    counts = (_COUNTS, "u8", len(Rejection))
    message = np.dtype([*head, name, *numbers, counts], align=True)
    return np.dtype([("", f"V{len(PLAIN_CDR)}"), ("state", message)])


def rejection_column(reason: Rejection) -> str:
    """Return the name of the column that counts `reason`."""
    return f"rejected_{reason.name.lower()}"


def _column(name: str, kind: pa.DataType, unit: str) -> pa.Field:
    return pa.field(name, kind, nullable=False, metadata={"unit": unit} if unit else None)


def state_schema(drive_name: str) -> pa.Schema:
    """Return the table's columns: two times, every scalar of the state, one count per rejection."""
    units = state_units()
    columns = [
        _column("stamp_ns", pa.int64(), "ns"),
        _column("log_time_ns", pa.int64(), "ns"),
        *(
            _column(name, pa.type_for_alias(kind), units.get(name, ""))
            for name, kind in state_kinds().items()
            if name != _COUNTS
        ),
        *(_column(rejection_column(reason), pa.uint64(), "") for reason in _REASONS),
    ]
    return pa.schema(columns, metadata={"drive_name": drive_name, "message": STATE_TYPE})


def smoothed_schema(drive_name: str, fields: Sequence[str]) -> pa.Schema:
    """Return columns for `fields`, units as in the state; before them a time and a count."""
    units = state_units()
    columns = [
        _column("stamp_ns", pa.int64(), "ns"),
        _column("reset_count", pa.type_for_alias(state_kinds()["reset_count"]), ""),
        *(_column(name, pa.float64(), units.get(name, "-")) for name in fields),
    ]
    return pa.schema(columns, metadata={"drive_name": drive_name})


class _Table(ABC, Generic[_Row]):
    """A growing Parquet file."""

    def __init__(self, path: Path, schema: pa.Schema) -> None:
        self._schema = schema
        self._writer = pq.ParquetWriter(path, schema, compression="zstd")
        self._rows: list[_Row] = []

    def _add(self, row: _Row) -> None:
        self._rows.append(row)
        if len(self._rows) >= _ROW_GROUP:
            self._flush()

    @abstractmethod
    def _columns(self) -> Iterable[Any]:
        """Return the columns of all rows that are pending."""

    def _flush(self) -> None:
        columns = [
            pa.array(values, field.type)
            for values, field in zip(self._columns(), self._schema, strict=True)
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


class StateTable(_Table[tuple[int, bytes]]):
    """A growing Parquet file of states."""

    def __init__(self, path: Path, drive_name: str) -> None:
        super().__init__(path, state_schema(drive_name))
        self._dtype = _message_dtype(drive_name)

    def append(self, log_ns: int, message: bytes) -> None:
        """Add one state, given as the bytes of its message."""
        self._add((log_ns, message))

    def _columns(self) -> Iterable[Any]:
        log_ns, messages = zip(*self._rows, strict=True)
        states = np.frombuffer(b"".join(messages), self._dtype)["state"]
        yield states["sec"] * np.int64(_SECOND_NS) + states["nanosec"]
        yield log_ns
        for name in state_kinds():
            if name != _COUNTS:
                yield np.ascontiguousarray(states[name])
        for reason in _REASONS:
            yield np.ascontiguousarray(states[_COUNTS][:, reason])


class SmoothedTable(_Table[tuple[float, ...]]):
    """A growing Parquet file of states with hindsight, their columns being `fields`."""

    def __init__(self, path: Path, drive_name: str, fields: Sequence[str]) -> None:
        super().__init__(path, smoothed_schema(drive_name, fields))
        self._names = list(fields)

    def append(self, stamp_ns: int, resets: int, fields: Mapping[str, float]) -> None:
        """Add one state; `resets` is how often time had jumped back before it."""
        self._add((stamp_ns, resets, *(fields[name] for name in self._names)))

    def _columns(self) -> Iterable[Any]:
        return zip(*self._rows, strict=True)
