"""What can be known of a belt drive from its measurements. No ROS, no clock: time is a stamp."""

from belt_ros.estimation.alarm import SlipAlarm
from belt_ros.estimation.alarm_settings import AlarmSettings, Condition, Severity
from belt_ros.estimation.assumptions import Drift, Joint, Prior, SensorLimits, SensorNoise
from belt_ros.estimation.belt_filter import BeltFilter
from belt_ros.estimation.condition import AlarmStatus, ConditionStatus
from belt_ros.estimation.estimate import BeltEstimate, Health, Knowledge, Phase, Quantity
from belt_ros.estimation.maintenance import Maintenance, MaintenanceKind
from belt_ros.estimation.measurement import Measurement, Rejection, measurement_from_joints
from belt_ros.estimation.memory import Learned, MemoryRefusedError
from belt_ros.estimation.monitor import BeltMonitor, MonitorOutput

__all__ = [
    "AlarmSettings",
    "AlarmStatus",
    "BeltEstimate",
    "BeltFilter",
    "BeltMonitor",
    "Condition",
    "ConditionStatus",
    "Drift",
    "Health",
    "Joint",
    "Knowledge",
    "Learned",
    "Maintenance",
    "MaintenanceKind",
    "Measurement",
    "MemoryRefusedError",
    "MonitorOutput",
    "Phase",
    "Prior",
    "Quantity",
    "Rejection",
    "SensorLimits",
    "SensorNoise",
    "Severity",
    "SlipAlarm",
    "measurement_from_joints",
]
