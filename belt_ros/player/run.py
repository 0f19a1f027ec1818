"""Publish a bag to a running graph, as it was recorded, with the clock if asked for."""

import math
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple

import rclpy
from builtin_interfaces.msg import Time
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock

from belt_ros.player.keys import Keys
from belt_ros.player.pace import Pace
from belt_ros.player.selection import CLOCK, Route, Selection, remappings, selection
from belt_ros.replay.errors import BagError
from belt_ros.replay.sources import Source, Wanted, close_all, open_sources

_SECOND_NS = 1_000_000_000
_LOOK = 0.02  # [s] between looks at keys and signals
_CLOCK_PERIOD = 0.02  # [s] between clocks while nothing else is due
_CLOCK_STEP_NS = 1_000_000  # of bag time, by which the clock may be behind a message
_AFTER_LISTENER = 0.3  # [s] until all listeners of a graph have been met
_DELIVERY = 2.0  # [s] for the last messages
_BETWEEN = 0.5  # [s] between rounds: topics overtake each other, and the clock is to jump last
_SLOWEST, _FASTEST = 1e-3, 1e3

Tell = Callable[[str], None]


class Played(NamedTuple):
    """What went out."""

    messages: int
    rounds: int  # times that the bag was played to its end
    interrupted: bool
    note: str  # what of the bag is lost; empty if nothing is


class _Stop:
    """Set by SIGINT or SIGTERM, however often they come."""

    def __init__(self) -> None:
        self.requested = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._request)

    def _request(self, _number: int, _frame: FrameType | None) -> None:
        self.requested = True


class _Stage(Node):
    """The node: one publisher for each topic, and one for the clock."""

    def __init__(self, routes: Sequence[Route], *, clock: bool) -> None:
        super().__init__("belt_player", start_parameter_services=False)
        self.outlets: dict[str, Publisher[Any]] = {
            route.recorded: self.create_publisher(route.kind, route.published, route.quality)
            for route in routes
        }
        self.types = {route.recorded: route.type_name for route in routes}
        self._time = self.create_publisher(Clock, CLOCK, 10) if clock else None
        self._clock_ns: int | None = None

    def heard(self) -> bool:
        """Whether anyone listens to any of the topics."""
        return any(outlet.get_subscription_count() > 0 for outlet in self.outlets.values())

    def tell_time(self, bag_ns: int, step_ns: int) -> None:
        """Publish the clock if it is `step_ns` behind, or ahead."""
        if self._time is None:
            return
        before = self._clock_ns
        if before is not None and before <= bag_ns < before + step_ns:
            return
        seconds, nanoseconds = divmod(bag_ns, _SECOND_NS)
        self._time.publish(Clock(clock=Time(sec=seconds, nanosec=nanoseconds)))
        self._clock_ns = bag_ns

    def deliver(self, patience: float) -> None:
        """Wait until reliable listeners have all that went out."""
        end = time.monotonic() + patience
        for outlet in self.outlets.values():
            outlet.wait_for_all_acked(Duration(seconds=max(end - time.monotonic(), 0.01)))


def play(
    bag: str | Path,
    *,
    rate: float = 1.0,
    loop: bool = False,
    clock: bool = False,
    remap: Sequence[str] = (),
    topics: Sequence[str] = (),
    wait: float = 5.0,
    tell: Tell | None = None,
) -> Played:
    """Publish a bag's messages, byte by byte as they were recorded, when they are due.

    Each topic goes out with the quality of service that was recorded. On a terminal the space bar
    pauses and resumes. SIGINT and SIGTERM end it.

    Parameters
    ----------
    bag : path
        A rosbag2 directory, or a bare .mcap or .db3 file.
    rate : float
        Bag time per time [-].
    loop : bool
        Begin again half a second after the end, for ever; the clock jumps back.
    clock : bool
        Publish ``/clock``; before each message it is brought to the time it was recorded at.
    remap : sequence of str
        ``/old:=/new`` for topics under another name.
    topics : sequence of str
        Those to publish; all if empty.
    wait : float
        How long to wait for someone to listen before it begins [s].
    tell : callable, optional
        Given lines for the user.

    Raises
    ------
    BagError
        If the bag cannot be read, or there is nothing in it to publish.
    """
    if not _SLOWEST <= rate <= _FASTEST:
        raise BagError(f"--rate is {rate:g}; it must lie between {_SLOWEST:g} and {_FASTEST:g}")
    tell = tell or (lambda _line: None)
    path = Path(bag)
    renamed = remappings(remap)
    sources = open_sources(path)
    try:
        everything = [topic for source in sources for topic in source.topics]
        chosen = selection(path, everything, topics, renamed, own_clock=clock)
        for name, reason in chosen.left_out.items():
            tell(f"{name} is left out: {reason}")
        with Keys() as keys:
            return _on_stage(
                sources, chosen, Pace(rate), keys, loop=loop, clock=clock, wait=wait, tell=tell
            )
    finally:
        close_all(sources)


def _on_stage(
    sources: list[Source],
    chosen: Selection,
    pace: Pace,
    keys: Keys,
    *,
    loop: bool,
    clock: bool,
    wait: float,
    tell: Tell,
) -> Played:
    stop = _Stop()
    # The handlers of rclpy would raise out of whatever runs; these only leave word.
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        stage = _Stage(chosen.routes, clock=clock)
        _await_listener(stage, stop, wait, tell)
        if keys.there:
            tell("space: pause and resume; Ctrl-C: end")
        show = _Show(stage, pace, keys, stop, tell)
        rounds = show.run(sources, loop=loop)
        stage.deliver(0.0 if stop.requested else _DELIVERY)
        stage.destroy_node()
    finally:
        rclpy.try_shutdown()
    note = " ".join(source.note for source in sources if source.note)
    return Played(show.messages, rounds, stop.requested, note)


def _await_listener(stage: _Stage, stop: _Stop, patience: float, tell: Tell) -> None:
    end = time.monotonic() + patience
    if patience > 0.0 and not stage.heard():
        tell(f"waiting up to {patience:g} s for someone to listen")
    while not (stage.heard() or stop.requested) and time.monotonic() < end:
        time.sleep(_LOOK)
    if stage.heard():
        time.sleep(_AFTER_LISTENER)


class _Show:
    """One performance: the bag once, or again and again."""

    def __init__(self, stage: _Stage, pace: Pace, keys: Keys, stop: _Stop, tell: Tell) -> None:
        self.messages = 0
        self._stage = stage
        self._pace = pace
        self._keys = keys
        self._stop = stop
        self._tell = tell

    def run(self, sources: list[Source], *, loop: bool) -> int:
        """Play; return how often the bag was played to its end."""
        rounds = 0
        while not self._stop.requested:
            if not self._once(sources):
                if rounds == 0 and self.messages == 0 and not self._stop.requested:
                    raise BagError("the topics chosen hold no messages that can be read")
                break
            rounds += 1
            if not loop:
                break
            self._stage.deliver(_DELIVERY)
            time.sleep(_BETWEEN)
        return rounds

    def _once(self, sources: list[Source]) -> bool:
        """Whether there was anything, and all of it went out."""
        begun = False
        for topic, log_ns, content in _messages(sources, self._stage.types):
            if not begun:
                self._pace.start(log_ns, time.monotonic())
                begun = True
            self._wait_for(log_ns)
            if self._stop.requested:
                return False
            self._stage.tell_time(log_ns, _CLOCK_STEP_NS)
            self._stage.outlets[topic].publish(content)
            self.messages += 1
        return begun

    def _wait_for(self, log_ns: int) -> None:
        """Wait until a message is due, with an eye on keys and signals."""
        while not self._stop.requested:
            now = time.monotonic()
            if self._keys.space():
                self._pace.toggle(now)
                self._tell("paused" if self._pace.paused else "resumed")
            left = self._pace.wait(log_ns, now)
            if left <= 0.0:
                return
            if not self._pace.paused and left > _CLOCK_PERIOD:
                self._stage.tell_time(min(self._pace.at(now), log_ns), _CLOCK_STEP_NS)
            time.sleep(min(left, _LOOK) if math.isfinite(left) else _LOOK)


def _messages(sources: list[Source], wanted: Wanted) -> Iterator[tuple[str, int, bytes]]:
    for source in sources:
        yield from source.messages(wanted)
