"""Messages to measurements, estimates to messages. Nothing that a topic can carry raises here."""

from belt_msgs.msg import BeltState, SlipAlarm
from builtin_interfaces.msg import Time
from sensor_msgs.msg import JointState

from belt_ros.estimation import (
    AlarmStatus,
    BeltEstimate,
    Joint,
    Measurement,
    Rejection,
    measurement_from_joints,
)
from belt_ros.message_fields import alarm_fields, state_fields

_SECOND = 1_000_000_000
_MOST_JOINTS = 1000


def nanoseconds(stamp: Time) -> int:
    """Return a stamp as nanoseconds."""
    return int(stamp.sec) * _SECOND + int(stamp.nanosec)


def time_message(stamp_ns: int) -> Time:
    """Return nanoseconds as a stamp."""
    seconds, rest = divmod(stamp_ns, _SECOND)
    return Time(sec=seconds, nanosec=rest)


def measurement_from_joint_state(
    driver: Joint, driven: Joint, message: JointState
) -> Measurement | Rejection:
    """Read the two pulleys out of a joint state, or say why that is impossible."""
    stamp = message.header.stamp
    if len(message.name) > _MOST_JOINTS or stamp.sec < 0 or stamp.nanosec >= _SECOND:
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
    return message
