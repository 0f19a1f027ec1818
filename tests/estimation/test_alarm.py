import dataclasses

import pytest

from belt_ros.estimation import (
    AlarmSettings,
    BeltEstimate,
    BeltMonitor,
    Condition,
    Measurement,
    Phase,
    Quantity,
    Severity,
)
from belt_ros.estimation.alarm import SlipAlarm
from belt_ros.estimation.estimate import probability_below
from belt_ros.mechanics import Belt, BeltDrive, Pulley

PULLEY = Pulley(0.1, 3.14, 0.5, 1e8, 0.05)
DRIVE = BeltDrive(Belt(8e4), PULLEY, PULLEY, 0.5)
SETTINGS = AlarmSettings(on_delay=0.2, off_delay=1.0)
PERIOD_NS = 10_000_000


@pytest.fixture(scope="module")
def healthy() -> BeltEstimate:
    output = BeltMonitor("drive", DRIVE).step(Measurement(0, 100.0, 100.0, 1.0, -1.0))
    assert output.estimate is not None
    return dataclasses.replace(
        output.estimate,
        phase=Phase.RUNNING,
        margin=Quantity(0.6, 0.02),
        slip=Quantity(0.005, 1e-4),
        excess_slip=Quantity(0.0, 1e-4),
    )


class Line:
    """Feeds estimates at 100 Hz and notes when the alarm's status changes."""

    def __init__(self, healthy: BeltEstimate, settings: AlarmSettings = SETTINGS) -> None:
        self.alarm = SlipAlarm("drive 3", settings)
        self.healthy = healthy
        self.now = 0
        self.first = self.alarm.update(healthy)
        self.changes = []

    def feed(self, seconds: float, **changes: object) -> "Line":
        for _ in range(round(seconds * 1e9 / PERIOD_NS)):
            self.now += PERIOD_NS
            estimate = dataclasses.replace(self.healthy, stamp_ns=self.now, **changes)
            status = self.alarm.update(estimate)
            if status is not None:
                self.changes.append((round(self.now * 1e-9, 3), status))
        return self

    @property
    def last(self):
        return self.changes[-1][1]


def test_nothing_is_raised_while_all_is_well(healthy) -> None:
    assert Line(healthy).feed(5.0).changes == []


def test_the_first_estimate_announces_that_all_is_well(healthy) -> None:
    line = Line(healthy)
    assert line.first is not None
    assert line.first.severity is Severity.NORMAL


def test_a_low_margin_is_raised_after_the_on_delay(healthy) -> None:
    line = Line(healthy).feed(1.0).feed(1.0, margin=Quantity(0.15, 0.01))
    time, status = line.changes[0]
    assert time == pytest.approx(1.21, abs=0.011)
    assert (status.condition, status.severity) == (Condition.LOW_MARGIN, Severity.WARNING)
    assert "15% margin" in status.message


def test_a_margin_that_the_data_cannot_tell_raises_nothing(healthy) -> None:
    assert Line(healthy).feed(5.0, margin=Quantity(0.2, 0.3)).changes == []


def test_a_dip_shorter_than_the_on_delay_raises_nothing(healthy) -> None:
    line = Line(healthy)
    for _ in range(10):
        line.feed(0.15, margin=Quantity(0.02, 0.001)).feed(0.05)
    assert line.changes == []


def test_chatter_inside_the_deadband_does_not_flap(healthy) -> None:
    line = Line(healthy).feed(0.5, margin=Quantity(0.2, 0.05))
    for _ in range(20):
        line.feed(0.3, margin=Quantity(0.251, 0.05)).feed(0.3, margin=Quantity(0.24, 0.05))
    assert len(line.changes) == 1


def test_it_clears_after_the_off_delay_and_stays_latched_until_acknowledged(healthy) -> None:
    line = Line(healthy).feed(0.5, margin=Quantity(0.05, 0.01)).feed(3.0)
    assert line.last.severity is Severity.NORMAL
    assert line.last.latched_severity is Severity.ALARM
    assert not line.last.acknowledged
    cleared = line.changes[-1][0]
    assert cleared == pytest.approx(1.51, abs=0.02)
    acknowledged = line.alarm.acknowledge(line.healthy)
    assert acknowledged.acknowledged
    assert acknowledged.latched_severity is Severity.NORMAL


def test_acknowledging_does_not_hide_a_condition_that_holds(healthy) -> None:
    line = Line(healthy).feed(0.5, margin=Quantity(0.05, 0.01))
    status = line.alarm.acknowledge(line.healthy)
    assert status.active
    assert status.latched_severity is Severity.ALARM


def test_gross_slip_trips_whatever_the_margin_says(healthy) -> None:
    line = Line(healthy).feed(0.5, excess_slip=Quantity(0.4, 0.001), slip=Quantity(0.41, 0.001))
    assert (line.last.condition, line.last.severity) == (Condition.GROSS_SLIP, Severity.TRIP)
    assert "41% of the driver's travel" in line.last.message


def test_slip_at_standstill_is_no_slip(healthy) -> None:
    line = Line(healthy).feed(3.0, phase=Phase.STANDSTILL, excess_slip=Quantity(0.9, 0.001))
    assert line.changes == []


def test_occurrences_are_counted_with_their_times(healthy) -> None:
    line = Line(healthy)
    for _ in range(3):
        line.feed(0.5, margin=Quantity(0.05, 0.01)).feed(2.0)
    assert line.last.count == 3
    assert line.last.first_ns < line.last.last_ns <= line.now


@pytest.mark.parametrize(("stddev", "expected"), [(0.0, 1.0), (0.1, 0.8413447)])
def test_probability_below_a_limit(stddev, expected) -> None:
    assert probability_below(Quantity(0.1, stddev), 0.2) == pytest.approx(expected)
