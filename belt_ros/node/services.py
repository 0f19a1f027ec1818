"""What the node's services do, and what they answer. Nothing that a request can carry raises."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from belt_msgs.srv import RecordMaintenance

from belt_ros.estimation import AlarmStatus, Maintenance, MaintenanceKind
from belt_ros.mechanics import DriveError
from belt_ros.node.memory import Memory
from belt_ros.node.pipeline import Pipeline

_KINDS = ", ".join(f"{kind:d} {kind.name.lower().replace('_', ' ')}" for kind in MaintenanceKind)
_LONGEST_NOTE = 200


class Answer(NamedTuple):
    """Whether it was done, and a sentence."""

    success: bool
    message: str


class Unit(Protocol):
    """One drive of a node."""

    @property
    def drive_name(self) -> str:
        """Name of the drive."""

    def record_maintenance(self, request: RecordMaintenance.Request) -> Answer:
        """Take in what was done to its belt."""


_NOT_ACTIVE = Answer(
    success=False, message="not active: activate the node, e.g. ros2 lifecycle set <node> activate"
)
_NOT_CONFIGURED = Answer(
    success=False,
    message="not configured: configure the node, e.g. ros2 lifecycle set <node> configure",
)
_NO_ESTIMATE = Answer(
    success=False, message="no estimate yet: nothing usable has come from the sensors"
)


def reset(
    pipeline: Pipeline | None, memory: Memory | None, publish: Callable[[AlarmStatus], None]
) -> Answer:
    """Start anew at the configured priors, also in the runs to come; no alarm outlives it."""
    if pipeline is None:
        return _NOT_ACTIVE
    alarm = pipeline.reset()
    if alarm is not None:
        publish(alarm)
    kept = memory.forget() if memory is not None else ""
    message = f"started anew at the configured priors, reset {pipeline.health.resets}"
    return Answer(success=True, message=f"{message}; {kept}" if kept else message)


def acknowledge(pipeline: Pipeline | None, publish: Callable[[AlarmStatus], None]) -> Answer:
    """Release the alarms' latches."""
    if pipeline is None:
        return _NOT_ACTIVE
    alarm = pipeline.acknowledge()
    if alarm is None:
        return _NO_ESTIMATE
    publish(alarm)
    return Answer(success=True, message=alarm.message)


def calibrate(pipeline: Pipeline | None) -> Answer:
    """Begin to calibrate the radius ratio."""
    if pipeline is None:
        return _NOT_ACTIVE
    if not pipeline.calibrate():
        return _NO_ESTIMATE
    return Answer(
        success=True,
        message="calibration has begun: turn the drive steadily and without load for about 5 s, "
        "within 30 s; the result is logged and stands in /diagnostics",
    )


def record_maintenance(
    pipeline: Pipeline | None, memory: Memory | None, request: RecordMaintenance.Request
) -> Answer:
    """Take in what was done to the belt, whether the drive runs or not, and keep it."""
    if pipeline is None:
        return _NOT_CONFIGURED
    name = request.drive_name
    if name not in {"", pipeline.drive_name}:
        return Answer(
            success=False,
            message=f"there is no drive {name!a} here, only {pipeline.drive_name!a}",
        )
    if request.action not in set(MaintenanceKind):
        return Answer(success=False, message=f"action {request.action} is unknown; {_KINDS}")
    try:
        kind = MaintenanceKind(request.action)
        done = pipeline.maintain(
            Maintenance(kind, _given(request.value), _given(request.value_stddev))
        )
    except DriveError as error:
        return Answer(success=False, message=str(error))
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        return Answer(success=False, message=f"it could not be taken in: {error}")
    note = f" (note: {request.note[:_LONGEST_NOTE]!a})" if request.note else ""
    return Answer(success=True, message=done + note + _kept(memory))


def record_for_one(units: Sequence[Unit], request: RecordMaintenance.Request) -> Answer:
    """Take in what was done to the belt of that drive, of several, which the request names."""
    for unit in units:
        if request.drive_name and unit.drive_name == request.drive_name:
            return unit.record_maintenance(request)
    names = ", ".join(repr(unit.drive_name) for unit in units if unit.drive_name)
    if not names:
        return _NOT_CONFIGURED
    if not request.drive_name:
        return Answer(success=False, message=f"name the drive: one of {names}")
    return Answer(
        success=False, message=f"there is no drive {request.drive_name!a} here, only {names}"
    )


def _given(value: float) -> float:
    """Return a value of a request, NaN where it was left out, which makes it zero."""
    return math.nan if value == 0.0 else value


def _kept(memory: Memory | None) -> str:
    """Keep at once what no measurement will tell again; return what came of that."""
    if memory is None:
        return ""
    memory.finish()
    return f"; not kept: {memory.trouble}" if memory.trouble else ""
