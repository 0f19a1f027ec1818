"""Diagnostics as functions of numbers: levels, advice, and values that parse."""

import dataclasses
import math
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from node_harness import PAPER_DRIVE

from belt_ros.estimation import (
    AlarmStatus,
    BeltEstimate,
    Condition,
    Health,
    Measurement,
    Phase,
    Quantity,
    Rejection,
    Severity,
)
from belt_ros.estimation.estimate import Consistency, Fit, LostTraction, Reserve
from belt_ros.node.diagnostics import REJECTION_ADVICE, drive_status, input_status
from belt_ros.node.input_meter import InputMeter, InputReport
from belt_ros.node.node_status import node_status
from belt_ros.node.source_meter import SourceReport
from belt_ros.settings import load_settings


@pytest.fixture(scope="module")
def estimate() -> BeltEstimate:
    monitor = load_settings(PAPER_DRIVE).monitor()
    estimate = monitor.step(Measurement(5, 120.0, 119.4, 30.0, -30.0)).estimate
    assert estimate is not None
    return dataclasses.replace(estimate, phase=Phase.RUNNING, margin=Quantity(0.5, 0.1))


def alarm(severity: Severity, **changes: Any) -> AlarmStatus:
    condition = Condition.LOW_MARGIN if severity else Condition.NONE
    fields: dict[str, Any] = {
        "stamp_ns": 5,
        "condition": condition,
        "severity": severity,
        "latched_severity": severity,
        "acknowledged": severity is Severity.NORMAL,
        "margin": Quantity(0.1, 0.01),
        "excess_slip": 0.0,
        "gross_slip_probability": 0.0,
        "count": 3,
        "first_ns": 1,
        "last_ns": 5,
        "message": "Reduce load.",
    }
    return AlarmStatus(**fields | changes)


def drive_row(estimate: BeltEstimate | None, status: AlarmStatus | None, unused: float = 0.1):
    return drive_status("belt_node", "paper_drive", estimate, status, unused, 1.0)


@pytest.mark.parametrize(
    ("severity", "level"),
    [
        (Severity.NORMAL, DiagnosticStatus.OK),
        (Severity.WARNING, DiagnosticStatus.WARN),
        (Severity.ALARM, DiagnosticStatus.ERROR),
        (Severity.TRIP, DiagnosticStatus.ERROR),
    ],
)
def test_the_level_is_that_of_the_alarm(
    estimate: BeltEstimate, severity: Severity, level: bytes
) -> None:
    assert drive_row(estimate, alarm(severity)).level == level


def test_an_alarm_says_what_to_do(estimate: BeltEstimate) -> None:
    assert drive_row(estimate, alarm(Severity.WARNING)).message == "Reduce load."


def test_name_and_hardware_are_those_of_the_drive(estimate: BeltEstimate) -> None:
    row = drive_row(estimate, None)

    assert row.name == "belt_node: paper_drive"
    assert row.hardware_id == "paper_drive"
    assert row.message == "running, 50% margin"


@pytest.mark.parametrize("known", [True, False])
def test_an_old_or_missing_estimate_is_stale(estimate: BeltEstimate, known: bool) -> None:
    row = drive_row(estimate if known else None, None, unused=3.0)

    assert row.level == DiagnosticStatus.STALE
    assert "3.0 s" in row.message


def test_staleness_outweighs_an_alarm(estimate: BeltEstimate) -> None:
    assert drive_row(estimate, alarm(Severity.TRIP), 3.0).level == DiagnosticStatus.STALE


@pytest.mark.parametrize("severity", [Severity.NORMAL, Severity.WARNING])
def test_a_lost_filter_is_an_error(estimate: BeltEstimate, severity: Severity) -> None:
    lost = dataclasses.replace(estimate, phase=Phase.LOST)

    row = drive_row(lost, alarm(severity))

    assert row.level == DiagnosticStatus.ERROR
    assert "check radii" in row.message


def test_an_alarm_that_is_over_wants_acknowledging(estimate: BeltEstimate) -> None:
    over = alarm(Severity.NORMAL, latched_severity=Severity.TRIP, acknowledged=False)

    row = drive_row(estimate, over)

    assert row.level == DiagnosticStatus.WARN
    assert "acknowledge" in row.message


def report(**changes: Any) -> InputReport:
    fields: dict[str, Any] = {
        "period": 2.0,
        "received": 100,
        "rejected": (0,) * len(Rejection),
        "latency_mean": 0.001,
        "latency_max": 0.002,
        "processing_mean": 0.0005,
        "processing_max": 0.0006,
        "silence": 0.01,
        "unused": 0.01,
    }
    return InputReport(**fields | changes)


HEALTH = Health(1.0, 4, 123456789, 2, Rejection.GATED, (0, 1, 0, 0, 0, 5, 0, 0))


WRONG = Fit(Consistency.OVERCONFIDENT, 3.2, 0.4, 1.25)
RIGHT = Fit(Consistency.CONSISTENT, 1.1, 0.4, 1.25)
SENSORS = ("driver speed", "driver torque")


def input_row(summary: InputReport, health: Health = HEALTH) -> DiagnosticStatus:
    return input_status("belt_node", "paper_drive", "/joint_states", summary, health, 1.0)


def fitted(fit: Fit, *sensors: Fit) -> Health:
    return dataclasses.replace(
        HEALTH, fit=fit, sensor_fits=tuple(zip(SENSORS, sensors, strict=True))
    )


def test_the_nodes_row_knows_slow_input_from_silence() -> None:
    """Nothing may come in a period, so long as the silence is not longer than it may be."""
    slow = report(received=0, silence=1.9, silent=False)
    row = node_status("belt_node", [slow, report()])
    assert (row.level, row.message) == (DiagnosticStatus.OK, "2 drives")
    row = node_status("belt_node", [report(received=0, silence=5.1, silent=True), report()])
    assert (row.level, row.message) == (DiagnosticStatus.WARN, "2 drives; 1 silent")
    assert node_status("belt_node", [slow]).level == DiagnosticStatus.OK


def test_the_nodes_row_counts_what_was_rejected_in_the_period() -> None:
    """Drives' rows count since the start; the same key must not mean two things."""
    row = node_status("belt_node", [report(rejected=rejected(Rejection.GATED, 2)), report()])
    values = {pair.key: pair.value for pair in row.values}
    assert values["rejected gated in period"] == "2"
    assert "rejected gated" not in values


def test_the_nodes_row_tells_that_it_pools_for_want_of_processor() -> None:
    row = node_status("belt_node", [report(), report()], pooled=0.0667)
    assert row.level == DiagnosticStatus.WARN
    assert "averaged over up to 0.07 s" in row.message
    values = {pair.key: pair.value for pair in row.values}
    assert values["pooled for want of processor [s]"] == "0.0667"
    values = {pair.key: pair.value for pair in node_status("belt_node", [report()]).values}
    assert values["pooled for want of processor [s]"] == "0"


def test_what_else_is_wrong_is_told_beside_the_pooling() -> None:
    behind = report(latency_mean=2.0, rejected=rejected(Rejection.GATED, 5))
    row = node_status("belt_node", [behind, report(silent=True)], pooled=0.2)
    for part in ("averaged over up to 0.20 s", "s old when they arrive", "1 silent", "5 meas"):
        assert part in row.message


def test_messages_that_are_missing_by_their_stamps_are_told_once_for_each_topic() -> None:
    sources = [SourceReport("/joint_states", 50.0, 0.001, 0.002, 0.0, 0.01, missing=7.0)]
    row = input_row(report(sources=sources))
    assert row.level == DiagnosticStatus.WARN
    assert "7 messages are missing" in row.message
    row = node_status("belt_node", [report(sources=sources), report(sources=sources)])
    assert {pair.key: pair.value for pair in row.values}["missing messages in period"] == "7"

    row = input_row(report(sources=[dataclasses.replace(sources[0], missing=1.0)]))
    assert "missing" not in row.message
    row = input_row(report(sources=[dataclasses.replace(sources[0], missing=math.nan)]))
    assert "missing messages in period" not in {pair.key for pair in row.values}


def test_messages_of_none_but_others_are_told_from_silence() -> None:
    others = SourceReport("/joint_states", 100.0, 0.001, 0.002, 0.0, 0.01)
    row = input_row(report(received=0, silence=2.0, sources=(others,)))
    assert row.level == DiagnosticStatus.STALE
    assert "nothing of this drive for 2.0 s: check driver.joint" in row.message


def test_a_silence_is_too_long_once_it_is_longer_than_asked() -> None:
    meter = InputMeter(10.0)
    assert not meter.report(14.0, 5.0).silent
    assert meter.report(15.5, 5.0).silent
    assert not meter.report(99.0).silent


def rejected(reason: Rejection, count: int) -> tuple[int, ...]:
    return tuple(count if place is reason else 0 for place in Rejection)


def test_input_reports_rate_times_and_counts() -> None:
    values = {pair.key: pair.value for pair in input_row(report()).values}

    assert values["input rate [Hz]"] == "50"
    assert values["latency max [ms]"] == "2"
    assert values["processing mean [ms]"] == "0.5"
    assert values["accepted"] == "123456789"
    assert values["rejected"] == "6"
    assert values["rejected gated"] == "5"
    assert values["resets"] == "2"


def test_undisturbed_input_is_ok() -> None:
    assert input_row(report()).level == DiagnosticStatus.OK


@pytest.mark.parametrize("reason", [reason for reason in Rejection if reason])
def test_rejections_warn_with_reason_and_advice(reason: Rejection) -> None:
    row = input_row(report(rejected=rejected(reason, 3)))

    assert row.level == DiagnosticStatus.WARN
    assert reason.name.lower().replace("_", " ") in row.message
    assert REJECTION_ADVICE[reason] in row.message


def test_nothing_but_rejections_is_an_error() -> None:
    row = input_row(report(rejected=rejected(Rejection.MALFORMED, 100)))

    assert row.level == DiagnosticStatus.ERROR


def test_speeds_that_are_missing_with_their_topic_are_looked_for_there() -> None:
    sources = [
        SourceReport("/driver/state", 50.0, 0.001, 0.002, 0.0, 0.01),
        SourceReport("/driven/state", 0.0, math.nan, math.nan, math.nan, 9.0),
    ]
    incomplete = report(rejected=rejected(Rejection.INCOMPLETE, 97), sources=sources)
    row = input_row(incomplete, dataclasses.replace(HEALTH, accepted=0))

    assert row.level == DiagnosticStatus.ERROR  # the other three only wait
    assert "all measurements rejected (incomplete): nothing on /driven/state" in row.message
    assert "joint" not in row.message


AHEAD, BEHIND = (
    SourceReport(topic, 100.0, offset, offset, offset, 0.01)
    for topic, offset in (("/driver/state", 0.001), ("/driven/state", 0.081))
)


@pytest.mark.parametrize("reason", [Rejection.OUT_OF_ORDER, Rejection.INCOMPLETE])
def test_clocks_that_differ_are_told_of_first_where_they_are_why_measurements_are_rejected(
    reason: Rejection,
) -> None:
    """Stamps farther apart than input_reorder_window: the later topic's are dropped."""
    row = input_row(report(rejected=rejected(reason, 50), sources=(AHEAD, BEHIND)))

    assert row.level == DiagnosticStatus.WARN
    assert row.message.startswith(
        f"some measurements rejected ({reason.name.lower().replace('_', ' ')}): the stamps of "
        "/driver/state are 0.08 s ahead of those of /driven/state: synchronise"
    )
    assert REJECTION_ADVICE[reason] not in row.message


def test_clocks_that_differ_excuse_no_topic_that_is_silent() -> None:
    silent = dataclasses.replace(BEHIND, rate=0.0)
    row = input_row(report(rejected=rejected(Rejection.INCOMPLETE, 9), sources=(AHEAD, silent)))
    assert "0.08 s ahead" in row.message
    assert "nothing on /driven/state" in row.message


def test_clocks_that_differ_do_not_hide_that_values_are_impossible() -> None:
    row = input_row(report(rejected=rejected(Rejection.GATED, 9), sources=(AHEAD, BEHIND)))
    assert REJECTION_ADVICE[Rejection.GATED] in row.message


def test_silence_is_stale_and_names_the_topic() -> None:
    row = input_row(report(received=0, silence=2.5))

    assert row.level == DiagnosticStatus.STALE
    assert "/joint_states for 2.5 s" in row.message


def test_a_sensor_that_does_not_fit_is_named() -> None:
    row = input_row(report(), fitted(WRONG, RIGHT, WRONG))

    assert row.level == DiagnosticStatus.WARN
    assert row.message.startswith("driver torque fits worst: its squared errors are 3.2 times")
    values = {pair.key: pair.value for pair in row.values}
    assert values["fit driver torque mean [-]"] == "3.2"
    assert values["fit driver speed mean [-]"] == "1.1"


def test_speeds_that_fit_badly_together_point_to_the_torques() -> None:
    fits = (("driver speed", WRONG), ("driven speed", WRONG), ("driver torque", RIGHT))
    row = input_row(report(), dataclasses.replace(fitted(WRONG, WRONG, RIGHT), sensor_fits=fits))

    assert row.level == DiagnosticStatus.WARN
    assert row.message.startswith("speeds do not follow from torques: their squared errors are 3.2")
    assert "check both torques" in row.message


def test_nothing_is_said_of_sensors_that_fit() -> None:
    assert input_row(report(), fitted(WRONG, RIGHT, RIGHT)).level == DiagnosticStatus.OK


def test_reserve_loss_and_fit_are_reported_with_units(estimate: BeltEstimate) -> None:
    told = dataclasses.replace(
        estimate,
        reserve=Reserve(Quantity(60.0, 4.0), 0.02),
        lost_traction=LostTraction(0.9, 0.7, 0.1),
        health=fitted(WRONG, WRONG, RIGHT),
    )

    values = {pair.key: pair.value for pair in drive_row(told, None).values}

    assert values["capacity torque [N m]"] == "60"
    assert values["capacity torque stddev [N m]"] == "4"
    assert values["gross slip probability at peak load [-]"] == "0.02"
    assert values["traction lost probability [-]"] == "0.9"
    assert values["tension lost probability [-]"] == "0.7"
    assert values["friction lost probability [-]"] == "0.1"
    assert values["fit"] == "2"
    assert values["fit mean [-]"] == "3.2"
    assert values["fit lowest [-]"] == "0.4"
    assert values["fit highest [-]"] == "1.25"


def test_every_value_is_a_number_alone(estimate: BeltEstimate) -> None:
    rows = [drive_row(estimate, alarm(Severity.ALARM)), input_row(report())]

    for row in rows:
        assert row.values
        for pair in row.values:
            float(pair.value)
        assert len({pair.key for pair in row.values}) == len(row.values)


class TestInputMeter:
    def test_counts_one_period_and_begins_the_next(self) -> None:
        meter = InputMeter(10.0)
        meter.count(Rejection.NONE, 0.1, 10.5, 10.6)
        meter.count(Rejection.GATED, 0.3, 11.0, 11.3)

        first, second = meter.report(12.0), meter.report(13.0)

        assert first.rate == pytest.approx(1.0)
        assert first.accepted == 1
        assert first.main_rejection is Rejection.GATED
        assert first.latency_mean == pytest.approx(0.2)
        assert first.latency_max == pytest.approx(0.3)
        assert first.processing_mean == pytest.approx(0.2)
        assert first.processing_max == pytest.approx(0.3)
        assert (second.received, second.main_rejection) == (0, Rejection.NONE)

    def test_tells_silence_from_rejection(self) -> None:
        meter = InputMeter(10.0)
        meter.count(Rejection.NONE, 0.0, 11.0, 11.0)
        meter.count(Rejection.GATED, 0.0, 12.0, 12.0)

        summary = meter.report(14.0)

        assert summary.silence == pytest.approx(2.0)
        assert summary.unused == pytest.approx(3.0)
