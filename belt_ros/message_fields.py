"""Estimates and alarms as flat fields, named as in belt_msgs, the same in node and replay."""

from operator import attrgetter
from typing import Any

from belt_ros.estimation import AlarmStatus, BeltEstimate, ConditionStatus

_QUANTITIES = (
    "driver_speed",
    "driven_speed",
    "transmitted_torque",
    "slip",
    "predicted_creep",
    "excess_slip",
    "accumulated_slip",
    "tight_tension",
    "slack_tension",
    "mean_tension",
    "friction_stiffness",
    "friction_coefficient",
    "ratio_bias",
    "creep_model_error",
    "driven_transition_angle",
    "driver_transition_angle",
    "margin",
    "capacity_torque",
)


STATE_SOURCES: dict[str, str] = {
    "phase": "phase",
    **{name: f"{name}.value" for name in _QUANTITIES},
    **{f"{name}_stddev": f"{name}.stddev" for name in _QUANTITIES},
    "friction_stiffness_log_stddev": "friction_stiffness_log_stddev",
    "gross_slip_probability": "gross_slip_probability",
    "gross_slip_probability_at_peak_load": "reserve.gross_slip_probability_at_peak_load",
    "traction_lost_probability": "lost_traction.traction",
    "tension_lost_probability": "lost_traction.tension",
    "friction_lost_probability": "lost_traction.friction",
    "tension_knowledge": "tension_knowledge",
    "friction_stiffness_knowledge": "friction_stiffness_knowledge",
    "friction_coefficient_knowledge": "friction_coefficient_knowledge",
    "normalised_innovation_squared": "health.innovation_squared",
    "innovation_degrees_of_freedom": "health.degrees_of_freedom",
    "fit": "health.fit.consistency",
    "fit_mean": "health.fit.mean",
    "fit_lowest": "health.fit.lowest",
    "fit_highest": "health.fit.highest",
    "accepted_count": "health.accepted",
    "reset_count": "health.resets",
    "last_rejection": "health.last_rejection",
    "rejection_counts": "health.rejections",
}
"""Where the fields of belt_msgs/BeltState, but for header and name, are in a `BeltEstimate`."""

_state_values = attrgetter(*STATE_SOURCES.values())


def state_fields(drive_name: str, estimate: BeltEstimate) -> dict[str, Any]:
    """Return the fields of belt_msgs/BeltState, but for its header."""
    return {
        "drive_name": drive_name,
        **dict(zip(STATE_SOURCES, _state_values(estimate), strict=True)),
    }


def alarm_fields(drive_name: str, status: AlarmStatus) -> dict[str, Any]:
    """Return the fields of belt_msgs/SlipAlarm, but for its header, times and conditions."""
    return {
        "drive_name": drive_name,
        "condition": int(status.condition),
        "severity": int(status.severity),
        "latched_severity": int(status.latched_severity),
        "active": status.active,
        "acknowledged": status.acknowledged,
        "margin": status.margin.value,
        "margin_stddev": status.margin.stddev,
        "excess_slip": status.excess_slip,
        "gross_slip_probability": status.gross_slip_probability,
        "count": status.count,
        "message": status.message,
    }


def condition_fields(status: ConditionStatus) -> dict[str, Any]:
    """Return the fields of belt_msgs/AlarmCondition, but for its times."""
    return {
        "condition": int(status.condition),
        "severity": int(status.severity),
        "latched_severity": int(status.latched_severity),
        "active": status.active,
        "acknowledged": status.acknowledged,
        "count": status.count,
        "message": status.message,
    }
