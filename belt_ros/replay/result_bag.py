"""What a replay says as a rosbag2 bag, on the topics and types of the live node."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer

from belt_ros.diagnostic_rows import Row, number_text
from belt_ros.estimation import AlarmStatus, ConditionStatus
from belt_ros.message_fields import alarm_fields, condition_fields
from belt_ros.message_types import belt_typestore
from belt_ros.replay.tables import STATE_TYPE

STATE_TOPIC = "/belt_node/state"
ALARM_TOPIC = "/belt_node/alarm"
DIAGNOSTICS_TOPIC = "/diagnostics"
ALARM_TYPE = "belt_msgs/msg/SlipAlarm"
_CONDITION_TYPE = "belt_msgs/msg/AlarmCondition"
_DIAGNOSTICS_TYPE = "diagnostic_msgs/msg/DiagnosticArray"
_READABLE_SINCE_HUMBLE: Final = 8
_SECOND_NS = 1_000_000_000
_LATEST_NS = 2**31 * _SECOND_NS - 1  # that a stamp can tell; a log time may be any
_FOREVER = QosTime(9223372036, 854775807)


def _quality(durability: QosDurability) -> list[Qos]:
    """Offered quality of service, which `ros2 bag play` then offers again."""
    return [
        Qos(
            history=QosHistory.KEEP_LAST,
            depth=10,
            reliability=QosReliability.RELIABLE,
            durability=durability,
            deadline=_FOREVER,
            lifespan=_FOREVER,
            liveliness=QosLiveliness.AUTOMATIC,
            liveliness_lease_duration=_FOREVER,
            avoid_ros_namespace_conventions=False,
        )
    ]


class ResultBag:
    """A growing rosbag2 directory (MCAP) of states, alarms and diagnostics.

    Parameters
    ----------
    path : Path
    prefix : str
        What stands before the names of the drive's topics within those of the node.
    """

    def __init__(self, path: Path, prefix: str = "") -> None:
        self._types = belt_typestore()
        self._writer = Writer(
            path, version=_READABLE_SINCE_HUMBLE, storage_plugin=StoragePlugin.MCAP
        )
        self._writer.open()
        self._state = self._writer.add_connection(
            STATE_TOPIC.replace("/state", f"/{prefix}state"),
            STATE_TYPE,
            typestore=self._types,
            offered_qos_profiles=_quality(QosDurability.VOLATILE),
        )
        self._alarm = self._writer.add_connection(
            ALARM_TOPIC.replace("/alarm", f"/{prefix}alarm"),
            ALARM_TYPE,
            typestore=self._types,
            offered_qos_profiles=_quality(QosDurability.TRANSIENT_LOCAL),
        )
        self._diagnostics = self._writer.add_connection(
            DIAGNOSTICS_TOPIC,
            _DIAGNOSTICS_TYPE,
            typestore=self._types,
            offered_qos_profiles=_quality(QosDurability.VOLATILE),
        )

    def _time(self, stamp_ns: int) -> Any:
        seconds, nanoseconds = divmod(min(max(stamp_ns, 0), _LATEST_NS), _SECOND_NS)
        return self._types.types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)

    def _header(self, stamp_ns: int) -> Any:
        return self._types.types["std_msgs/msg/Header"](stamp=self._time(stamp_ns), frame_id="")

    def _condition(self, status: ConditionStatus) -> Any:
        return self._types.types[_CONDITION_TYPE](
            first_time=self._time(status.first_ns),
            last_time=self._time(status.last_ns),
            **condition_fields(status),
        )

    def write_state(self, log_ns: int, message: bytes) -> None:
        """Write one state, given as the bytes of its message, at a log time [ns]."""
        self._writer.write(self._state, log_ns, message)

    def write_alarm(self, log_ns: int, drive_name: str, status: AlarmStatus) -> None:
        """Write a change of the alarm at a log time [ns]."""
        message = self._types.types[ALARM_TYPE](
            header=self._header(status.stamp_ns),
            first_time=self._time(status.first_ns),
            last_time=self._time(status.last_ns),
            conditions=[self._condition(status) for status in status.conditions],
            **alarm_fields(drive_name, status),
        )
        self._writer.write(self._alarm, log_ns, self._types.serialize_cdr(message, ALARM_TYPE))

    def write_diagnostics(self, log_ns: int, rows: Iterable[Row]) -> None:
        """Write rows of diagnostics at a log time [ns], which is their stamp too."""
        message = self._types.types[_DIAGNOSTICS_TYPE](
            header=self._header(log_ns), status=[self._row(row) for row in rows]
        )
        data = self._types.serialize_cdr(message, _DIAGNOSTICS_TYPE)
        self._writer.write(self._diagnostics, log_ns, data)

    def _row(self, row: Row) -> Any:
        key_value = self._types.types["diagnostic_msgs/msg/KeyValue"]
        return self._types.types["diagnostic_msgs/msg/DiagnosticStatus"](
            level=int(row.level),
            name=row.name,
            message=row.message,
            hardware_id=row.hardware_id,
            values=[key_value(key, number_text(value)) for key, value in row.values.items()],
        )

    def close(self) -> None:
        """Write index and metadata."""
        self._writer.close()

    def abort(self) -> None:
        """Let go of the files without caring for their content."""
        self._writer.abort()
