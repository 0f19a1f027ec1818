"""Messages to measurements, estimates to messages. Nothing that a topic can carry raises here."""

import math
from collections.abc import Mapping
from typing import Any

from belt_msgs.msg import AlarmCondition, BeltState, PulleyState, SlipAlarm
from builtin_interfaces.msg import Time
from sensor_msgs.msg import JointState

from belt_ros.estimation import (
    AlarmStatus,
    BeltEstimate,
    ConditionStatus,
    Joint,
    Measurement,
    Rejection,
    measurement_from_joints,
)
from belt_ros.message_fields import alarm_fields, condition_fields, state_fields

_SECOND = 1_000_000_000
_MOST_JOINTS = 1000


def nanoseconds(stamp: Time) -> int:
    """Return a stamp as nanoseconds."""
    return int(stamp.sec) * _SECOND + int(stamp.nanosec)


def time_message(stamp_ns: int) -> Time:
    """Return nanoseconds as a stamp."""
    seconds, rest = divmod(stamp_ns, _SECOND)
    return Time(sec=seconds, nanosec=rest)


def stamp_is_possible(stamp: Time) -> bool:
    """Whether a stamp is a time: not negative, and with less than a second of nanoseconds."""
    return bool(stamp.sec >= 0 and stamp.nanosec < _SECOND)


def measurement_from_joint_state(
    driver: Joint, driven: Joint, message: JointState
) -> Measurement | Rejection:
    """Read the two pulleys out of a joint state, or say why that is impossible."""
    stamp = message.header.stamp
    if len(message.name) > _MOST_JOINTS or not stamp_is_possible(stamp):
        return Rejection.MALFORMED
    return measurement_from_joints(
        driver,
        driven,
        nanoseconds(stamp),
        message.name,
        message.velocity,
        message.effort,
        message.position,
    )


def reading_from_driver_state(message: PulleyState) -> Measurement | Rejection:
    """Return what the driver's joint reports, as it reports it, or why it cannot be used.

    Its span tension is that of the span which `Measurement` has no place for, and is not used.
    """
    return _reading_of_pulley(
        message,
        {
            "driver_speed": message.speed,
            "driver_torque": message.torque,
            "driver_position": message.position,
            "driver_hub_load": message.hub_load,
        },
    )


def reading_from_driven_state(message: PulleyState) -> Measurement | Rejection:
    """Return what the driven pulley's joint reports, as it reports it, or why it is unusable."""
    return _reading_of_pulley(
        message,
        {
            "driven_speed": message.speed,
            "driven_torque": message.torque,
            "driven_position": message.position,
            "driven_hub_load": message.hub_load,
            "span_tension": message.span_tension,
        },
    )


def _reading_of_pulley(
    message: PulleyState, values: Mapping[str, float]
) -> Measurement | Rejection:
    if not stamp_is_possible(message.header.stamp):
        return Rejection.MALFORMED
    return reading(nanoseconds(message.header.stamp), values)


def reading(stamp_ns: int, values: Mapping[str, float]) -> Measurement | Rejection:
    """Return a measurement of some quantities, by their names in `Measurement`.

    One that is infinite is turned away here, before it is joined with what others measured; so is
    one in which nothing is measured.
    """
    if any(map(math.isinf, values.values())) or all(map(math.isnan, values.values())):
        return Rejection.NOT_FINITE
    named: dict[str, Any] = dict(values)
    return Measurement(stamp_ns, **named)


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
