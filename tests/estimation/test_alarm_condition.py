"""The state machine of one alarm: delays, latch, acknowledgement and counts."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.estimation import Condition, Severity
from belt_ros.estimation.condition import ConditionAlarm, Delays, Evidence, judged

PERIOD_NS = 10_000_000
DELAYS = Delays(on=0.2, off=0.5)
STEPS_ON, STEPS_OFF = 20, 50
ALARM, WARNING = Severity.ALARM, Severity.WARNING
EVIDENCE = st.sampled_from(Evidence)
RUNS = st.lists(
    st.tuples(st.integers(1, 80), EVIDENCE, EVIDENCE, st.booleans(), st.booleans()),
    min_size=1,
    max_size=12,
)


def alarm() -> ConditionAlarm:
    return ConditionAlarm(Condition.LOW_MARGIN, (ALARM, WARNING))


def feed(machine: ConditionAlarm, stamp_ns: int, *evidence: Evidence, may_rise=True) -> None:
    machine.update(stamp_ns, evidence, DELAYS, longest=1.0, may_rise=may_rise)


def played(runs):
    """Severity, and whether it was acknowledged just before, step by step."""
    machine, now = alarm(), 0
    for steps, worse, lesser, may_rise, acknowledged in runs:
        if acknowledged:
            machine.acknowledge()
        for step in range(steps):
            feed(machine, now, worse, lesser, may_rise=may_rise)
            yield machine, acknowledged and step == 0, may_rise, (worse, lesser)
            now += PERIOD_NS


@settings(derandomize=True, deadline=None)
@given(RUNS)
def test_severity_never_changes_faster_than_its_delays(runs) -> None:
    held = {Evidence.MET: 0, Evidence.GONE: 0}
    before = Severity.NORMAL
    for machine, _, _, evidence in played(runs):
        for kind, steps in held.items():
            held[kind] = steps + 1 if kind in evidence else 0
        if machine.severity > before:
            assert held[Evidence.MET] > STEPS_ON
        if machine.severity < before:
            assert held[Evidence.GONE] > STEPS_OFF
        before = machine.severity


@settings(derandomize=True, deadline=None)
@given(RUNS)
def test_a_latch_stays_until_it_is_acknowledged(runs) -> None:
    worst = Severity.NORMAL
    for machine, acknowledged, _, _ in played(runs):
        worst = max(machine.severity, Severity.NORMAL if acknowledged else worst)
        if not machine.acknowledged:
            assert machine.latched >= worst
            assert machine.told
        assert machine.latched >= machine.severity


@settings(derandomize=True, deadline=None)
@given(RUNS)
def test_the_count_is_the_number_of_times_it_was_raised(runs) -> None:
    raised, before, now = 0, False, 0
    for machine, _, _, _ in played(runs):
        if machine.active and not before:
            raised += 1
            assert machine.first_ns == now
        if machine.active:
            assert machine.last_ns == now
        before = machine.active
        now += PERIOD_NS
        assert machine.count == raised


@settings(derandomize=True, deadline=None)
@given(RUNS)
def test_nothing_rises_that_may_not(runs) -> None:
    before = Severity.NORMAL
    for machine, _, may_rise, _ in played(runs):
        assert may_rise or machine.severity <= before
        before = machine.severity


@settings(derandomize=True, deadline=None)
@given(RUNS)
def test_it_is_cleared_a_step_after_the_off_delay_whatever_was_before(runs) -> None:
    machine = [machine for machine, *_ in played(runs)][-1]
    start = machine.last_ns + 10**9
    for step in range(STEPS_OFF + 2):
        feed(machine, start + step * PERIOD_NS, Evidence.GONE, Evidence.GONE)
    assert not machine.active


def test_the_worse_severity_shows_at_once_when_its_own_delay_is_over() -> None:
    machine = alarm()
    severities = []
    for step in range(60):
        worse = Evidence.MET if step >= 30 else Evidence.GONE
        feed(machine, step * PERIOD_NS, worse, Evidence.MET)
        severities.append(machine.severity)
    assert severities.index(WARNING) == STEPS_ON
    assert severities.index(ALARM) == 30 + STEPS_ON


def test_a_gap_counts_neither_for_the_on_delay_nor_for_the_off_delay() -> None:
    machine = alarm()
    feed(machine, 0, Evidence.MET, Evidence.MET)
    feed(machine, 10 * 10**9, Evidence.MET, Evidence.MET)
    assert not machine.active
    for step in range(STEPS_ON + 1):
        feed(machine, 10 * 10**9 + step * PERIOD_NS, Evidence.MET, Evidence.MET)
    assert machine.active
    feed(machine, 11 * 10**9, Evidence.GONE, Evidence.GONE)
    feed(machine, 20 * 10**9, Evidence.GONE, Evidence.GONE)
    assert machine.active


def test_a_second_rise_wants_to_be_acknowledged_again() -> None:
    machine = alarm()
    now = 0
    for evidence in (Evidence.MET, Evidence.GONE, Evidence.MET):
        for _ in range(60):
            feed(machine, now, evidence, evidence)
            now += PERIOD_NS
        if evidence is Evidence.MET:
            assert not machine.acknowledged
            machine.acknowledge()
            assert machine.acknowledged
    assert machine.count == 2


def test_an_acknowledged_alarm_that_is_over_is_forgotten() -> None:
    machine = alarm()
    for step in range(30):
        feed(machine, step * PERIOD_NS, Evidence.MET, Evidence.MET)
    machine.acknowledge()
    assert machine.told
    for step in range(30, 90):
        feed(machine, step * PERIOD_NS, Evidence.GONE, Evidence.GONE)
    assert not machine.told


def test_without_delays_it_follows_at_once() -> None:
    machine = ConditionAlarm(Condition.SENSOR_STALE, (ALARM,))
    for stamp, evidence in enumerate((Evidence.MET, Evidence.GONE, Evidence.MET)):
        machine.update(stamp, (evidence,), Delays(0.0, 0.0), longest=1.0)
        assert machine.active is (evidence is Evidence.MET)


@pytest.mark.parametrize(
    ("value", "evidence"),
    [
        (0.8, Evidence.MET),
        (0.79, Evidence.UNDECIDED),
        (0.4, Evidence.UNDECIDED),
        (0.39, Evidence.GONE),
        (float("nan"), Evidence.UNDECIDED),
    ],
)
def test_between_the_thresholds_nothing_is_decided(value: float, evidence: Evidence) -> None:
    assert judged(value, 0.8, 0.4) is evidence


def test_a_latch_outlives_a_time_that_begins_anew() -> None:
    machine = ConditionAlarm(Condition.LOW_MARGIN, (Severity.ALARM,))
    machine.update(0, (Evidence.MET,), Delays(0.0, 0.0), longest=1.0)
    assert machine.severity is Severity.ALARM

    machine.begin_anew()
    assert (machine.severity, machine.latched) == (Severity.NORMAL, Severity.ALARM)
    assert not machine.acknowledged
    assert machine.count == 1
    machine.acknowledge()
    assert not machine.told
