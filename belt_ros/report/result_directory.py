"""A result directory as `belt replay` leaves it, checked before anything is made of it."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import pyarrow as pa
import pyarrow.parquet as pq

from belt_ros.replay.quantities import BestKnown, Extreme, FinalQuantity
from belt_ros.replay.results import BAG_NAME, SMOOTHED_NAME, SUMMARY_NAME, TABLE_NAME

_LARGEST_SUMMARY = 10_000_000  # bytes
_FINAL_NEEDED = ("mean_tension", "friction_stiffness", "friction_coefficient", "capacity_torque")


class ReportError(Exception):
    """No report can be made; the message names the file and says why."""


@dataclass(frozen=True)
class ResultDirectory:
    """Where the results of a replay lie, and their summary."""

    path: Path
    summary: "SummaryValues"

    @property
    def table(self) -> Path:
        """The filter's states."""
        return self.path / TABLE_NAME

    @property
    def bag(self) -> Path:
        """States and alarms as a rosbag2 directory."""
        return self.path / BAG_NAME

    @property
    def smoothed(self) -> Path | None:
        """What is known with hindsight, where that was asked for."""
        place = self.path / SMOOTHED_NAME
        return place if place.is_file() else None


class SummaryValues:
    """Values of a summary.json, each checked as it is read.

    Parameters
    ----------
    path : Path
        The file, for messages.
    values : mapping
        What it holds.
    """

    def __init__(self, path: Path, values: Mapping[str, Any]) -> None:
        self._path = path
        self._values = values

    def _wrong(self, name: str) -> NoReturn:
        raise ReportError(
            f"{self._path}: {name} is missing or damaged; replay the bag anew with this version"
        )

    def group(self, name: str, *, optional: bool = False) -> "SummaryValues":
        """Return a mapping within; empty if it is optional and null or not there."""
        value = self._values.get(name)
        if value is None and optional:
            return SummaryValues(self._path, {})
        if not isinstance(value, dict):
            self._wrong(name)
        return SummaryValues(self._path, value)

    def groups(self, name: str) -> tuple["SummaryValues", ...]:
        """Return the mappings of a list."""
        found = self._values.get(name)
        if not isinstance(found, list) or not all(isinstance(value, dict) for value in found):
            self._wrong(name)
        return tuple(SummaryValues(self._path, value) for value in found)

    def __bool__(self) -> bool:
        return bool(self._values)

    def raw(self) -> Mapping[str, Any]:
        """Return what has not been checked."""
        return self._values

    def text(self, name: str) -> str:
        """Return a text."""
        value = self._values.get(name)
        if not isinstance(value, str):
            self._wrong(name)
        return value

    def number(self, name: str) -> float:
        """Return a finite number."""
        value = self._values.get(name)
        if isinstance(value, bool) or not isinstance(value, int | float):
            self._wrong(name)
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            self._wrong(name)
        return number

    def count(self, name: str) -> int:
        """Return a whole number."""
        return round(self.number(name))

    def numbers(self) -> dict[str, float]:
        """Return all values, which are numbers."""
        return {name: self.number(name) for name in self._values}

    def texts(self) -> dict[str, str]:
        """Return all values, which are texts."""
        return {name: self.text(name) for name in self._values}

    def number_or_nan(self, name: str) -> float:
        """Return a finite number; NaN where it is null, which is how JSON says not known."""
        return math.nan if self._values.get(name) is None else self.number(name)

    def extreme(self, name: str) -> Extreme | None:
        """Return a most remarkable value, if there was one."""
        found = self.group(name, optional=True)
        if not found:
            return None
        return Extreme(
            found.number("value"),
            found.number_or_nan("stddev"),
            found.count("stamp_ns"),
            found.number("time"),
        )

    def quantity(self, name: str) -> FinalQuantity:
        """Return a quantity with its interval; what is not known is NaN."""
        found = self.group(name)
        return FinalQuantity(
            found.number_or_nan("value"),
            found.number_or_nan("stddev"),
            found.number_or_nan("low"),
            found.number_or_nan("high"),
            found.text("unit"),
        )

    def best_known(self, name: str) -> BestKnown | None:
        """Return a quantity when it was known best, if hindsight was asked for."""
        if name not in self._values:
            return None
        known, found = self.quantity(name), self.group(name)
        return BestKnown(
            known.value,
            known.stddev,
            known.low,
            known.high,
            known.unit,
            found.count("stamp_ns"),
            found.number("time"),
        )


def open_results(path: Path) -> ResultDirectory:
    """Return the results of a replay.

    Raises
    ------
    ReportError
        If `path` is no result directory, or something in it is missing or damaged.
    """
    place = path / SUMMARY_NAME
    if not place.is_file() or not (path / TABLE_NAME).is_file():
        raise ReportError(
            f"{path} is no result directory: it must hold {SUMMARY_NAME} and {TABLE_NAME}, as "
            "belt replay writes them"
        )
    results = ResultDirectory(path, SummaryValues(place, _read_json(place)))
    final = results.summary.group("final")
    for name in _FINAL_NEEDED:
        final.quantity(name)
    if open_table(results.table).metadata.num_rows == 0:
        raise ReportError(f"{results.table} holds no rows")
    return results


def _read_json(place: Path) -> Mapping[str, Any]:
    if place.stat().st_size > _LARGEST_SUMMARY:
        raise ReportError(
            f"{place} is larger than {_LARGEST_SUMMARY} bytes: no summary of a replay"
        )
    try:
        values = json.loads(place.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise ReportError(f"{place} is no valid JSON: {error}") from error
    if not isinstance(values, dict):
        raise ReportError(f"{place} is no summary of a replay")
    return values


def open_table(place: Path) -> Any:
    """Return a Parquet file, opened.

    Raises
    ------
    ReportError
        If it is damaged.
    """
    try:
        # What is buffered ahead would stay in memory until the last batch has been read.
        return pq.ParquetFile(place, pre_buffer=False)
    except (pa.ArrowException, OSError, ValueError) as error:
        raise ReportError(f"{place} is no readable Parquet table: {error}") from error
