"""Bag time against a steady clock."""

from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.player.pace import Pace

SECOND = 1_000_000_000


def test_bag_time_passes_at_the_rate():
    pace = Pace(2.0)
    pace.start(100 * SECOND, 5.0)
    assert pace.at(5.0) == 100 * SECOND
    assert pace.at(6.5) == 103 * SECOND
    assert pace.wait(104 * SECOND, 6.5) == 0.5


def test_a_pause_stops_bag_time_and_nothing_is_due_in_it():
    pace = Pace(1.0)
    pace.start(0, 0.0)
    pace.toggle(1.0)
    assert pace.paused
    assert pace.at(50.0) == SECOND
    assert pace.wait(SECOND, 50.0) == float("inf")
    pace.toggle(51.0)
    assert not pace.paused
    assert pace.at(51.5) == 3 * SECOND // 2


def test_a_new_round_begins_paused_if_the_bag_is():
    pace = Pace(1.0)
    pace.start(0, 0.0)
    pace.toggle(1.0)
    pace.start(7 * SECOND, 2.0)
    assert pace.at(9.0) == 7 * SECOND
    pace.toggle(10.0)
    assert pace.at(11.0) == 8 * SECOND


@given(
    rate=st.floats(1e-2, 1e2),
    ahead=st.floats(0.0, 1e4),
    begin=st.floats(0.0, 1e6),
)
@settings(derandomize=True, deadline=None)
def test_after_the_wait_the_bag_is_there(rate, ahead, begin):
    pace = Pace(rate)
    pace.start(SECOND, begin)
    due = SECOND + round(ahead * SECOND)
    wait = pace.wait(due, begin)
    assert abs(pace.at(begin + wait) - due) <= 1 + 1e-9 * rate * (begin + wait) * SECOND
