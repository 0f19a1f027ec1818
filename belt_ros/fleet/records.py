"""What is kept of one bag: a row for each drive, and by what the result is known again."""

import dataclasses
import hashlib
import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import belt_ros
from belt_ros.replay.bags import files_of
from belt_ros.replay.drives import Described
from belt_ros.replay.quantities import FinalQuantity
from belt_ros.replay.summary import Summary

RECORD_NAME = "record.json"
_BLOCK = 1 << 20  # [bytes]
_HOURS = 1.0 / 3600.0


@dataclass(frozen=True)
class Row:
    """One drive in one bag. Where `error` says something, nothing else is known: NaN, 0 or "".

    Learned quantities are those of the moment at which the bag told most; where the data have
    taught nothing, ``*_learned`` is false and the value is the prior's. Units are in the names,
    else SI: tension [N], kf [N/m2], mu [-], margins and shares as fractions.
    """

    drive: str
    bag: str
    error: str = ""
    start_ns: int = 0
    hours: float = math.nan
    tension: float = math.nan
    tension_stddev: float = math.nan
    tension_learned: bool = False
    kf: float = math.nan
    kf_stddev: float = math.nan
    kf_learned: bool = False
    mu: float = math.nan
    mu_stddev: float = math.nan
    mu_learned: bool = False
    worst_margin: float = math.nan
    worst_margin_stddev: float = math.nan
    alarms: int = 0
    worst_severity: str = ""
    alarm_seconds: float = 0.0  # sum over all alarms
    alarm_names: str = ""
    messages: int = 0
    accepted_share: float = math.nan
    unobserved_seconds: float = math.nan
    resets: int = 0
    note: str = ""  # what of the bag is lost
    result: str = ""  # directory of the results, seen from the fleet's


def failed_row(drive: str, bag: Path, error: str) -> Row:
    """Return the row of a bag that gave nothing."""
    return Row(drive, str(bag), " ".join(error.split()))


def row_of(bag: Path, summary: Summary, result: str) -> Row:
    """Return the row of one drive in one bag."""
    tension, kf, mu = (_best(summary, name) for name in ("mean_tension", "friction_stiffness", _MU))
    margin, known = summary.worst_margin, summary.knowledge
    return Row(
        drive=summary.drive,
        bag=str(bag),
        start_ns=summary.start_ns,
        hours=summary.duration * _HOURS,
        tension=tension.value,
        tension_stddev=tension.stddev,
        tension_learned=known["tension"] == "learned",
        kf=kf.value,
        kf_stddev=kf.stddev,
        kf_learned=known["friction_stiffness"] == "learned",
        mu=mu.value,
        mu_stddev=mu.stddev,
        mu_learned=known[_MU] == "learned",
        worst_margin=math.nan if margin is None else margin.value,
        worst_margin_stddev=math.nan if margin is None else margin.stddev,
        alarms=summary.alarms_raised,
        worst_severity=summary.worst_severity,
        alarm_seconds=sum(summary.time_in_alarm.values(), 0.0),
        alarm_names=", ".join(summary.time_in_alarm),
        messages=summary.messages,
        accepted_share=summary.accepted / summary.messages,
        unobserved_seconds=summary.unobserved,
        resets=summary.resets,
        note=summary.note,
        result=result,
    )


_MU = "friction_coefficient"


def _best(summary: Summary, name: str) -> FinalQuantity:
    """Return a quantity when it was known best, or at the end where there is no hindsight."""
    smoothed = summary.smoothed
    return summary.final[name] if smoothed is None else smoothed.best_known[name]


def content_hash(bag: Path) -> str:
    """Return a hash of what a bag holds, wherever it lies.

    Raises
    ------
    OSError
        If it cannot be read.
    """
    whole = hashlib.blake2b(digest_size=16)
    for file in files_of(bag):
        part = hashlib.blake2b(digest_size=16)
        with file.open("rb") as opened:
            while block := opened.read(_BLOCK):
                part.update(block)
        whole.update(part.digest())
    return whole.hexdigest()


def configuration_hash(
    drives: Sequence[Described], *, smooth: bool, topic: str | None = None
) -> str:
    """Return a hash of all that decides on the results beside the bag."""
    plain = [
        (drive.key, dataclasses.asdict(drive.settings), dataclasses.asdict(drive.inputs))
        for drive in drives
    ]
    text = json.dumps([belt_ros.__version__, smooth, topic, plain], sort_keys=True, default=str)
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()


def write_record(folder: Path, key: str, rows: Iterable[Row]) -> None:
    """Write what is kept of a bag to the directory of its results."""
    record = {"key": key, "rows": [_plain(row) for row in rows]}
    text = json.dumps(record, indent=2, allow_nan=False, ensure_ascii=False)
    (folder / RECORD_NAME).write_text(text + "\n", encoding="utf-8")


def read_record(folder: Path, key: str) -> tuple[Row, ...] | None:
    """Return the rows of finished results; None if there are none, or of something else."""
    try:
        record = json.loads((folder / RECORD_NAME).read_text(encoding="utf-8"))
        if record["key"] != key:
            return None
        return tuple(_row(values) for values in record["rows"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _plain(row: Row) -> dict[str, Any]:
    values = dataclasses.asdict(row)
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in values.items()
    }


def _row(values: dict[str, Any]) -> Row:
    known = {name: math.nan if value is None else value for name, value in values.items()}
    return Row(**cast("dict[str, Any]", known))
