"""Messages that never came, counted by the stamps of those that did."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from belt_ros.node.missing import Missing

STEP_NS = 10_000_000


def missing(stamps: list[int]) -> float:
    counted = Missing()
    for stamp_ns in stamps:
        counted.hear(stamp_ns)
    return counted.report()


def test_of_a_steady_sender_nothing_is_missing() -> None:
    rng = np.random.default_rng(1)
    jitter = rng.normal(0.0, 0.05 * STEP_NS, 1000).astype(int)
    assert missing([k * STEP_NS + int(jitter[k]) for k in range(1000)]) == 0


@pytest.mark.parametrize("share", [0.01, 0.3, 0.7])
def test_what_is_lost_at_random_is_counted(share: float) -> None:
    rng = np.random.default_rng(2)
    came = np.flatnonzero(rng.random(2000) >= share)
    lost = came[-1] - came[0] + 1 - came.size
    assert missing([int(k) * STEP_NS for k in came]) == lost


def test_what_only_comes_out_of_order_is_not_missing() -> None:
    stamps = [k * STEP_NS for k in range(100)]
    for k in range(10, 90, 7):
        stamps[k], stamps[k + 1] = stamps[k + 1], stamps[k]
    assert missing(stamps) == 0


def test_a_pause_is_no_loss_nor_is_a_bag_that_begins_again() -> None:
    run = [k * STEP_NS for k in range(100)]
    assert missing([*run, *(stamp + 60_000_000_000 for stamp in run)]) == 0
    assert missing([*(stamp + 60_000_000_000 for stamp in run), *run]) == 0


def test_a_loss_across_two_periods_is_counted_once() -> None:
    counted = Missing()
    for k in range(50):
        counted.hear(k * STEP_NS)
    assert counted.report() == 0
    for k in range(53, 100):
        counted.hear(k * STEP_NS)
    assert counted.report() == 3


def test_of_several_senders_on_one_topic_nothing_is_told() -> None:
    stamps = sorted(k * STEP_NS + shift for k in range(200) for shift in (0, 3_000_000))
    assert math.isnan(missing(stamps))


def test_of_a_sender_that_sends_when_it_likes_nothing_is_told() -> None:
    rng = np.random.default_rng(3)
    stamps = np.cumsum(rng.exponential(STEP_NS, 500)).astype(int)
    assert math.isnan(missing(stamps.tolist()))


@given(st.lists(st.integers(min_value=-(2**31) * 10**9, max_value=2**31 * 10**9), max_size=40))
def test_whatever_the_stamps_are_it_is_a_number_of_messages_or_unknown(stamps: list[int]) -> None:
    found = missing(stamps)
    assert math.isnan(found) or (found >= 0.0 and found == int(found))
