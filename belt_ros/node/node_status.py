"""The node's own row of diagnostics: what all its inputs bring, and what they cost (REP-107)."""

import math
from collections.abc import Iterator, Sequence

from diagnostic_msgs.msg import DiagnosticStatus

from belt_ros.diagnostic_rows import words
from belt_ros.estimation import Rejection
from belt_ros.node.diagnostics import MISSING, status_row
from belt_ros.node.input_meter import InputReport
from belt_ros.node.source_meter import missing_messages

_BUSY = 0.8  # share of the time at which estimation leaves too little for the rest
_LATE = 0.1  # [s]


def node_status(
    node_name: str, reports: Sequence[InputReport], pooled: float = 0.0
) -> DiagnosticStatus:
    """Return the row of the node, of the period that ends now; drives' rows count since the start.

    Parameters
    ----------
    node_name : str
    reports : sequence of InputReport
        Of every drive that is active, over the same period.
    pooled : float
        Time over which measurements are averaged because the node cannot follow all of them [s].
    """
    received = sum(report.received for report in reports)
    period = max((report.period for report in reports), default=0.0)
    values: dict[str, float] = {
        "drives": len(reports),
        "silent drives": sum(report.silent for report in reports),
        "input rate [Hz]": sum(report.rate for report in reports),
        "pooled for want of processor [s]": pooled,
    }
    busy = 0.0
    if received:
        spent = sum(report.processing_mean * report.received for report in _heard(reports))
        busy = spent / period if period > 0.0 else 0.0
        values["processing share [-]"] = busy
        values["processing mean [ms]"] = 1e3 * spent / received
        values["processing max [ms]"] = 1e3 * max(r.processing_max for r in _heard(reports))
        late = sum(report.latency_mean * report.received for report in _heard(reports))
        values["latency mean [ms]"] = 1e3 * late / received
        values["latency max [ms]"] = 1e3 * max(r.latency_max for r in _heard(reports))
    values[MISSING] = missing_messages(source for report in reports for source in report.sources)
    for reason in Rejection:
        if reason is not Rejection.NONE:
            values[f"rejected {words(reason)} in period"] = sum(
                report.rejected[reason] for report in reports
            )
    latency = values.get("latency mean [ms]", math.nan) * 1e-3
    level, message = _judge(reports, busy, latency, pooled)
    return status_row(f"{node_name}: node", node_name, level, message, values)


def _heard(reports: Sequence[InputReport]) -> list[InputReport]:
    return [report for report in reports if report.received]


def _judge(
    reports: Sequence[InputReport], busy: float, latency: float, pooled: float
) -> tuple[bytes, str]:
    silent = sum(report.silent for report in reports)
    if silent == len(reports):
        return DiagnosticStatus.STALE, "no drive sends anything: see the rows of the inputs"
    trouble = list(_short_of_time(busy, latency, pooled))
    if silent:
        trouble.append(f"{silent} silent")
    rejected = sum(sum(report.rejected) for report in reports)
    if rejected:
        trouble.append(f"{rejected} measurements rejected")
    count = f"{len(reports)} drives" if len(reports) != 1 else "1 drive"
    return (
        DiagnosticStatus.WARN if trouble else DiagnosticStatus.OK,
        "; ".join([count, *trouble]),
    )


def _short_of_time(busy: float, latency: float, pooled: float) -> Iterator[str]:
    if pooled:
        yield (
            f"the processor is short, measurements are averaged over up to {pooled:.2f} s: lower "
            "the input's rate, or divide the drives between several nodes"
        )
    elif busy > _BUSY:
        yield (
            f"estimation takes {busy:.0%} of the time: lower the input's rate, or divide the "
            "drives between several nodes"
        )
    if latency > _LATE + pooled:
        yield (
            f"messages are {latency:.2f} s old when they arrive: check the clocks of sender and "
            "receiver, and the load of this machine"
        )
