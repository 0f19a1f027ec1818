"""What no message may do: make anything that goes out something other than sensible numbers."""

import math
from functools import cache
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus

from belt_ros.estimation import Measurement, Rejection

_ROUNDING = 1e-9
_NEVER_CAME = ("latency ", "processing ")  # of a period in which nothing did


class BrokenPromiseError(AssertionError):
    """Something that must hold does not; the message says what."""


@cache
def _numbers(message_type: type) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the fields that are numbers with a point, and of lists of messages."""
    fields: dict[str, str] = message_type.get_fields_and_field_types()  # type: ignore[attr-defined]
    return (
        tuple(name for name, kind in fields.items() if kind in {"double", "float"}),
        tuple(name for name, kind in fields.items() if kind.startswith("sequence<belt_msgs")),
    )


def check_message(message: Any) -> None:
    """Check every number of a message, and of the messages in it.

    Raises
    ------
    BrokenPromiseError
        If one is not finite, a standard deviation negative, or a probability none.
    """
    kind: type = type(message)
    names, lists = _numbers(kind)
    for name in names:
        _check_number(f"{kind.__name__}.{name}", getattr(message, name))
    for name in lists:
        for part in getattr(message, name):
            check_message(part)


def check_row(row: DiagnosticStatus, *, idle: bool = False) -> None:
    """Check a row of diagnostics; `idle`: nothing has come, so there are no times to tell.

    Raises
    ------
    BrokenPromiseError
        As `check_message`.
    """
    for entry in row.values:
        if not (idle and entry.key.startswith(_NEVER_CAME)):
            _check_number(f"{row.name}: {entry.key}", float(entry.value))
    if "nan" in row.message.replace("\N{NO-BREAK SPACE}", " ").split():
        raise BrokenPromiseError(f"{row.name} says {row.message!r}")


def _check_number(name: str, value: float) -> None:
    if not math.isfinite(value):
        raise BrokenPromiseError(f"{name} is {value}")
    if "stddev" in name and value < 0.0:
        raise BrokenPromiseError(f"{name} is {value}")
    if "probability" in name and not -_ROUNDING <= value <= 1.0 + _ROUNDING:
        raise BrokenPromiseError(f"{name} is {value}")


class Ledger:
    """Holds that what was given is accepted, counted under a reason, or waits in a pool."""

    def __init__(self) -> None:
        self.given = 0
        self.last_ns: int | None = None  # stamp of the last measurement that may wait

    def begin(self, counted: int) -> None:
        """Count from `counted` on, as nothing waits any more."""
        self.given, self.last_ns = counted, None

    def give(self, ready: Measurement | Rejection) -> None:
        """Take note of what is handed to the pipeline next."""
        self.given += 1
        if isinstance(ready, Measurement):
            self.last_ns = ready.stamp_ns

    def check(self, accepted: int, rejections: tuple[int, ...], waiting: int) -> None:
        """Compare with what the monitor has counted, and says to wait.

        Raises
        ------
        BrokenPromiseError
            If one was lost, or counted twice.
        """
        if self.given != accepted + sum(rejections) + waiting:
            raise BrokenPromiseError(
                f"{self.given} given, {accepted} accepted, {sum(rejections)} rejected, "
                f"{waiting} wait"
            )
        if rejections[Rejection.NONE]:
            raise BrokenPromiseError("rejected for no reason")
