"""States reach subscribers as rclpy would have written them."""

from dataclasses import replace
from functools import cache

from belt_msgs.msg import BeltState
from hypothesis import given, settings
from hypothesis import strategies as st
from node_harness import PAPER_DRIVE
from rclpy.serialization import deserialize_message, serialize_message

from belt_ros.estimation import BeltEstimate, Measurement
from belt_ros.node.conversions import state_message
from belt_ros.settings import load_settings
from belt_ros.state_bytes import StateBytes


@cache
def first_estimate() -> BeltEstimate:
    monitor = load_settings(PAPER_DRIVE).monitor()
    estimate = monitor.step(Measurement(5, 120.0, 119.4, 30.0, -30.0)).estimate
    assert estimate is not None
    return estimate


@settings(derandomize=True, deadline=None)
@given(
    name=st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=20),
    stamp_ns=st.integers(0, 2**31 * 10**9 - 1),
)
def test_every_field_is_where_a_subscriber_looks_for_it(name: str, stamp_ns: int) -> None:
    stamped = replace(first_estimate(), stamp_ns=stamp_ns)
    expected = serialize_message(state_message(name, stamped))

    written = StateBytes(name, BeltState.get_fields_and_field_types()).write(stamped)

    assert len(written) == len(expected)  # they may differ in what pads them
    assert str(deserialize_message(written, BeltState)) == str(
        deserialize_message(expected, BeltState)
    )
