"""A drive's diagnostics as plain values, the same live and offline (REP-107). No ROS.

Units stand in the key and the value is nothing but a number, so that plotting tools read it.
"""

from collections.abc import Mapping
from enum import IntEnum
from typing import NamedTuple

from belt_ros.estimation import AlarmStatus, BeltEstimate, Health, Phase, Rejection, Severity
from belt_ros.estimation.fit import BOTH_SPEEDS, worst_sensor

REJECTION_ADVICE: dict[Rejection, str] = {
    Rejection.NONE: "accepted",
    Rejection.NOT_FINITE: "all values are NaN, or one is infinite: check the sensor and its driver",
    Rejection.OUT_OF_RANGE: "a speed or torque is beyond limits.*: check the sensor and its units",
    Rejection.STALE: "older than allowed: check the clocks of sender and receiver",  # reserved
    Rejection.OUT_OF_ORDER: "the stamp does not follow the one before: check that the sender "
    "stamps its messages, and that there is only one; after a gap longer than limits.greatest_gap, "
    "two have to follow before it is believed",
    Rejection.GATED: "statistically impossible: check the sensor, and noise.* in the parameters",
    Rejection.INCOMPLETE: "a speed is missing: of joint states, check driver.joint and "
    "driven.joint against the names in the message (joints that come in messages of their own need "
    "input: pulley_state or float64); of several topics, check that each is published",
    Rejection.MALFORMED: "arrays empty, too long or of unequal length, or an impossible stamp: "
    "check the sender",
}
_LOST_ADVICE = (
    "the measurements contradict the drive description: check radii, signs and torque scales, "
    "then reset"
)


class Level(IntEnum):
    """How good or bad a row is; the numbers are those of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


_LEVELS = {
    Severity.NORMAL: Level.OK,
    Severity.WARNING: Level.WARN,
    Severity.ALARM: Level.ERROR,
    Severity.TRIP: Level.ERROR,
}


class Row(NamedTuple):
    """One row of diagnostics; units stand in the keys of `values`."""

    level: Level
    name: str
    hardware_id: str
    message: str
    values: Mapping[str, float]


def number_text(value: float) -> str:
    """Return a value as it stands in a row."""
    return str(int(value)) if isinstance(value, int) else f"{value:.6g}"


def words(reason: Rejection) -> str:
    """Return a reason as it reads in a sentence."""
    return reason.name.lower().replace("_", " ")


def drive_row(
    node_name: str,
    drive_name: str,
    estimate: BeltEstimate | None,
    alarm: AlarmStatus | None,
    unused: float,
    greatest_gap: float,
) -> Row:
    """Return the row of the drive.

    Parameters
    ----------
    node_name, drive_name : str
    estimate, alarm
        The present ones; None before the first.
    unused : float
        Time since the last accepted measurement [s].
    greatest_gap : float
        Time after which the estimate is stale [s].
    """
    level, message = _judge_drive(estimate, alarm, unused, greatest_gap)
    values = {} if estimate is None else _drive_values(estimate)
    if estimate is not None or alarm is not None:
        values |= _alarm_values(alarm)
    return Row(level, f"{node_name}: {drive_name}", drive_name, message, values)


def _judge_drive(
    estimate: BeltEstimate | None, alarm: AlarmStatus | None, unused: float, greatest_gap: float
) -> tuple[Level, str]:
    if estimate is None or unused > greatest_gap:
        return (
            Level.STALE,
            f"no usable measurement for {unused:.1f} s: see the row of the input",
        )
    if alarm is not None and alarm.severity > Severity.WARNING:
        return _LEVELS[alarm.severity], alarm.message
    if estimate.phase is Phase.LOST:
        return Level.ERROR, _LOST_ADVICE
    if alarm is not None and alarm.active:
        return _LEVELS[alarm.severity], alarm.message
    if alarm is not None and not alarm.acknowledged:
        return (
            Level.WARN,
            f"{alarm.latched_severity.name.lower()} is over but not acknowledged: find its cause, "
            "then acknowledge",
        )
    return (
        Level.OK,
        f"{estimate.phase.name.lower().replace('_', ' ')}, {estimate.margin.value:.0%} margin",
    )


def _drive_values(estimate: BeltEstimate) -> dict[str, float]:
    values: dict[str, float] = {"phase": estimate.phase}
    for key, quantity in (
        ("slip [-]", estimate.slip),
        ("excess slip [-]", estimate.excess_slip),
        ("transmitted torque [N m]", estimate.transmitted_torque),
        ("mean tension [N]", estimate.mean_tension),
        ("kf [N/m2]", estimate.friction_stiffness),
        ("friction coefficient [-]", estimate.friction_coefficient),
        ("margin [-]", estimate.margin),
        ("capacity torque [N m]", estimate.capacity_torque),
    ):
        name, _, unit = key.partition(" [")
        values[key] = quantity.value
        values[f"{name} stddev [{unit}"] = quantity.stddev
    values["gross slip probability [-]"] = estimate.gross_slip_probability
    reserve, lost, fit = estimate.reserve, estimate.lost_traction, estimate.health.fit
    values["gross slip probability at peak load [-]"] = reserve.gross_slip_probability_at_peak_load
    values["traction lost probability [-]"] = lost.traction
    values["tension lost probability [-]"] = lost.tension
    values["friction lost probability [-]"] = lost.friction
    values["fit"] = fit.consistency
    values["fit mean [-]"] = fit.mean
    values["fit lowest [-]"] = fit.lowest
    values["fit highest [-]"] = fit.highest
    return values


def _alarm_values(alarm: AlarmStatus | None) -> dict[str, float]:
    return {
        "alarm severity": Severity.NORMAL if alarm is None else alarm.severity,
        "alarm latched severity": Severity.NORMAL if alarm is None else alarm.latched_severity,
        "alarms raised": 0 if alarm is None else alarm.count,
    }


def judge_fit(health: Health) -> tuple[Level, str]:
    """Return what is to be said of an input whose measurements are all used."""
    worst = worst_sensor(health.sensor_fits)
    if worst is not None:
        sensor, fit = worst
        errors = f"squared errors are {fit.mean:.2g} times those expected"
        if sensor == BOTH_SPEEDS:
            said = (
                f"speeds do not follow from torques: their {errors}; "
                "check both torques, their scales and offsets, the inertias, and noise.speed_*"
            )
        else:
            said = (
                f"{sensor} fits worst: its {errors}; check it and its noise.* in the parameters, "
                "and the pulleys' scales and inertias"
            )
        return Level.WARN, said
    return Level.OK, "every measurement is used"


def judge_rejected(rejected: tuple[int, ...], *, accepted: bool) -> tuple[Level, str] | None:
    """Return what is to be said of rejections, by `Rejection`; None if there are none."""
    most = max(rejected)
    if not most:
        return None
    reason = Rejection(rejected.index(most))
    return (
        Level.WARN if accepted else Level.ERROR,
        f"{'some' if accepted else 'all'} measurements rejected ({words(reason)}): "
        f"{REJECTION_ADVICE[reason]}",
    )
