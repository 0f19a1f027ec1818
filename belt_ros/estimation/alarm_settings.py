"""Thresholds and delays of the alarms, and what alarms are about.

Slip of 1 to 2 % is a flat belt's normal creep, above 3 % it is looked at, above 5 % it heats the
belt, and 20 % is where drives are usually tripped. Creep is predicted here, so the thresholds are
on what lies beyond it: 1 and 3 % on top of 1 to 2 % of creep.
"""

from dataclasses import dataclass
from enum import IntEnum

from belt_ros.estimation.assumptions import setting


class Condition(IntEnum):
    """What an alarm is about; the numbers are those of belt_msgs/SlipAlarm."""

    NONE = 0
    LOW_MARGIN = 1
    EXCESS_SLIP = 2
    GROSS_SLIP = 3
    TRACTION_LOST = 4
    TENSION_LOST = 5
    FRICTION_LOST = 6
    SENSOR_STALE = 7
    SENSOR_IMPLAUSIBLE = 8
    ESTIMATOR_LOST = 9


class Severity(IntEnum):
    """How bad a condition is; the numbers are those of belt_msgs/SlipAlarm."""

    NORMAL = 0
    WARNING = 1
    ALARM = 2
    TRIP = 3


@dataclass(frozen=True)
class AlarmSettings:
    """Thresholds and delays of the alarms; all may change while running."""

    margin_warning: float = setting(0.25, "warn below this margin", "-", 0.0, 1.0)
    margin_alarm: float = setting(0.10, "alarm below this margin", "-", 0.0, 1.0)
    excess_slip_warning: float = setting(
        0.01, "warn above this slip beyond predicted creep", "-", 0.0, 1.0
    )
    excess_slip_alarm: float = setting(
        0.03, "alarm above this slip beyond predicted creep", "-", 0.0, 1.0
    )
    excess_slip_trip: float = setting(
        0.20, "trip above this slip beyond predicted creep", "-", 0.0, 1.0
    )
    confidence: float = setting(
        0.8, "probability at which low margin and slip count as met", "-", 0.5, 0.9999
    )
    learned_confidence: float = setting(
        0.8,
        "the same for low margin once tension has been learned or measured; less is earlier, and "
        "more often wrong",
        "-",
        0.5,
        0.9999,
    )
    traction_confidence: float = setting(
        0.95, "probability at which traction counts as lost", "-", 0.5, 0.9999
    )
    clear_confidence: float = setting(
        0.4, "probability below which a raised condition counts as gone (deadband)", "-", 0.0, 0.5
    )
    implausible_rejections: float = setting(
        0.5,
        "share of measurements turned away as impossible, of the last 0.5 s, at which a sensor "
        "counts as implausible; gone below half of it",
        "-",
        0.05,
        1.0,
    )
    implausible_misfit: float = setting(
        5.0,
        "mean square of a sensor's surprises over what they should be, of the last 0.5 s and each "
        "clipped at 10.8, at which it counts as implausible; gone below half of it",
        "-",
        2.0,
        10.0,
    )
    on_delay: float = setting(
        0.1, "low margin and excess slip must hold this long to be raised", "s", 0.0, 60.0
    )
    off_delay: float = setting(1.0, "and be gone this long to be cleared", "s", 0.0, 600.0)
    trip_on_delay: float = setting(0.2, "on-delay of gross slip", "s", 0.0, 60.0)
    trip_off_delay: float = setting(1.0, "off-delay of gross slip", "s", 0.0, 600.0)
    traction_on_delay: float = setting(0.5, "on-delay of lost traction", "s", 0.0, 60.0)
    traction_off_delay: float = setting(1.0, "off-delay of lost traction", "s", 0.0, 600.0)
    stale_off_delay: float = setting(
        1.0,
        "off-delay of a stale sensor; limits.greatest_gap is its on-delay, "
        "before the first measurement at least 10 s",
        "s",
        0.0,
        600.0,
    )
    implausible_on_delay: float = setting(0.2, "on-delay of an implausible sensor", "s", 0.0, 60.0)
    implausible_off_delay: float = setting(
        1.0, "off-delay of an implausible sensor", "s", 0.0, 600.0
    )
    lost_on_delay: float = setting(
        2.0,
        "on-delay of a lost estimator; a step of the load, sampled too slowly to be followed, is "
        "over by then",
        "s",
        0.0,
        60.0,
    )
    lost_off_delay: float = setting(1.0, "off-delay of a lost estimator", "s", 0.0, 600.0)
    start_bypass: float = setting(
        0.0,
        "low margin and slip are not raised for this long after motion begins; none is needed, "
        "since acceleration, undeveloped creep and the winding up of spans are accounted for",
        "s",
        0.0,
        600.0,
    )
