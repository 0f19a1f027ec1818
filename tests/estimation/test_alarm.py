import dataclasses

import pytest

from belt_ros.estimation import (
    AlarmSettings,
    BeltEstimate,
    BeltMonitor,
    Condition,
    ConditionStatus,
    Knowledge,
    Measurement,
    Phase,
    Quantity,
    SensorLimits,
    Severity,
    SlipAlarm,
)
from belt_ros.estimation.estimate import LostTraction, probability_below
from belt_ros.mechanics import Belt, BeltDrive, Pulley
from belt_ros.message_fields import alarm_fields, condition_fields

PULLEY = Pulley(0.1, 3.14, 0.5, 1e8, 0.05)
DRIVE = BeltDrive(Belt(8e4), PULLEY, PULLEY, 0.5)
SETTINGS = AlarmSettings(on_delay=0.2, off_delay=1.0, lost_on_delay=0.5)
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

    def feed(self, seconds: float, *, recovers: bool = False, **changes: object) -> "Line":
        for _ in range(round(seconds * 1e9 / PERIOD_NS)):
            self.now += PERIOD_NS
            estimate = dataclasses.replace(self.healthy, stamp_ns=self.now, **changes)
            status = self.alarm.update(estimate, recovers=recovers)
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
    assert "15 % margin" in status.message


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
    assert "41 % of the driver's travel" in line.last.message


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


def test_a_sentence_says_what_is_left_and_what_to_do(healthy) -> None:
    line = Line(healthy)
    line.alarm.installed = 400.0
    tension = Quantity(212.0, 20.0)
    line.feed(0.5, margin=Quantity(0.08, 0.01), mean_tension=tension)
    assert line.last.message == (
        "drive 3: 8 % margin left. Reduce load or re-tension: estimated 212 +/- 20 N, "
        "installed 400 N."
    )


def test_a_learned_tension_is_warned_of_from_a_probability_of_its_own(healthy) -> None:
    early = dataclasses.replace(SETTINGS, learned_confidence=0.5)
    doubtful = Quantity(0.24, 0.04)  # below 0.25 with a probability of 0.6
    learned = {"margin": doubtful, "tension_knowledge": Knowledge.LEARNED}
    assert Line(healthy, early).feed(2.0, margin=doubtful).changes == []
    assert Line(healthy).feed(2.0, **learned).changes == []
    assert Line(healthy, early).feed(2.0, **learned).last.severity is Severity.WARNING


@pytest.mark.parametrize(
    ("lost", "condition"),
    [
        (LostTraction(0.99, 0.5, 0.4), Condition.TRACTION_LOST),
        (LostTraction(0.99, 0.97, 0.1), Condition.TENSION_LOST),
        (LostTraction(0.99, 0.1, 0.97), Condition.FRICTION_LOST),
        (LostTraction(0.99, 0.97, 0.97), Condition.TRACTION_LOST),
    ],
)
def test_a_loss_is_named_only_where_its_cause_is_clear(healthy, lost, condition) -> None:
    line = Line(healthy).feed(2.0, lost_traction=lost)
    assert line.last.condition is condition
    assert line.last.count == 1


def test_a_loss_that_is_probable_but_not_clear_raises_nothing(healthy) -> None:
    assert Line(healthy).feed(3.0, lost_traction=LostTraction(0.9, 0.9, 0.0)).changes == []


def test_a_name_that_changes_back_and_forth_is_not_followed(healthy) -> None:
    line = Line(healthy)
    for _ in range(10):
        line.feed(0.3, lost_traction=LostTraction(0.99, 0.97, 0.1))
        line.feed(0.3, lost_traction=LostTraction(0.99, 0.1, 0.97))
    assert {status.condition for _, status in line.changes} == {Condition.TRACTION_LOST}


def test_a_loss_after_time_began_anew_is_named_as_one_before_was(healthy) -> None:
    lost = LostTraction(0.99, 0.97, 0.1)
    line = Line(healthy).feed(100.0).feed(3.0, lost_traction=lost)
    assert line.last.condition is Condition.TENSION_LOST
    line.feed(3.0)
    line.alarm.acknowledge(line.healthy)
    line.alarm.begin_anew()
    line.now = 0
    line.feed(5.0).feed(1.2, lost_traction=lost)
    assert line.last.active
    assert line.last.condition is Condition.TENSION_LOST


def test_a_lost_estimator_is_an_alarm_and_holds_those_of_the_belt_back(healthy) -> None:
    line = Line(healthy).feed(2.0, phase=Phase.LOST, margin=Quantity(0.01, 0.001))
    assert [each.condition for each in line.last.conditions] == [Condition.ESTIMATOR_LOST]
    line.feed(1.5)
    assert not line.last.active


def test_the_off_delay_of_a_lost_estimator_counts_from_when_it_seems_to_recover(healthy) -> None:
    line = Line(healthy).feed(2.0, phase=Phase.LOST)
    line.feed(0.3, phase=Phase.LOST, recovers=True).feed(2.0)
    at, cleared = line.changes[-1]
    assert not cleared.active
    assert at == pytest.approx(3.0, abs=0.02)  # 1 s after 2.0 s, when it began to recover


def test_an_estimator_that_is_lost_again_stays_lost(healthy) -> None:
    line = Line(healthy).feed(2.0, phase=Phase.LOST)
    line.feed(0.8, phase=Phase.LOST, recovers=True).feed(1.5, phase=Phase.LOST)
    assert line.last.active


def test_a_moments_recovery_does_not_hold_a_lost_estimator_back(healthy) -> None:
    line = Line(healthy).feed(0.3, phase=Phase.LOST)
    line.feed(0.1, phase=Phase.LOST, recovers=True).feed(0.2, phase=Phase.LOST)
    assert [each.condition for each in line.last.conditions] == [Condition.ESTIMATOR_LOST]


def test_an_alarm_that_was_raised_before_stays_while_the_estimator_is_lost(healthy) -> None:
    low = Quantity(0.05, 0.01)
    line = Line(healthy).feed(1.0, margin=low).feed(1.0, margin=low, phase=Phase.LOST)
    assert [each.condition for each in line.last.conditions] == [
        Condition.ESTIMATOR_LOST,  # of equal severity, what the other rests on comes first
        Condition.LOW_MARGIN,
    ]


def test_slip_against_the_power_is_a_sensor_and_no_slip(healthy) -> None:
    line = Line(healthy).feed(
        1.0, transmitted_torque=Quantity(30.0, 0.1), excess_slip=Quantity(-0.05, 1e-3)
    )
    assert [each.condition for each in line.last.conditions] == [Condition.SENSOR_IMPLAUSIBLE]


def test_regenerating_turns_the_slip_that_counts(healthy) -> None:
    line = Line(healthy).feed(
        1.0, transmitted_torque=Quantity(-30.0, 0.1), excess_slip=Quantity(-0.05, 1e-3)
    )
    assert line.last.condition is Condition.EXCESS_SLIP


def test_nothing_is_raised_for_the_bypass_after_motion_begins(healthy) -> None:
    bypassed = dataclasses.replace(SETTINGS, start_bypass=2.0)
    low = {"margin": Quantity(0.05, 0.01)}
    line = Line(healthy, bypassed).feed(1.0, phase=Phase.STANDSTILL).feed(1.9, **low)
    assert line.changes == []
    line.feed(0.5, **low)
    assert line.last.severity is Severity.ALARM


def test_a_threshold_that_changes_counts_from_then_on(healthy) -> None:
    line = Line(healthy).feed(1.0, margin=Quantity(0.3, 0.01))
    assert line.changes == []
    line.alarm.retune(dataclasses.replace(SETTINGS, margin_warning=0.4), SensorLimits())
    line.feed(0.5, margin=Quantity(0.3, 0.01))
    assert line.last.condition is Condition.LOW_MARGIN


def test_the_worst_stands_first_and_what_waits_is_told_too(healthy) -> None:
    line = Line(healthy).feed(0.5, excess_slip=Quantity(0.05, 1e-3)).feed(2.0)
    line.feed(0.5, margin=Quantity(0.2, 0.01))
    status = line.last
    assert [(each.condition, each.severity) for each in status.conditions] == [
        (Condition.LOW_MARGIN, Severity.WARNING),
        (Condition.EXCESS_SLIP, Severity.NORMAL),
    ]
    assert (status.condition, status.severity) == (Condition.LOW_MARGIN, Severity.WARNING)
    assert status.latched_severity is Severity.ALARM
    assert not status.acknowledged


def test_the_fields_of_a_message_are_those_of_the_conditions(healthy) -> None:
    line = Line(healthy).feed(0.5, margin=Quantity(0.05, 0.01))
    (condition,) = line.last.conditions
    fields = condition_fields(condition)
    assert fields["condition"] == Condition.LOW_MARGIN
    assert fields["message"] == line.last.message == alarm_fields("x", line.last)["message"]
    assert set(fields) == set(ConditionStatus.__dataclass_fields__) - {"first_ns", "last_ns"}
