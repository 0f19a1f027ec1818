"""Whatever comes, no measurement goes uncounted, and nothing but numbers leaves."""

import dataclasses
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from runs import ROOT, assert_sound

from belt_ros.estimation import BeltMonitor, Measurement, Rejection
from belt_ros.estimation.assembler import Assembler, Dropped
from belt_ros.estimation.measurement import Sensor
from belt_ros.settings import load_settings

SETTINGS = load_settings(ROOT / "config" / "demo_drive.yaml")
NAMES = [sensor.name.lower() for sensor in Sensor]
STEADY = Measurement(0, 120.0, 119.2, 45.0, -45.0)
MILLISECOND = 1_000_000
SECOND = 1_000_000_000


def counted(monitor: BeltMonitor) -> int:
    return monitor.health.accepted + sum(monitor.health.rejections)


def retuned(monitor: BeltMonitor, **limits: float) -> None:
    changed = dataclasses.replace(monitor.limits, **limits)
    monitor.retune(SETTINGS.noise, SETTINGS.drift, changed, SETTINGS.alarm)


@pytest.mark.parametrize("period", [0.0, 0.002, 0.1])
def test_what_waits_in_a_pool_is_not_lost_when_its_period_changes(period) -> None:
    monitor = SETTINGS.monitor()
    for k in range(3):  # all but the first wait
        monitor.step(dataclasses.replace(STEADY, stamp_ns=k * MILLISECOND))
    assert counted(monitor) == 1

    retuned(monitor, pool_period=period)
    monitor.step(dataclasses.replace(STEADY, stamp_ns=200 * MILLISECOND))

    assert counted(monitor) == 4


def test_counts_outlast_a_filter_that_has_broken_down(monkeypatch) -> None:
    monitor = SETTINGS.monitor()
    for k in range(5):
        monitor.step(dataclasses.replace(STEADY, stamp_ns=k * 10 * MILLISECOND))
    monitor.step(dataclasses.replace(STEADY, stamp_ns=50 * MILLISECOND, driven_torque=math.inf))

    def fail(*_: object) -> float:
        raise FloatingPointError("no member of the filter is finite any more")

    with monkeypatch.context() as patch:
        patch.setattr(monitor._filter, "predict", fail)
        monitor.step(dataclasses.replace(STEADY, stamp_ns=60 * MILLISECOND))

    assert monitor.health.resets == 1
    assert (monitor.health.accepted, monitor.health.rejections[Rejection.NOT_FINITE]) == (6, 1)


SPECIAL = [math.nan, math.inf, -0.0, 5e-324, -1e-310, 1e308, -1e308, 1e4, 1e6, 1e7, 1e155]
VALUES = st.one_of(st.floats(), st.sampled_from(SPECIAL), st.floats(-200.0, 200.0))
STEPS = st.one_of(
    st.just(10 * MILLISECOND),
    st.sampled_from([0, 1, -1, MILLISECOND, SECOND, -SECOND, 3600 * SECOND, -(10**17), 10**17]),
    st.integers(-(10**9), 10**9),
)


@given(
    st.lists(
        st.tuples(STEPS, st.dictionaries(st.sampled_from(NAMES), VALUES, max_size=3)),
        min_size=15,
        max_size=25,
    ),
    st.sampled_from([0.0, 0.004, 1.0]),
)
@settings(max_examples=60, deadline=None, derandomize=True)
def test_every_measurement_is_counted_and_every_estimate_sound(stream, period) -> None:
    monitor = SETTINGS.monitor()
    retuned(monitor, pool_period=period)
    now, given_so_far = 10**18, 0
    for step, values in stream:
        now += step
        output = monitor.step(dataclasses.replace(STEADY, stamp_ns=now, **values))
        given_so_far += 1
        if output.estimate is not None:
            assert_sound(output.estimate)
        assert counted(monitor) <= given_so_far
    monitor.step(dataclasses.replace(STEADY, stamp_ns=now + 2 * SECOND))  # nothing waits after it

    assert counted(monitor) == given_so_far + 1


@given(
    st.lists(st.tuples(st.integers(0, 2), STEPS), min_size=20, max_size=80),
    st.sampled_from([0.0, 0.02, 1.0]),
    st.sampled_from([0.0, 0.001, 0.1]),
    st.sampled_from([0.0, 0.05]),
    st.sampled_from([1, 8, 1000]),
)
@settings(max_examples=100, deadline=None, derandomize=True)
def test_every_sample_of_any_source_leaves_once(stream, window, slop, disorder, most) -> None:
    assembler = Assembler(window, slop, 3, most, disorder)
    now, left = 10**18, 0
    for source, step in stream:
        now += step
        sample = Measurement(now, **{NAMES[source]: 1.0})
        left += samples_in(assembler.add(source, sample))
        assert assembler.pending <= most + 1
    left += samples_in(assembler.flush())

    assert (left, assembler.pending) == (len(stream), 0)


def samples_in(ready) -> int:
    """Every sample has measured one quantity: so many, and what has been dropped."""
    return sum(
        1 if isinstance(item, Dropped) else sum(not math.isnan(v) for v in item.values())
        for item in ready
    )
