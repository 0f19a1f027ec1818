"""Diagnostics as functions of numbers (REP-107).

Units stand in the key and the value is nothing but a number, so that plotting tools read it.
"""

import math
from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from belt_ros.diagnostic_rows import (
    REJECTION_ADVICE,
    Level,
    drive_row,
    judge_fit,
    number_text,
    words,
)
from belt_ros.estimation import AlarmStatus, BeltEstimate, Health, Rejection
from belt_ros.estimation.calibration import CalibrationResult
from belt_ros.node.input_meter import InputReport
from belt_ros.node.memory import MemoryReport, span
from belt_ros.node.source_meter import (
    SKEW_LIMIT,
    clock_skew,
    clock_trouble,
    missing_messages,
)

MISSING = "missing messages in period"
_MISSED = 0.01  # of what came, beyond which what is missing is to be looked at


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
    row = drive_row(node_name, drive_name, estimate, alarm, unused, greatest_gap)
    return status_row(row.name, row.hardware_id, _byte(row.level), row.message, row.values)


def _byte(level: Level) -> bytes:
    return bytes((level,))


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
    values[MISSING] = missing_messages(report.sources)
    for source in report.sources if len(report.sources) > 1 else ():
        values[f"rate of {source.topic} [Hz]"] = source.rate
    for reason, count in zip(Rejection, health.rejections, strict=True):
        if reason is not Rejection.NONE:
            values[f"rejected {words(reason)}"] = count
    for sensor, fit in health.sensor_fits:
        values[f"fit {sensor} mean [-]"] = fit.mean
    return status_row(f"{node_name}: {drive_name} input", drive_name, level, message, values)


def _judge_input(
    topic: str, report: InputReport, health: Health, greatest_gap: float, skew_limit: float
) -> tuple[bytes, str]:
    if report.silence > greatest_gap and any(source.rate > 0.0 for source in report.sources):
        return (
            DiagnosticStatus.STALE,
            f"messages come on {topic}, but nothing of this drive for {report.silence:.1f} s: "
            "check driver.joint and driven.joint against the names in them",
        )
    if report.silence > greatest_gap:
        return (
            DiagnosticStatus.STALE,
            f"nothing on {topic} for {report.silence:.1f} s: check that it is published, under "
            "that name, and with a QoS that input_reliability accepts",
        )
    trouble = clock_trouble(report.sources, skew_limit)
    if any(report.rejected):
        every = report.accepted == 0 or health.accepted == 0  # those that wait count in the former
        return (
            DiagnosticStatus.ERROR if every else DiagnosticStatus.WARN,
            f"{'all' if every else 'some'} measurements rejected "
            f"({words(report.main_rejection)}): {_advice(report, trouble)}",
        )
    if trouble:
        return DiagnosticStatus.WARN, trouble
    missing = missing_messages(report.sources)
    if missing > _MISSED * report.received:
        return (
            DiagnosticStatus.WARN,
            f"{missing:.0f} messages are missing, by the stamps of those that came: lost on the "
            "network (input_reliability: reliable), or dropped from a full queue (input_depth)",
        )
    level, message = judge_fit(health)
    return _byte(level), message


def _advice(report: InputReport, trouble: str) -> str:
    """Return what to do about rejections; `trouble` is what is wrong with the clocks, or ""."""
    reason = report.main_rejection
    # Stamps that are too far apart are dropped, or leave what they belong to incomplete.
    causes = [trouble] if reason in {Rejection.OUT_OF_ORDER, Rejection.INCOMPLETE} else []
    if reason is Rejection.INCOMPLETE:
        causes.append(_of_silent_topics(report))
    return "; ".join(filter(None, causes)) or REJECTION_ADVICE[reason]


def _of_silent_topics(report: InputReport) -> str:
    """Return which topics bring nothing, where others do; "" if none or all are silent."""
    silent = [source.topic for source in report.sources if not source.rate > 0.0]
    if not silent or len(silent) == len(report.sources):
        return ""
    return f"nothing on {', '.join(silent)}: check that it is published, and under that name"


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


def status_row(
    name: str, hardware_id: str, level: bytes, message: str, values: Mapping[str, float]
) -> DiagnosticStatus:
    """Return a row; units stand in the keys of `values`."""
    return DiagnosticStatus(
        level=level,
        name=name,
        hardware_id=hardware_id,
        message=message,
        values=[
            KeyValue(key=key, value=number_text(value))
            for key, value in values.items()
            if math.isfinite(value)
        ],
    )
