"""Alarms about sensors: silent, missing, implausible; and what they hold back."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from runs import Run, Runner

from belt_ros.estimation import (
    AlarmStatus,
    BeltMonitor,
    Condition,
    Maintenance,
    MaintenanceKind,
    Measurement,
    Severity,
)
from belt_ros.estimation.channels import Channels
from belt_ros.estimation.measurement import Sensor
from belt_ros.mechanics import Belt, BeltDrive, Pulley

PULLEY = Pulley(0.1, 3.14, 0.5, 1e8, 0.05)
DRIVE = BeltDrive(Belt(8e4), PULLEY, PULLEY, 0.5)
PERIOD_NS = 10_000_000
OF_THE_BELT = {
    Condition.LOW_MARGIN,
    Condition.EXCESS_SLIP,
    Condition.GROSS_SLIP,
    Condition.TRACTION_LOST,
    Condition.TENSION_LOST,
    Condition.FRICTION_LOST,
}
SCENARIO = {
    "duration": 7.5,
    "sample_rate": 100.0,
    "seed": 5,
    "speed": [[0.2, 0.0], [1.7, 120.0]],
    "load": [[1.8, 0.0], [2.0, 30.0]],
    "condition__tension": 440.0,
    "condition__friction_stiffness": 6e6,
}


class Feed:
    """A monitor of a steady drive, fed at 100 Hz."""

    def __init__(self) -> None:
        self.monitor = BeltMonitor("drive", DRIVE)
        self.now = 0
        self.status: AlarmStatus | None = None

    def steady(self, seconds: float, **changes: float) -> "Feed":
        for _ in range(round(seconds * 1e9 / PERIOD_NS)):
            self.now += PERIOD_NS
            reading = Measurement(self.now, 100.0, 100.0, 1.0, -1.0)
            output = self.monitor.step(dataclasses.replace(reading, **changes))
            self.status = output.alarm or self.status
        return self

    def raised(self) -> dict[Condition, Severity]:
        assert self.status is not None
        return {each.condition: each.severity for each in self.status.conditions if each.active}


def raised_in(run: Run) -> dict[Condition, float]:
    """When each condition was first raised [s]."""
    found: dict[Condition, float] = {}
    for output in run.outputs:
        for each in () if output.alarm is None else output.alarm.conditions:
            if each.active:
                found.setdefault(each.condition, each.first_ns * 1e-9)
    return found


def last_of(run: Run) -> AlarmStatus:
    return [output.alarm for output in run.outputs if output.alarm is not None][-1]


def test_silence_beyond_the_greatest_gap_is_a_stale_sensor() -> None:
    feed = Feed().steady(1.0)
    assert feed.monitor.silent(feed.now + 10**9, 1.0) is None
    status = feed.monitor.silent(feed.now + 1_200_000_000, 1.2)
    assert status is not None
    assert (status.condition, status.severity) == (Condition.SENSOR_STALE, Severity.ALARM)
    assert "no usable measurement for 1.2 s" in status.message
    assert feed.monitor.silent(feed.now + 1_400_000_000, 1.4) is None  # no news


def test_silence_before_the_first_measurement_is_a_stale_sensor_after_ten_seconds() -> None:
    monitor = BeltMonitor("drive", DRIVE)
    assert monitor.acknowledge() is None
    assert monitor.silent(9 * 10**9, 9.0) is None  # a driver may start after the node
    status = monitor.silent(11 * 10**9, 11.0)
    assert status is not None
    assert (status.condition, status.severity) == (Condition.SENSOR_STALE, Severity.ALARM)
    assert status.message == (
        "drive: no usable measurement for 11.0 s: check sensors and network. "
        "Nothing is known of the belt yet."
    )
    assert (status.margin.value, status.excess_slip, status.gross_slip_probability) == (0.5, 0, 0)
    assert monitor.silent(12 * 10**9, 12.0) is None  # no news
    acknowledged = monitor.acknowledge()
    assert acknowledged is not None
    assert acknowledged.severity is Severity.ALARM  # it still holds
    assert acknowledged.acknowledged


def test_what_was_never_heard_is_over_once_it_is() -> None:
    feed = Feed()
    feed.now = 20 * 10**9
    feed.monitor.silent(feed.now, 20.0)
    feed.steady(3.0)
    assert feed.raised() == {}
    assert feed.status.latched_severity is Severity.ALARM  # until acknowledged


def test_silence_after_time_has_begun_anew_is_told_as_well() -> None:
    feed = Feed()
    feed.now = 1000 * 10**9
    feed.steady(1.0)
    feed.monitor.restart()
    assert feed.monitor.silent(5 * 10**9, 5.0) is None
    status = feed.monitor.silent(11 * 10**9, 11.0)
    assert status is not None
    assert status.condition is Condition.SENSOR_STALE
    assert status.stamp_ns == 11 * 10**9


def test_the_first_estimate_is_told_also_after_an_acknowledgement_before_it() -> None:
    feed = Feed().steady(1.0)
    feed.monitor.silent(feed.now + 2 * 10**9, 2.0)
    feed.monitor.restart()  # what is latched stays
    acknowledged = feed.monitor.acknowledge()
    assert acknowledged is not None
    assert "Nothing is known of the belt yet" in acknowledged.message
    feed.status = None
    feed.steady(0.02)
    assert feed.status is not None
    assert "estimated" in feed.status.message


def test_a_gap_in_the_stamps_is_a_stale_sensor_until_the_off_delay_is_over() -> None:
    feed = Feed().steady(1.0)
    feed.now += 5 * 10**9
    feed.steady(0.5)
    assert feed.raised() == {Condition.SENSOR_STALE: Severity.ALARM}
    feed.steady(1.0)
    assert feed.raised() == {}
    assert feed.status is not None
    assert feed.status.latched_severity is Severity.ALARM
    assert feed.status.conditions[0].count == 1


def test_data_that_come_back_after_a_silence_are_counted_once() -> None:
    feed = Feed().steady(1.0)
    feed.monitor.silent(feed.now + 2 * 10**9, 2.0)
    feed.now += 3 * 10**9
    feed.steady(3.0)
    assert feed.status is not None
    assert [each.count for each in feed.status.conditions] == [1]


def test_a_torque_that_used_to_come_and_does_not_is_missed_by_name() -> None:
    feed = Feed().steady(1.0).steady(0.9, driven_torque=math.nan)
    assert feed.raised() == {}
    feed.steady(0.3, driven_torque=math.nan)
    assert feed.raised() == {Condition.SENSOR_STALE: Severity.WARNING}
    assert feed.status is not None
    assert "driven torque no longer measured" in feed.status.message
    feed.steady(1.1)
    assert feed.raised() == {}


def test_a_torque_that_never_came_is_not_missed() -> None:
    feed = Feed().steady(3.0, driver_torque=math.nan)
    assert feed.raised() == {}


def test_a_load_that_comes_rarely_is_not_missed_between() -> None:
    channels, period = Channels(), 0.1
    for step in range(300):  # every 2.5 s, where 1 s is the greatest gap
        load = 400.0 if step % 25 == 0 else math.nan
        reading = Measurement(round(step * period * 1e9), 100.0, 100.0, span_tension=load)
        channels.take(reading, 1.0)
        assert channels.absent(1.0) == ()
    for step in range(300, 400):
        channels.take(Measurement(round(step * period * 1e9), 100.0, 100.0), 1.0)
    assert channels.absent(1.0) == (Sensor.SPAN_TENSION,)


def test_readings_that_cannot_be_are_implausible_and_named() -> None:
    feed = Feed().steady(1.0).steady(0.9, driver_torque=math.inf)
    assert feed.raised() == {Condition.SENSOR_IMPLAUSIBLE: Severity.ALARM}
    assert feed.status is not None
    assert "driver torque" in feed.status.message
    feed.steady(2.0)
    assert feed.raised() == {}


@pytest.mark.parametrize("samples", [0, 1, 9, 50])
@pytest.mark.parametrize("pulley", ["driver", "driven"])
def test_a_pulley_that_is_no_longer_read_is_told_of_however_briefly_it_was(
    pulley: str, samples: int
) -> None:
    """Also if it was only read just before the drive was followed."""
    names = ("speed", "torque")
    missing = {f"{pulley}_{name}": math.nan for name in names}
    other = "driver" if pulley == "driven" else "driven"
    alone = {f"{other}_{name}": math.nan for name in names}
    feed = Feed().steady(0.01, **alone).steady(0.01 * samples).steady(3.5, **missing)
    assert feed.raised()[Condition.SENSOR_STALE] is Severity.WARNING
    assert feed.status is not None
    assert f"{pulley} speed" in feed.status.message


def test_a_single_impossible_reading_is_no_alarm() -> None:
    feed = Feed().steady(1.0)
    for _ in range(10):
        feed.steady(0.01, driven_speed=1e9).steady(0.2)
    assert feed.raised() == {}


def test_rejections_with_wild_stamps_do_not_move_the_alarms() -> None:
    feed = Feed().steady(1.0)
    for stamp in (-(10**18), 10**18, feed.now + 10**12):
        wild = Measurement(stamp, math.inf, 100.0)
        assert feed.monitor.step(wild).alarm is None
    assert feed.steady(1.0).raised() == {}


@pytest.mark.parametrize(
    ("fault", "within"),
    [
        ({"kind": "wrong_sign", "sensor": "driven_encoder"}, 0.7),
        ({"kind": "wrong_sign", "sensor": "driven_torque"}, 1.0),
        ({"kind": "stuck", "sensor": "driven_encoder"}, 1.0),
        ({"kind": "dropout", "sensor": "driver_torque"}, 1.1),
    ],
)
def test_a_faulty_sensor_raises_its_own_alarm_and_none_of_the_belt(
    run: Runner, fault: dict[str, object], within: float
) -> None:
    faulty = run(**SCENARIO, faults=[{"at": 3.0, "duration": 2.0, **fault}])
    raised = raised_in(faulty)
    assert raised
    assert not OF_THE_BELT & set(raised), last_of(faulty).message
    assert 3.0 < min(raised.values()) <= 3.0 + within
    assert last_of(faulty).severity is Severity.NORMAL
    assert not last_of(faulty).acknowledged


@pytest.mark.parametrize("seed", [5, 7])
def test_the_belt_is_not_blamed_while_a_sensor_is_only_just_suspected(
    run: Runner, seed: int
) -> None:
    # The load moves at once, and the misfit takes some time to be certain; nor after it.
    moving = [[1.8, 0.0], [2.0, 22.0], [3.0, 22.0], [3.75, 38.0], [4.5, 22.0]]
    stuck = {"at": 3.0, "kind": "stuck", "sensor": "driven_encoder", "duration": 2.0}
    raised = raised_in(run(**{**SCENARIO, "load": moving, "seed": seed}, faults=[stuck]))
    assert Condition.SENSOR_IMPLAUSIBLE in raised
    assert not OF_THE_BELT & set(raised), raised


def test_an_overload_is_not_taken_for_a_faulty_sensor(run: Runner) -> None:
    slipping = run(
        **SCENARIO,
        events=[{"at": 3.0, "load": 90.0, "over": 0.01}, {"at": 4.0, "load": 30.0, "over": 0.01}],
    )
    raised = raised_in(slipping)
    assert {Condition.LOW_MARGIN, Condition.EXCESS_SLIP, Condition.GROSS_SLIP} <= set(raised)
    assert not {Condition.SENSOR_IMPLAUSIBLE, Condition.ESTIMATOR_LOST} & set(raised)
    assert raised[Condition.GROSS_SLIP] < 3.5


def test_a_message_names_the_tension_that_maintenance_set() -> None:
    feed = Feed().steady(0.5)
    feed.monitor.maintain(Maintenance(MaintenanceKind.RETENSIONED, 500.0, 20.0))
    status = feed.monitor.acknowledge()
    assert status is not None
    assert "installed 500 N" in status.message


def test_one_condition_can_be_acknowledged_alone() -> None:
    feed = Feed().steady(1.0).steady(1.2, driven_torque=math.nan)
    feed.steady(1.0, driven_torque=math.inf).steady(3.0)
    assert feed.status is not None
    assert len(feed.status.conditions) == 2
    status = feed.monitor.acknowledge(Condition.SENSOR_IMPLAUSIBLE)
    assert status is not None
    assert [each.condition for each in status.conditions] == [Condition.SENSOR_STALE]
    assert not status.acknowledged
    status = feed.monitor.acknowledge()
    assert status is not None
    assert status.acknowledged
    assert status.conditions == ()


ANY = st.floats(allow_nan=True, allow_infinity=True) | st.floats(-200.0, 200.0)


@settings(derandomize=True, deadline=None, max_examples=30)
@given(st.lists(st.tuples(st.integers(-(10**8), 10**10), *(ANY,) * 9), max_size=12))
def test_whatever_comes_no_message_says_nan(readings) -> None:
    feed = Feed().steady(0.2)
    now = feed.now
    statuses = []
    for step, *values in readings:
        now += step
        statuses.append(feed.monitor.step(Measurement(now, *values)).alarm)
        statuses.append(feed.monitor.silent(now, step * 1e-9))
    statuses.append(feed.monitor.acknowledge())
    for status in filter(None, statuses):
        texts = [status.message, *(each.message for each in status.conditions)]
        assert not any("nan" in text or "inf" in text for text in texts)
        numbers = [*status.margin, status.excess_slip, status.gross_slip_probability]
        assert np.isfinite(numbers).all()
