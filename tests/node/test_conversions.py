"""Messages in and out; whatever a topic carries, nothing raises."""

import math
from functools import partial

import numpy as np
import pytest
from belt_msgs.msg import BeltState, PulleyState, SlipAlarm
from builtin_interfaces.msg import Time
from hypothesis import given, settings
from hypothesis import strategies as st
from node_harness import NAMES, PAPER_DRIVE, joint_state, not_finite
from sensor_msgs.msg import JointState

from belt_ros.drive_inputs import measurement_from_joint_state, reading_from_pulley_state
from belt_ros.estimation import (
    Condition,
    Knowledge,
    Measurement,
    Phase,
    Rejection,
    Severity,
)
from belt_ros.node.conversions import (
    nanoseconds,
    state_message,
    time_message,
)
from belt_ros.node.pipeline import Pipeline
from belt_ros.settings import load_settings

SETTINGS = load_settings(PAPER_DRIVE)
NAN = math.nan
INT32 = 2**31 - 1
UINT32 = 2**32 - 1


def convert(message: JointState) -> Measurement | Rejection:
    return measurement_from_joint_state(SETTINGS.driver, SETTINGS.driven, message)


@given(st.integers(0, (INT32 + 1) * 10**9 - 1))
def test_a_stamp_survives_the_way_there_and_back(stamp_ns: int) -> None:
    assert nanoseconds(time_message(stamp_ns)) == stamp_ns


def test_a_joint_state_becomes_a_measurement() -> None:
    measurement = convert(joint_state(1_500_000_001, velocity=(1.0, 2.0), effort=(3.0, 4.0)))

    assert measurement == Measurement(1_500_000_001, 1.0, 2.0, 3.0, 4.0)


def test_positions_are_read_where_there_are_any() -> None:
    message = joint_state(1, velocity=(1.0, 2.0), effort=(3.0, 4.0))
    message.position = [5.0, 6.0]

    assert convert(message) == Measurement(1, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)


def test_positions_that_do_not_match_the_names_are_malformed() -> None:
    message = joint_state(1)
    message.position = [5.0]

    assert convert(message) is Rejection.MALFORMED


def test_joints_are_found_by_name_in_any_order_among_others() -> None:
    message = joint_state(
        1,
        name=("elbow", NAMES[1], "wrist", NAMES[0]),
        velocity=(9.0, 2.0, 9.0, 1.0),
        effort=(9.0, 4.0, 9.0, 3.0),
    )

    assert convert(message) == Measurement(1, 1.0, 2.0, 3.0, 4.0)


def test_without_effort_the_torques_are_unknown() -> None:
    measurement = convert(joint_state(1, effort=()))

    assert isinstance(measurement, Measurement)
    assert math.isnan(measurement.driver_torque)
    assert math.isnan(measurement.driven_torque)


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (JointState(), Rejection.MALFORMED),
        (joint_state(1, velocity=()), Rejection.INCOMPLETE),
        (joint_state(1, velocity=(1.0,)), Rejection.MALFORMED),
        (joint_state(1, effort=(1.0, 2.0, 3.0)), Rejection.MALFORMED),
        (joint_state(1, name=("elbow", NAMES[1])), Rejection.INCOMPLETE),
        (joint_state(1, name=("elbow", "wrist")), None),
        (
            joint_state(1, name=["joint"] * 1001, velocity=[0.0] * 1001, effort=()),
            Rejection.MALFORMED,
        ),
    ],
    ids=[
        "empty",
        "no velocity",
        "short velocity",
        "long effort",
        "one joint",
        "other joints",
        "oversized",
    ],
)
def test_an_unusable_message_gives_the_reason(message: JointState, reason: Rejection) -> None:
    assert convert(message) is reason


@pytest.mark.parametrize("stamp", [Time(sec=-1), Time(sec=1, nanosec=10**9)])
def test_an_impossible_stamp_is_malformed(stamp: Time) -> None:
    message = joint_state(1)
    message.header.stamp = stamp

    assert convert(message) is Rejection.MALFORMED


names = st.lists(st.sampled_from([*NAMES, "", "elbow", "\N{GREEK SMALL LETTER OMEGA}"]), max_size=5)
values = st.lists(
    st.one_of(st.floats(), st.sampled_from([0.0, 120.0, 119.4, -30.0, 1e308, 5e-324])), max_size=5
)


@st.composite
def joint_states(draw: st.DrawFn) -> JointState:
    message = JointState(
        name=draw(st.one_of(names, st.just(list(NAMES)))),
        velocity=draw(st.one_of(values, st.lists(st.floats(), min_size=2, max_size=2))),
        effort=draw(st.one_of(values, st.lists(st.floats(), min_size=2, max_size=2))),
        position=draw(values),
    )
    message.header.stamp = draw(
        st.one_of(
            st.builds(Time, sec=st.integers(-INT32 - 1, INT32), nanosec=st.integers(0, UINT32)),
            st.builds(Time, sec=st.just(0), nanosec=st.integers(0, 10**9)),
        )
    )
    return message


@settings(deadline=None, max_examples=200)
@given(st.lists(joint_states(), max_size=6))
def test_no_joint_states_raise_or_make_a_state_of_nan(messages: list[JointState]) -> None:
    pipeline = Pipeline("node", ("/joint_states",), SETTINGS)
    accepted = others = 0
    for message in messages:
        ready = measurement_from_joint_state(SETTINGS.driver, SETTINGS.driven, message)
        if ready is None:
            others += 1
            continue
        outcome = pipeline.take(ready, nanoseconds(message.header.stamp), 0)
        assert (outcome.estimate is None) == (outcome.reason is not Rejection.NONE)
        accepted += outcome.estimate is not None
        if outcome.estimate is not None:
            state = state_message("name", outcome.estimate)
            assert state.header.stamp == message.header.stamp
            assert not_finite(state) == []
    rejected = sum(pipeline.health.rejections)
    assert accepted >= pipeline.health.accepted
    assert pipeline.health.resets > 0 or accepted + rejected + others == len(messages)


def pulley_state(**fields: float) -> PulleyState:
    unmeasured = dict.fromkeys(("position", "speed", "torque", "hub_load", "span_tension"), NAN)
    message = PulleyState(**unmeasured | fields)
    message.header.stamp = Time(sec=1, nanosec=5)
    return message


def test_a_pulley_state_is_a_reading_of_its_joint() -> None:
    message = pulley_state(position=1.0, speed=2.0, torque=3.0, hub_load=4.0, span_tension=5.0)

    assert repr(reading_from_pulley_state("driver", message)) == repr(
        Measurement(
            1_000_000_005,
            driver_speed=2.0,
            driver_torque=3.0,
            driver_position=1.0,
            driver_hub_load=4.0,
        )
    )
    assert repr(reading_from_pulley_state("driven", message)) == repr(
        Measurement(
            1_000_000_005,
            driven_speed=2.0,
            driven_torque=3.0,
            driven_position=1.0,
            driven_hub_load=4.0,
            span_tension=5.0,
        )
    )


@pytest.mark.parametrize("pulley", ["driver", "driven"])
def test_a_pulley_state_that_says_nothing_or_infinity_is_not_finite(pulley) -> None:
    read = partial(reading_from_pulley_state, pulley)
    assert read(pulley_state()) is Rejection.NOT_FINITE
    assert read(pulley_state(speed=1.0, torque=math.inf)) is Rejection.NOT_FINITE
    assert isinstance(read(pulley_state(torque=1e308)), Measurement)  # limits.* judge that


@pytest.mark.parametrize("stamp", [Time(sec=-1), Time(sec=1, nanosec=10**9)])
def test_an_impossible_stamp_of_a_pulley_is_malformed(stamp: Time) -> None:
    message = pulley_state(speed=1.0)
    message.header.stamp = stamp

    assert reading_from_pulley_state("driver", message) is Rejection.MALFORMED
    assert reading_from_pulley_state("driven", message) is Rejection.MALFORMED


def test_a_state_carries_every_field_of_the_estimate() -> None:
    monitor = SETTINGS.monitor()
    estimate = monitor.step(Measurement(5, 120.0, 119.4, 30.0, -30.0)).estimate
    assert estimate is not None

    message = state_message("name", estimate)

    assert message.drive_name == "name"
    assert nanoseconds(message.header.stamp) == 5
    assert message.header.frame_id == ""
    assert message.margin == estimate.margin.value
    assert message.margin_stddev == estimate.margin.stddev
    assert message.accepted_count == 1
    assert message.rejection_counts.dtype == np.uint64


@pytest.mark.parametrize(
    ("enumeration", "message", "prefix"),
    [
        (Phase, BeltState, "PHASE_"),
        (Knowledge, BeltState, "KNOWLEDGE_"),
        (Rejection, BeltState, "REJECTION_"),
        (Condition, SlipAlarm, "CONDITION_"),
        (Severity, SlipAlarm, "SEVERITY_"),
    ],
)
def test_numbers_in_code_are_those_in_messages(enumeration, message, prefix) -> None:
    for member in enumeration:
        assert getattr(message, prefix + member.name) == member


def test_there_is_a_count_for_every_reason() -> None:
    assert len(Rejection) == BeltState.REJECTION_REASONS
