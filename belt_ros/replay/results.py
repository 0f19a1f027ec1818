"""The result directory of one replay: all of it, or nothing.

Everything is written beside the final place, and renamed when complete.
"""

import json
from collections.abc import Iterable
from contextlib import closing, suppress
from pathlib import Path
from types import TracebackType
from typing import Any

from belt_ros.appearing import beside, put_in_place
from belt_ros.diagnostic_rows import Row
from belt_ros.estimation import AlarmStatus, BeltEstimate
from belt_ros.replay.errors import ResultsError
from belt_ros.replay.result_bag import ALARM_TOPIC, STATE_TOPIC, ResultBag
from belt_ros.replay.smoothing import SMOOTHED_FIELDS, SmoothedRow
from belt_ros.replay.tables import SmoothedTable, StateTable, state_kinds
from belt_ros.state_bytes import StateBytes

BAG_NAME = "estimates"
TABLE_NAME = "estimates.parquet"
SMOOTHED_NAME = "smoothed.parquet"
SUMMARY_NAME = "summary.json"
_OURS = {BAG_NAME, TABLE_NAME, SMOOTHED_NAME, SUMMARY_NAME}

__all__ = ["ALARM_TOPIC", "STATE_TOPIC", "ResultWriter", "ResultsError"]


def check_place(out: Path, *, replace: bool) -> None:
    """Raise `ResultsError` unless results can be put at `out` without harming anything else."""
    if not (out.exists() or out.is_symlink()):
        return
    if not out.is_dir() or out.is_symlink():
        raise ResultsError(f"{out} exists and is no directory. Choose another --out.")
    contents = {entry.name for entry in out.iterdir()}
    if not contents:
        return
    if not contents <= _OURS:
        raise ResultsError(f"{out} holds other things than results. Choose another --out.")
    if not replace:
        raise ResultsError(
            f"{out} holds earlier results. Choose another --out, or replace them with --force."
        )


class ResultWriter:
    """Bag, tables and summary of one replay. A context manager: leaving it by an error undoes all.

    Parameters
    ----------
    out : Path
        The result directory.
    drive_name : str
    replace : bool
        Whether earlier results at `out` may be replaced.
    prefix : str
        What stands before the names of the drive's topics within those of the node.

    Raises
    ------
    ResultsError
        If `out` holds anything that must not be lost, or cannot be written.
    """

    def __init__(
        self, out: Path, drive_name: str, *, replace: bool = False, prefix: str = ""
    ) -> None:
        check_place(out, replace=replace)
        self._out = out
        self._drive_name = drive_name
        self._state_bytes = StateBytes(drive_name, state_kinds())
        try:
            self._folder = beside(out)
        except OSError as error:
            raise ResultsError(f"cannot write to {out.parent}: {error.strerror}") from error
        self._part = Path(self._folder.name) / out.name
        try:
            self._part.mkdir()
            self._table = StateTable(self._part / TABLE_NAME, drive_name)
            self._bag = ResultBag(self._part / BAG_NAME, prefix)
        except BaseException:
            self._folder.cleanup()
            raise

    def __enter__(self) -> "ResultWriter":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._part.exists():  # not committed
            with suppress(Exception):  # a full disk refuses the table's last bytes
                self._table.abort()
            with suppress(Exception):
                self._bag.abort()
        self._folder.cleanup()

    def write_state(self, log_ns: int, estimate: BeltEstimate) -> None:
        """Write one estimate to bag and table."""
        message = self._state_bytes.write(estimate)
        self._bag.write_state(log_ns, message)
        self._table.append(log_ns, message)

    def write_alarm(self, log_ns: int, status: AlarmStatus) -> None:
        """Write one change of the alarm to the bag."""
        self._bag.write_alarm(log_ns, self._drive_name, status)

    def write_diagnostics(self, log_ns: int, rows: Iterable[Row]) -> None:
        """Write rows of diagnostics to the bag."""
        self._bag.write_diagnostics(log_ns, rows)

    def write_smoothed(self, rows: Iterable[SmoothedRow]) -> None:
        """Write the table of what is known with hindsight, in one go."""
        path = self._part / SMOOTHED_NAME
        with closing(SmoothedTable(path, self._drive_name, SMOOTHED_FIELDS)) as table:
            for row in rows:
                table.append(*row)

    def commit(self, summary: dict[str, Any]) -> None:
        """Complete bag and table, add the summary, and put all in place."""
        self._table.close()
        self._bag.close()
        text = json.dumps(summary, indent=2, allow_nan=False, ensure_ascii=False)
        (self._part / SUMMARY_NAME).write_text(text + "\n", encoding="utf-8")
        check_place(self._out, replace=True)
        put_in_place(self._part, self._out)
