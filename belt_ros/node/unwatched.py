"""What is told of a drive while the node is not active, and nobody watches its belt."""

import dataclasses

from diagnostic_msgs.msg import DiagnosticStatus

from belt_ros.estimation import AlarmStatus, Condition, ConditionStatus, Severity
from belt_ros.node.diagnostics import status_row

_UNWATCHED = "nobody watches the belt, for the node is not active"


def unwatched_row(node_name: str, drive_name: str) -> DiagnosticStatus:
    """Return the row of the drive."""
    message = f"{_UNWATCHED}: activate it, e.g. ros2 lifecycle set <node> activate"
    name = f"{node_name}: {drive_name}"
    return status_row(name, drive_name, DiagnosticStatus.STALE, message, {})


def unwatched_alarm(drive_name: str, status: AlarmStatus, now_ns: int) -> AlarmStatus:
    """Return the alarms' status from `now_ns` [ns] on, after `status`.

    Nothing usable comes to whoever would judge it, which is what SENSOR_STALE says. That other
    conditions hold is no longer said, but their latches stay.
    """
    silent = [each for each in status.conditions if each.condition is Condition.SENSOR_STALE]
    others = [each for each in status.conditions if each.condition is not Condition.SENSOR_STALE]
    stale = ConditionStatus(
        condition=Condition.SENSOR_STALE,
        severity=Severity.ALARM,
        latched_severity=Severity.ALARM,
        active=True,
        acknowledged=all(each.acknowledged for each in silent),
        count=sum(each.count for each in silent),
        first_ns=now_ns,
        last_ns=now_ns,
        message=f"{drive_name}: {_UNWATCHED}. The estimate is that of the last measurement.",
    )
    return dataclasses.replace(
        status,
        stamp_ns=now_ns,
        condition=stale.condition,
        severity=stale.severity,
        latched_severity=max(status.latched_severity, stale.latched_severity),
        count=stale.count,
        first_ns=stale.first_ns,
        last_ns=stale.last_ns,
        message=stale.message,
        conditions=(stale, *(_unjudged(drive_name, each) for each in others)),
    )


def _unjudged(drive_name: str, status: ConditionStatus) -> ConditionStatus:
    if not status.active:
        return status
    name = status.condition.name.lower().replace("_", " ")
    message = f"{drive_name}: {name} was there when the belt was last watched."
    return dataclasses.replace(status, severity=Severity.NORMAL, active=False, message=message)
