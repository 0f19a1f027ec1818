"""Stamps, estimates and alarms as messages. Nothing that a topic can carry raises here."""

from belt_msgs.msg import AlarmCondition, BeltState, SlipAlarm
from builtin_interfaces.msg import Time

from belt_ros.estimation import AlarmStatus, BeltEstimate, ConditionStatus
from belt_ros.message_fields import alarm_fields, condition_fields, state_fields

_SECOND = 1_000_000_000


def nanoseconds(stamp: Time) -> int:
    """Return a stamp as nanoseconds."""
    return int(stamp.sec) * _SECOND + int(stamp.nanosec)


def time_message(stamp_ns: int) -> Time:
    """Return nanoseconds as a stamp."""
    seconds, rest = divmod(stamp_ns, _SECOND)
    return Time(sec=seconds, nanosec=rest)


def state_message(drive_name: str, estimate: BeltEstimate) -> BeltState:
    """Return an estimate as a message, stamped with the time of its measurement."""
    message = BeltState(**state_fields(drive_name, estimate))
    message.header.stamp = time_message(estimate.stamp_ns)
    return message


def alarm_message(drive_name: str, status: AlarmStatus) -> SlipAlarm:
    """Return an alarm's status as a message, stamped with the time of its change."""
    message = SlipAlarm(**alarm_fields(drive_name, status))
    message.header.stamp = time_message(status.stamp_ns)
    message.first_time = time_message(status.first_ns)
    message.last_time = time_message(status.last_ns)
    message.conditions = [_condition_message(condition) for condition in status.conditions]
    return message


def _condition_message(status: ConditionStatus) -> AlarmCondition:
    message = AlarmCondition(**condition_fields(status))
    message.first_time = time_message(status.first_ns)
    message.last_time = time_message(status.last_ns)
    return message
