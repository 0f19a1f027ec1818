"""Hostile messages on the way through a drive of a node: the benchmark's, and hypothesis' own."""

import math
import os
from typing import Any

import numpy as np
import pytest
from belt_msgs.msg import BeltState, PulleyState
from hypothesis import given, settings
from hypothesis import strategies as st
from node_harness import NAMES, PAPER_DRIVE
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from belt_ros.estimation import Measurement, Rejection
from belt_ros.node_tables import InputKind
from belt_ros.settings import load_settings
from benchmarks.hostile.block import CASES, FORM, run_messages
from benchmarks.hostile.checks import BrokenPromiseError, Ledger, check_message
from benchmarks.hostile.page import sections
from benchmarks.hostile.session import Session

SETTINGS = load_settings(PAPER_DRIVE)
NUMBERS = st.one_of(
    st.floats(),
    st.floats(-150.0, 150.0),
    st.sampled_from([math.nan, math.inf, -0.0, 5e-324, 1e308, 1e4, 1e6, 120.0]),
)
STAMPS = st.one_of(
    st.tuples(st.integers(1000, 1002), st.integers(0, 10**9 - 1)),
    st.tuples(st.integers(-(2**31), 2**31 - 1), st.integers(0, 2**32 - 1)),
)
EXAMPLES = int(os.environ.get("HOSTILE_EXAMPLES", "20"))  # 170: ten thousand messages
STEADY = 15  # rows before what is hostile
ROWS = st.lists(NUMBERS, min_size=2, max_size=2)
ARRAYS = st.one_of(ROWS, ROWS, ROWS, st.lists(NUMBERS, max_size=4))
NAME_LISTS = st.one_of(
    st.just([*NAMES]),
    st.just([*NAMES]),
    st.lists(st.sampled_from([*NAMES, "", "elbow"]), max_size=4),
)


def stamped(message: Any, stamp: tuple[int, int]) -> Any:
    message.header.stamp.sec, message.header.stamp.nanosec = stamp
    return message


JOINT_STATES = st.builds(
    lambda stamp, **fields: ("/joint_states", stamped(JointState(**fields), stamp)),
    STAMPS,
    name=NAME_LISTS,
    velocity=ARRAYS,
    effort=ARRAYS,
    position=st.one_of(st.just([]), ARRAYS),
)
PULLEY_STATES = st.builds(
    lambda topic, stamp, **fields: (topic, stamped(PulleyState(**fields), stamp)),
    st.sampled_from(["/driver/state", "/driven/state"]),
    STAMPS,
    **dict.fromkeys(("speed", "torque", "position", "hub_load", "span_tension"), NUMBERS),
)
FLOATS = st.builds(
    lambda topic, value: (topic, Float64(data=value)),
    st.sampled_from([f"/{p}/{what}" for p in ("driver", "driven") for what in ("speed", "torque")]),
    NUMBERS,
)


def session(kind: InputKind) -> Session:
    return Session(SETTINGS, "paper_drive", kind, np.random.default_rng(0))


def fed(kind: InputKind, sent: list[tuple[str, Any]]) -> Session:
    """A drive that runs, and then gets what is `sent`; its session checks all that goes out."""
    drive = session(kind)
    for count, (topic, message) in enumerate([*steady(kind, STEADY), *sent]):
        drive.send(topic, message, 1_000_000_000_000 + 10_000_000 * count)
    drive.finish()
    return drive


def steady(kind: InputKind, rows: int) -> list[tuple[str, Any]]:
    at = [(999, 10_000_000 * row) for row in range(rows)]
    if kind is InputKind.JOINT_STATE:
        fields = {"name": [*NAMES], "velocity": [120.0, 119.4], "effort": [30.0, -30.0]}
        return [("/joint_states", stamped(JointState(**fields), stamp)) for stamp in at]
    if kind is InputKind.PULLEY_STATE:
        rest = dict.fromkeys(("position", "hub_load", "span_tension"), math.nan)
        pulleys = {"driver": (120.0, 30.0), "driven": (119.4, -30.0)}
        return [
            (f"/{name}/state", stamped(PulleyState(speed=speed, torque=torque, **rest), stamp))
            for stamp in at
            for name, (speed, torque) in pulleys.items()
        ]
    values = {"driver/speed": 120.0, "driven/speed": 119.4, "driver/torque": 30.0}
    return [(f"/{topic}", Float64(data=value)) for _ in at for topic, value in values.items()]


@given(st.lists(JOINT_STATES, min_size=10, max_size=30))
@settings(max_examples=EXAMPLES, deadline=None, derandomize=True)
def test_any_joint_state_is_survived_and_counted(sent) -> None:
    drive = fed(InputKind.JOINT_STATE, sent)
    settling = int(drive.settled)
    others = sum(0 < len(m.name) <= 1000 and not set(NAMES) & set(m.name) for _, m in sent)
    assert drive.messages == STEADY + len(sent)
    assert drive.accepted + sum(drive.rejected) + others == drive.messages + settling


@given(st.lists(PULLEY_STATES, min_size=10, max_size=30))
@settings(max_examples=EXAMPLES, deadline=None, derandomize=True)
def test_any_pulley_state_is_survived(sent) -> None:
    assert fed(InputKind.PULLEY_STATE, sent).states > 0


@given(st.lists(FLOATS, min_size=10, max_size=40))
@settings(max_examples=EXAMPLES, deadline=None, derandomize=True)
def test_any_number_is_survived(sent) -> None:
    assert fed(InputKind.FLOAT64, sent).states > 0


@pytest.mark.parametrize("block", range(len(CASES)))
def test_a_block_of_the_benchmark_ends_without_a_fault(block) -> None:
    result = run_messages(2, block, 200)

    assert (result.fault, result.case) == ("", CASES[block])
    assert result.messages >= 200
    assert result == FORM.row(FORM.fields(result))._replace(
        median=result.median, slowest=result.slowest
    )


@pytest.mark.parametrize(
    ("block", "messages"),
    [
        *[(156, 50), (233, 50), (342, 50), (481, 50), (1061, 50), (1440, 100), (1790, 50)],
        *[(429, 400), (878, 50), (1337, 50), (1530, 50), (1910, 50)],
    ],
)
def test_blocks_of_absurd_drives_end_without_a_fault(block, messages) -> None:
    assert run_messages(1, block, messages).fault == ""


def test_a_pool_that_begins_anew_in_the_middle_of_a_measurement_loses_none() -> None:
    assert run_messages(77, 13, 250).fault == ""


def test_the_page_names_faults() -> None:
    good = run_messages(2, 0, 50)
    page = "\n".join(sections([good, good._replace(seed=1, fault="ValueError: of something")]))

    assert "1 blocks ended early" in page
    assert "ValueError: of something" in page
    assert "counted once" in "\n".join(sections([good]))


def test_a_number_that_must_not_go_out_is_noticed() -> None:
    for field, value in (("slip", math.nan), ("slip_stddev", -1.0), ("margin", math.inf)):
        with pytest.raises(BrokenPromiseError, match=f"BeltState.{field} is"):
            check_message(BeltState(**{field: value}))
    check_message(BeltState())


def test_a_measurement_that_is_lost_is_noticed() -> None:
    ledger = Ledger()
    ledger.give(Measurement(1, 1.0, 1.0))
    ledger.give(Rejection.MALFORMED)
    ledger.check(1, (0, 0, 0, 0, 0, 0, 0, 1), 0)
    ledger.check(0, (0, 0, 0, 0, 0, 0, 0, 1), 1)

    with pytest.raises(BrokenPromiseError, match="2 given, 0 accepted, 1 rejected"):
        ledger.check(0, (0, 0, 0, 0, 0, 0, 0, 1), 0)
    with pytest.raises(BrokenPromiseError, match="2 given, 2 accepted, 1 rejected"):
        ledger.check(2, (0, 0, 0, 0, 0, 0, 0, 1), 0)
