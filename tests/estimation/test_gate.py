"""What is impossible is turned away, until it has come too often in a row."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from belt_ros.estimation.gate import Gate

STEP_NS = 10_000_000
GAP = 1.0  # [s]
DRIVER, DRIVEN = np.array([0, 2]), np.array([1, 3])


def refused(gate: Gate, at: int, seen=DRIVER) -> bool:
    return not gate.turn_away(seen, at * STEP_NS, GAP)


def test_the_fourth_in_a_row_is_believed() -> None:
    gate = Gate()
    assert [refused(gate, at) for at in range(4)] == [True, True, True, False]


def test_others_between_say_nothing_of_it() -> None:
    gate = Gate()
    told = []
    for at in range(0, 8, 2):
        told.append(refused(gate, at))
        gate.let_pass(DRIVEN)
    assert told == [True, True, True, False]


def test_once_all_that_it_read_is_believed_again_the_count_begins_anew() -> None:
    gate = Gate()
    both = np.array([0, 1, 2, 3])
    for at in range(0, 90, 3):
        assert refused(gate, at, both)
        gate.let_pass(DRIVER)
        assert gate.blames
        gate.let_pass(DRIVEN)
        assert not gate.blames


def test_what_was_turned_away_long_ago_counts_no_longer() -> None:
    """Also if what it read never came again, as of a sensor that fails."""
    gate = Gate()
    assert all(refused(gate, 400 * number) for number in range(10))


@given(st.floats(allow_nan=True))
def test_what_is_no_number_does_not_pass(innovation: float) -> None:
    assert Gate.passes(innovation) is (innovation <= 1000.0)
