"""Diagnostics as functions of numbers (REP-107).

Units stand in the key and the value is nothing but a number, so that plotting tools read it.
"""

import math
from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from belt_ros.estimation import AlarmStatus, BeltEstimate, Health, Phase, Rejection, Severity
from belt_ros.estimation.calibration import CalibrationResult
from belt_ros.estimation.fit import worst_sensor
from belt_ros.node.input_meter import InputReport
from belt_ros.node.memory import MemoryReport, span
from belt_ros.node.source_meter import SKEW_LIMIT, clock_skew, clock_trouble

REJECTION_ADVICE: dict[Rejection, str] = {
    Rejection.NONE: "accepted",
    Rejection.NOT_FINITE: "all values are NaN, or one is infinite: check the sensor and its driver",
    Rejection.OUT_OF_RANGE: "a speed or torque is beyond limits.*: check the sensor and its units",
    Rejection.STALE: "older than allowed: check the clocks of sender and receiver",
    Rejection.OUT_OF_ORDER: "the stamp does not follow the one before: check that the sender "
    "stamps its messages, and that there is only one",
    Rejection.GATED: "statistically impossible: check the sensor, and noise.* in the parameters",
    Rejection.INCOMPLETE: "a named joint or its velocity is missing: check driver.joint and "
    "driven.joint against the names in the message",
    Rejection.MALFORMED: "arrays empty, too long or of unequal length, or an impossible stamp: "
    "check the sender",
}
_LEVELS = {
    Severity.NORMAL: DiagnosticStatus.OK,
    Severity.WARNING: DiagnosticStatus.WARN,
    Severity.ALARM: DiagnosticStatus.ERROR,
    Severity.TRIP: DiagnosticStatus.ERROR,
}
_LOST_ADVICE = (
    "the measurements contradict the drive description: check radii, signs and torque scales, "
    "then reset"
)


def drive_status(
    node_name: str,
    drive_name: str,
    estimate: BeltEstimate | None,
    alarm: AlarmStatus | None,
    unused: float,
    greatest_gap: float,
) -> DiagnosticStatus:
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
    values = {} if estimate is None else _drive_values(estimate, alarm)
    return status_row(f"{node_name}: {drive_name}", drive_name, level, message, values)


def _judge_drive(
    estimate: BeltEstimate | None, alarm: AlarmStatus | None, unused: float, greatest_gap: float
) -> tuple[bytes, str]:
    if estimate is None or unused > greatest_gap:
        return (
            DiagnosticStatus.STALE,
            f"no usable measurement for {unused:.1f} s: see the row of the input",
        )
    if alarm is not None and alarm.severity > Severity.WARNING:
        return _LEVELS[alarm.severity], alarm.message
    if estimate.phase is Phase.LOST:
        return DiagnosticStatus.ERROR, _LOST_ADVICE
    if alarm is not None and alarm.active:
        return _LEVELS[alarm.severity], alarm.message
    if alarm is not None and not alarm.acknowledged:
        return (
            DiagnosticStatus.WARN,
            f"{alarm.latched_severity.name.lower()} is over but not acknowledged: find its cause, "
            "then acknowledge",
        )
    return (
        DiagnosticStatus.OK,
        f"{estimate.phase.name.lower().replace('_', ' ')}, {estimate.margin.value:.0%} margin",
    )


def _drive_values(estimate: BeltEstimate, alarm: AlarmStatus | None) -> dict[str, float]:
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
    values["alarm severity"] = Severity.NORMAL if alarm is None else alarm.severity
    values["alarm latched severity"] = Severity.NORMAL if alarm is None else alarm.latched_severity
    values["alarms raised"] = 0 if alarm is None else alarm.count
    return values


def input_status(
    node_name: str,
    drive_name: str,
    topic: str,
    report: InputReport,
    health: Health,
    greatest_gap: float,
    skew_limit: float = SKEW_LIMIT,
) -> DiagnosticStatus:
    """Return the row of a drive's input: what arrives on `topic`, and what becomes of it.

    Counts are since start or reset, rates and times of the period that `report` is about.
    """
    level, message = _judge_input(topic, report, health, greatest_gap, skew_limit)
    values: dict[str, float] = {
        "input rate [Hz]": report.rate,
        "accepted": health.accepted,
        "resets": health.resets,
        "rejected": sum(health.rejections),
    }
    if report.received:
        values |= {
            "latency mean [ms]": 1e3 * report.latency_mean,
            "latency max [ms]": 1e3 * report.latency_max,
            "processing mean [ms]": 1e3 * report.processing_mean,
            "processing max [ms]": 1e3 * report.processing_max,
        }
    skew = clock_skew(report.sources)
    if skew is not None:
        values["clock skew [ms]"] = 1e3 * skew.seconds
    for source in report.sources if len(report.sources) > 1 else ():
        values[f"rate of {source.topic} [Hz]"] = source.rate
    for reason, count in zip(Rejection, health.rejections, strict=True):
        if reason is not Rejection.NONE:
            values[f"rejected {_words(reason)}"] = count
    for sensor, fit in health.sensor_fits:
        values[f"fit {sensor} mean [-]"] = fit.mean
    return status_row(f"{node_name}: {drive_name} input", drive_name, level, message, values)


def _judge_input(
    topic: str, report: InputReport, health: Health, greatest_gap: float, skew_limit: float
) -> tuple[bytes, str]:
    if report.silence > greatest_gap:
        return (
            DiagnosticStatus.STALE,
            f"nothing on {topic} for {report.silence:.1f} s: check that it is published, under "
            "that name, and with a QoS that input_reliability accepts",
        )
    rejected = sum(report.rejected)
    if rejected:
        reason = report.main_rejection
        every = report.accepted == 0
        return (
            DiagnosticStatus.ERROR if every else DiagnosticStatus.WARN,
            f"{'all' if every else 'some'} measurements rejected ({_words(reason)}): "
            f"{REJECTION_ADVICE[reason]}",
        )
    trouble = clock_trouble(report.sources, skew_limit)
    if trouble:
        return DiagnosticStatus.WARN, trouble
    return _judge_fit(health)


def _judge_fit(health: Health) -> tuple[bytes, str]:
    worst = worst_sensor(health.sensor_fits)
    if worst is not None:
        sensor, fit = worst
        return (
            DiagnosticStatus.WARN,
            f"{sensor} fits worst: its squared errors are {fit.mean:.2g} times those expected; "
            "check it and its noise.* in the parameters, and the pulleys' scales and inertias",
        )
    return DiagnosticStatus.OK, "every measurement is used"


def memory_status(node_name: str, drive_name: str, report: MemoryReport) -> DiagnosticStatus:
    """Return the row of what is kept from one run to the next."""
    restored, saved = not math.isnan(report.restored_age), not math.isnan(report.since_saved)
    values: dict[str, float] = {"restored": int(restored), "saves": report.saves}
    if restored:
        values["age when restored [s]"] = report.restored_age
    if saved:
        values["since saved [s]"] = report.since_saved
    if report.trouble:
        level, message = DiagnosticStatus.WARN, report.trouble
    else:
        level = DiagnosticStatus.OK
        since = f"saved {span(report.since_saved)} ago" if saved else "nothing saved yet"
        began = f"what was learned {span(report.restored_age)} before" if restored else "the priors"
        message = f"{since}; the run began with {began}"
    return status_row(f"{node_name}: {drive_name} memory", drive_name, level, message, values)


def calibration_status(
    node_name: str, drive_name: str, result: CalibrationResult | None
) -> DiagnosticStatus:
    """Return the row of the last calibration; `result` is None while it goes on."""
    level, message = DiagnosticStatus.OK, "turn the drive steadily and without load"
    values: dict[str, float] = {"running": int(result is None)}
    if result is not None:
        message = result.message
        values["samples"] = result.samples
        if result.ratio_bias is None:
            level = DiagnosticStatus.WARN
        for key, quantity in (
            ("ratio bias [-]", result.ratio_bias),
            ("driver torque at no load [N m]", result.driver_torque_offset),
            ("driven torque at no load [N m]", result.driven_torque_offset),
        ):
            if quantity is not None:
                name, _, unit = key.partition(" [")
                values[key] = quantity.value
                values[f"{name} stddev [{unit}"] = quantity.stddev
    return status_row(f"{node_name}: {drive_name} calibration", drive_name, level, message, values)


def _words(reason: Rejection) -> str:
    return reason.name.lower().replace("_", " ")


def status_row(
    name: str, hardware_id: str, level: bytes, message: str, values: Mapping[str, float]
) -> DiagnosticStatus:
    """Return a row; units stand in the keys of `values`."""
    return DiagnosticStatus(
        level=level,
        name=name,
        hardware_id=hardware_id,
        message=message,
        values=[KeyValue(key=key, value=_number(value)) for key, value in values.items()],
    )


def _number(value: float) -> str:
    return str(int(value)) if isinstance(value, int) else f"{value:.6g}"
