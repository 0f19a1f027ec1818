"""When the node pools for want of processor, with a queue that is handed out in its order."""

import itertools
from collections import deque
from collections.abc import Callable

import pytest

from belt_ros.node.keeping_up import KeepingUp

TICK = 0.1  # [s] between two calls of the timer
INTERVAL = 0.01  # [s] between two messages
LONGEST = 0.2  # [s]


class Queue:
    """Messages and a timer wait for one processor, and are handed out in the order they came."""

    def __init__(self, keeping_up: KeepingUp) -> None:
        self.keeping_up = keeping_up
        self.now = 0.0
        self.waits: list[float] = []  # [s] of the messages
        self.changes: list[tuple[float, float]] = []  # when, to what pool period [s]
        self._waiting: deque[tuple[float, bool]] = deque()
        self._next_message, self._next_tick = 0.0, TICK

    def run(self, seconds: float, cost: Callable[[float], float], stop: float = 0.0) -> None:
        """Hand out for some time, each message at a `cost` [s] by the pool period; `stop` first."""
        end = self.now + seconds
        self.now += stop
        while self.now < end:
            self._arrive()
            if not self._waiting:
                self.now = min(self._next_message, self._next_tick)
                continue
            came, is_timer = self._waiting.popleft()
            if is_timer:
                changed = self.keeping_up.timer(self.now)
                self._next_tick = self.now + TICK
            else:
                self.waits.append(self.now - came)
                changed = self.keeping_up.message(self.now)
                self.now += cost(self.keeping_up.pool_period)
            if changed:
                self.changes.append((self.now, self.keeping_up.pool_period))

    def _arrive(self) -> None:
        coming = []
        while self._next_message <= self.now:
            coming.append((self._next_message, False))
            self._next_message += INTERVAL
        if self._next_tick <= self.now:
            coming.append((self._next_tick, True))
            self._next_tick = float("inf")
        self._waiting.extend(sorted(coming))


def stepping(each: float, reading: float = 0.001) -> Callable[[float], float]:
    """Cost of a message: it is read, and `each` [s] goes into its share of a step."""
    return lambda pool_period: reading + each / max(round(pool_period / INTERVAL), 1)


def test_a_node_in_time_pools_nothing() -> None:
    queue = Queue(KeepingUp(TICK, LONGEST))
    queue.run(60.0, stepping(0.008))
    assert queue.changes == []
    assert queue.keeping_up.pool_period == 0.0


def test_six_times_too_much_input_is_pooled_within_two_seconds_and_followed() -> None:
    queue = Queue(KeepingUp(TICK, LONGEST))
    queue.run(2.0, stepping(0.06))
    pooled = queue.keeping_up.pool_period
    assert 0.06 < pooled <= LONGEST
    queue.run(3.0, stepping(0.06))
    queue.waits.clear()
    queue.run(4.0, stepping(0.06))
    assert max(queue.waits) < 0.1
    assert queue.keeping_up.pool_period == pooled


def test_what_holds_the_node_up_once_changes_nothing() -> None:
    """Such as a file that is written, or a transition: the queue it leaves is soon worked off."""
    queue = Queue(KeepingUp(TICK, LONGEST))
    for _ in range(5):
        queue.run(3.0, stepping(0.001), stop=0.5)
    assert queue.changes == []


def test_it_returns_to_every_measurement_once_there_is_time_for_it() -> None:
    queue = Queue(KeepingUp(TICK, LONGEST))
    queue.run(5.0, stepping(0.06))
    queue.run(60.0, stepping(0.004))
    assert queue.keeping_up.pool_period == 0.0
    went_down = [when for when, period in queue.changes if period < LONGEST][-3:]
    assert all(10.0 <= b - a < 11.0 for a, b in itertools.pairwise(went_down))


@pytest.mark.parametrize("each", [0.0091, 0.0095, 0.015, 0.017, 0.03, 0.045, 0.06])
def test_less_that_was_too_little_is_tried_ever_less_often(each: float) -> None:
    queue = Queue(KeepingUp(TICK, LONGEST))
    queue.run(3600.0, stepping(each))
    begins = [
        when
        for (_, before), (when, period) in itertools.pairwise([(0.0, 0.0), *queue.changes])
        if period > before == 0.0
    ]
    assert len(queue.changes) <= 40
    assert 1 <= len(begins) <= 12  # so often is a warning logged
    assert sum(wait > 0.5 for wait in queue.waits) < 0.01 * len(queue.waits)


def test_a_file_that_is_written_now_and_then_does_not_keep_it_from_going_back() -> None:
    queue = Queue(KeepingUp(TICK, LONGEST))
    queue.run(5.0, stepping(0.06))
    for _ in range(10):
        queue.run(10.0, stepping(0.002), stop=0.3)
    assert queue.keeping_up.pool_period == 0.0


def test_a_machine_that_pauses_goes_on_as_it_was() -> None:
    keeping_up = KeepingUp(TICK, LONGEST)
    queue = Queue(keeping_up)
    queue.run(5.0, stepping(0.06))
    pooled = keeping_up.pool_period
    for tick in range(3000):
        assert not keeping_up.timer(queue.now + TICK * tick)
    assert keeping_up.pool_period == pooled > 0.0


def test_where_it_may_not_pool_it_does_not() -> None:
    queue = Queue(KeepingUp(TICK, 0.0))
    queue.run(5.0, stepping(0.06))
    assert queue.changes == []


def test_begun_anew_it_has_forgotten_what_was_before() -> None:
    queue = Queue(KeepingUp(TICK, LONGEST))
    queue.run(5.0, stepping(0.06))
    queue.keeping_up.begin()
    assert queue.keeping_up.pool_period == 0.0
    assert not queue.keeping_up.message(queue.now + 100.0)
    assert not queue.keeping_up.timer(queue.now + 100.0)
