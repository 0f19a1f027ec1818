"""Bad input: turned away, counted, and survived."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from runs import Runner, assert_sound

from belt_ros.estimation import AlarmSettings, Drift, Measurement, Rejection, SensorNoise
from belt_ros.estimation.assumptions import SensorLimits

PERIOD_NS = 10_000_000
STEADY = Measurement(0, 120.0, 119.2, 45.0, -45.0)


def feed(monitor, count, start_ns=0, **values):
    output = None
    for k in range(count):
        output = monitor.step(
            dataclasses.replace(STEADY, stamp_ns=start_ns + k * PERIOD_NS, **values)
        )
    return output


@pytest.fixture
def monitor(settings):
    monitor = settings.monitor()
    feed(monitor, 50)
    return monitor


def test_what_cannot_be_used_is_counted_and_changes_nothing(monitor) -> None:
    before = monitor.estimate
    now = 50 * PERIOD_NS
    for values, reason in (
        (
            dict.fromkeys(
                ("driver_speed", "driven_speed", "driver_torque", "driven_torque"), math.nan
            ),
            Rejection.NOT_FINITE,
        ),
        ({"driven_torque": math.inf}, Rejection.NOT_FINITE),
        ({"driven_speed": 1e9}, Rejection.OUT_OF_RANGE),
        ({"stamp_ns": now - 2 * PERIOD_NS}, Rejection.OUT_OF_ORDER),
        ({"stamp_ns": now - PERIOD_NS}, Rejection.OUT_OF_ORDER),
    ):
        output = monitor.step(dataclasses.replace(STEADY, **({"stamp_ns": now} | values)))
        assert output.rejection is reason
        assert output.estimate is before
        assert monitor.health.last_rejection is reason
    assert monitor.health.rejections[Rejection.NOT_FINITE] == 2
    assert monitor.health.rejections[Rejection.OUT_OF_ORDER] == 2
    assert monitor.health.accepted == 50


def test_a_single_spike_is_gated(monitor) -> None:
    now = 50 * PERIOD_NS
    spike = monitor.step(dataclasses.replace(STEADY, stamp_ns=now, driven_speed=500.0))
    assert spike.rejection is Rejection.GATED
    after = feed(monitor, 5, now + PERIOD_NS)
    assert after.rejection is Rejection.NONE
    assert after.estimate.driven_speed.value == pytest.approx(119.2, abs=0.05)


def test_a_change_that_stays_is_believed_after_a_few_samples(monitor) -> None:
    rejected = 0
    for k in range(10):
        output = monitor.step(
            dataclasses.replace(STEADY, stamp_ns=(50 + k) * PERIOD_NS, driven_speed=60.0)
        )
        rejected += output.rejection is Rejection.GATED
    assert rejected <= 3
    assert output.estimate.driven_speed.value == pytest.approx(60.0, abs=1.0)
    assert_sound(output.estimate)


DRIVER, DRIVEN = ("driver_speed", "driver_torque"), ("driven_speed", "driven_torque")
WHOLE, LOAD_ONLY = (*DRIVER, *DRIVEN), ("driver_hub_load",)


@pytest.mark.parametrize("turns", [(DRIVER, DRIVEN), (WHOLE, LOAD_ONLY), (WHOLE, DRIVEN)])
def test_a_change_that_stays_is_believed_though_others_speak_between(settings, turns) -> None:
    """What fits says nothing of what does not: gates must not lock a real change out."""
    monitor = settings.monitor()
    noise = np.random.default_rng(7)
    driven, gated = 120.0, 0
    for k in range(500):
        if k == 300:
            driven = 60.0
        values = {
            "driver_speed": 120.0 + 0.01 * noise.normal(),
            "driven_speed": driven + 0.01 * noise.normal(),
            "driver_torque": 1.0 + 0.3 * noise.normal(),
            "driven_torque": -1.0 + 0.3 * noise.normal(),
            "driver_hub_load": 800.0 + noise.normal(),
        }
        said = {name: values[name] for name in turns[k % 2]}
        output = monitor.step(Measurement(k * PERIOD_NS, **said))
        gated += output.rejection is Rejection.GATED
    assert 0 < gated <= 4
    assert output.estimate.driven_speed.value == pytest.approx(60.0, abs=1.0)


def test_one_stamp_far_off_is_not_believed(monitor) -> None:
    for odd in (10**18, -(10**18)):
        output = monitor.step(dataclasses.replace(STEADY, stamp_ns=odd))
        assert output.rejection is Rejection.OUT_OF_ORDER
    assert feed(monitor, 1, 50 * PERIOD_NS).rejection is Rejection.NONE
    assert monitor.health.resets == 0


def test_a_clock_that_jumps_back_resets_once(monitor) -> None:
    for k in range(100):
        output = monitor.step(dataclasses.replace(STEADY, stamp_ns=-(10**10) + k * PERIOD_NS))
        assert_sound(output.estimate)
    assert monitor.health.resets == 1
    assert output.rejection is Rejection.NONE


def test_a_clock_that_jumps_back_does_not_undo_the_counting(monitor) -> None:
    for k in range(100):
        monitor.step(dataclasses.replace(STEADY, stamp_ns=-(10**10) + k * PERIOD_NS))
    health = monitor.health
    assert health.rejections[Rejection.OUT_OF_ORDER] == 2
    assert health.accepted == 50 + 98


def test_a_gap_forward_resumes_with_what_is_known_of_the_belt(run: Runner, settings) -> None:
    monitor = settings.monitor()
    taught = run(
        monitor=monitor,
        duration=6.0,
        sample_rate=100.0,
        seed=2,
        speed=[[0.0, 0.0], [1.0, 120.0]],
        load=[[1.5, 0.0], [1.7, 48.0]],
        condition__tension=440.0,
        condition__friction_stiffness=6e6,
    )
    before = taught.outputs[-1].estimate
    later = taught.measurements[-1].stamp_ns + 20 * 10**9
    last = taught.measurements[-1]
    for k in range(30):
        output = monitor.step(dataclasses.replace(last, stamp_ns=later + k * PERIOD_NS))
    assert output.rejection is Rejection.NONE
    assert monitor.health.resets == 0
    assert output.estimate.friction_stiffness_log_stddev < 2.0 * max(
        before.friction_stiffness_log_stddev, 0.05
    )


def test_samples_slower_than_the_gap_are_not_refused_for_ever(monitor) -> None:
    """Nor two of three: once their interval is known, each is used."""
    rng = np.random.default_rng(2)
    stamps = [round((3.0 * k + rng.uniform(-0.3, 0.3)) * 1e9) for k in range(1, 40)]
    slow = [monitor.step(dataclasses.replace(STEADY, stamp_ns=stamp)) for stamp in stamps]
    assert sum(output.rejection is not Rejection.NONE for output in slow) <= 2
    odd = monitor.step(dataclasses.replace(STEADY, stamp_ns=stamps[-1] + 10**12))
    assert odd.rejection is Rejection.OUT_OF_ORDER
    fast = feed(monitor, 10, stamps[-1] + PERIOD_NS)
    assert fast.rejection is Rejection.NONE
    odd = monitor.step(dataclasses.replace(STEADY, stamp_ns=stamps[-1] + 3 * 10**9))
    assert odd.rejection is Rejection.OUT_OF_ORDER
    assert monitor.health.resets == 0


@pytest.mark.parametrize("extra_ns", [0, -300_000_000, 10**12])
def test_one_message_too_much_costs_no_slow_samples(settings, extra_ns: int) -> None:
    """One that comes twice, or late, or with a wild stamp."""
    monitor, refused = settings.monitor(), 0
    for k in range(20):
        now = dataclasses.replace(STEADY, stamp_ns=k * 2 * 10**9)
        refused += monitor.step(now).rejection is not Rejection.NONE
        if k == 8 or extra_ns <= 0:
            monitor.step(dataclasses.replace(now, stamp_ns=now.stamp_ns + extra_ns))
    assert refused == 2
    assert monitor.health.resets == 0


def test_fast_input_pauses_as_slow_input_does(settings) -> None:
    """What is in a pool when a pause begins is of before it."""
    for count in range(295, 305):
        monitor = settings.monitor()
        for k in range(count):
            monitor.step(dataclasses.replace(STEADY, stamp_ns=k * 1_000_000))
        monitor.pause()
        alarms = []
        for k in range(50):
            output = monitor.step(dataclasses.replace(STEADY, stamp_ns=60 * 10**9 + k * 1_000_000))
            assert output.rejection is Rejection.NONE
            alarms += [output.alarm] if output.alarm else []
        assert alarms == []


def test_a_long_gap_ages_what_is_known(run: Runner, settings) -> None:
    monitor = settings.monitor()
    taught = run(
        monitor=monitor,
        duration=5.0,
        sample_rate=100.0,
        seed=2,
        speed=[[0.0, 0.0], [1.0, 120.0]],
        load=[[1.5, 0.0], [1.7, 62.0]],
        condition__tension=440.0,
        condition__friction_stiffness=6e6,
    )
    last = taught.measurements[-1]
    known = taught.outputs[-1].estimate.mean_tension.stddev
    for k in range(5):
        output = monitor.step(
            dataclasses.replace(last, stamp_ns=last.stamp_ns + 10**14 + k * PERIOD_NS)
        )
    assert known < 0.5 * settings.prior.tension_stddev
    assert output.estimate.mean_tension.stddev > 1.5 * known


def test_reset_returns_to_the_priors(monitor) -> None:
    monitor.reset()
    assert monitor.estimate is None
    assert monitor.health.accepted == 0
    output = feed(monitor, 1, 10**12)
    assert output.estimate.health.resets == 1
    assert output.estimate.accumulated_slip.value == 0.0


def test_retuning_keeps_what_is_known(monitor) -> None:
    before = monitor.estimate
    monitor.retune(
        SensorNoise(speed_absolute=0.5), Drift(), SensorLimits(greatest_speed=50.0), AlarmSettings()
    )
    assert monitor.estimate is before
    assert feed(monitor, 1, 50 * PERIOD_NS).rejection is Rejection.OUT_OF_RANGE


def test_the_same_measurements_give_the_same_bits(settings) -> None:
    first, second = settings.monitor(), settings.monitor()
    rng = np.random.default_rng(0)
    for k in range(100):
        noise = 1e-2 * rng.standard_normal(4)
        m = Measurement(
            k * PERIOD_NS, 120 + noise[0], 119.2 + noise[1], 45 + noise[2], -45 + noise[3]
        )
        assert first.step(m) == second.step(m)


HOSTILE = st.one_of(
    st.floats(),
    st.floats(-300.0, 300.0),
    st.sampled_from([0.0, -0.0, 1e-308, 1e4, -1e4, 1e6, math.nan, math.inf]),
)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    st.lists(
        st.tuples(
            st.one_of(st.integers(1, 10**8), st.integers(-(2**63), 2**63 - 1)),
            HOSTILE,
            HOSTILE,
            HOSTILE,
            HOSTILE,
        ),
        max_size=25,
    )
)
def test_no_sequence_of_messages_raises_or_gives_nan(settings, messages) -> None:
    monitor = settings.monitor()
    now = 0
    for step, *values in messages:
        now = now + step if 0 < step <= 10**8 else step
        output = monitor.step(Measurement(now, *values))
        if output.estimate is not None:
            assert_sound(output.estimate)
    health = monitor.health
    assert health.accepted + sum(health.rejections) <= len(messages)
