"""One drive, as a node has it but for the middleware: messages and service calls in, checks out."""

import math
import time
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from belt_msgs.msg import BeltState
from rclpy.serialization import deserialize_message, serialize_message

from belt_ros.estimation import (
    BeltEstimate,
    Learned,
    Maintenance,
    MaintenanceKind,
    Measurement,
    MemoryRefusedError,
    Rejection,
)
from belt_ros.mechanics import DriveError
from belt_ros.node.conversions import alarm_message
from belt_ros.node.inputs import DriveInputs
from belt_ros.node.pipeline import Outcome, Pipeline
from belt_ros.node.topic_hub import Listener, TopicHub
from belt_ros.node_tables import InputKind
from belt_ros.settings import DriveSettings
from belt_ros.state_bytes import StateBytes
from benchmarks.hostile.checks import Ledger, check_message, check_row
from benchmarks.hostile.drives import retuned
from benchmarks.hostile.spoiling import SPECIAL

_members = attrgetter("_monitor._filter.members")  # how many are alive is nobody else's business
_AHEAD_NS = 2_000_000_000  # more than any pool spans
_YEAR = 365.25 * 86400.0
serialize_message(BeltState())  # what this imports warns, which within a block would count


class Step(NamedTuple):
    """What one estimate took."""

    seconds: float  # of this thread
    members: int


class _Graph(TopicHub):
    """Topics without a middleware, and ROS time as it is set."""

    def __init__(self) -> None:
        self.listeners: dict[str, Listener] = {}
        self.time_ns = 0

    def now_ns(self) -> int:
        return self.time_ns

    def subscribe(self, message_type: type, topic: str, listener: Listener) -> str:
        assert message_type is not None
        self.listeners[f"/{topic}"] = listener
        return f"/{topic}"


class Session:
    """Feeds one drive, and checks after every message all that goes out.

    Parameters
    ----------
    settings : DriveSettings
    base : str
        Which description `settings` were drawn about.
    kind : InputKind
    random : Generator

    Raises
    ------
    BrokenPromiseError
        From any method: something does not hold that must.
    """

    def __init__(
        self, settings: DriveSettings, base: str, kind: InputKind, random: np.random.Generator
    ) -> None:
        self.settings, self._base, self._random = settings, base, random
        self._graph = _Graph()
        self._steady = 0.0
        self._learned: Learned | None = None
        self._ledger = Ledger()
        self.inputs = DriveInputs(
            self._graph,
            kind,
            "",
            (settings.driver, settings.driven),
            float(random.choice([0.0, 0.05, 1.0])),
            float(random.choice([0.0, 0.001, 0.1])),
            self._take,
            disorder=float(random.choice([0.0, 0.0, 0.02])),
            gap=settings.limits.greatest_gap,
            loads=bool(random.random() < 0.5),
            heard=self._hear,
        )
        self.pipeline = Pipeline(
            "hostile", self.inputs.sources, settings, steady=lambda: self._steady
        )
        fields = BeltState.get_fields_and_field_types()
        self._state_bytes = StateBytes(self.pipeline.drive_name, fields)
        self.steps: list[Step] = []
        self.messages = self.states = self.waiting = 0
        self.settled = False  # whether a measurement was added so that nothing waits
        self.accepted = self.calls = self.refusals = 0
        self.rejected = np.zeros(len(Rejection), dtype=np.int64)
        self._counted = (0, (0,) * len(Rejection))

    def send(self, topic: str, message: Any, now_ns: int) -> None:
        """Hand over a message that comes on `topic` at ROS time `now_ns`."""
        self._graph.time_ns = now_ns
        self._steady += float(self._random.choice([1e-4, 0.01, 0.01, 3.0]))
        listener = self._graph.listeners.get(topic)
        if listener is not None:
            self.messages += 1
            listener(message)

    def _hear(self, topic: str, stamp_ns: int | None) -> None:
        self.pipeline.hear(topic, stamp_ns, self._graph.now_ns())

    def _take(self, ready: Measurement | Rejection, _: str, stamp_ns: int) -> None:
        self._ledger.give(ready)
        began = time.thread_time()
        outcome = self.pipeline.take(ready, stamp_ns, self._graph.now_ns())
        seconds = time.thread_time() - began
        if outcome.estimate is not None:
            self.steps.append(Step(seconds, int(_members(self.pipeline))))
            self._publish(outcome.estimate)
        self._look_at(outcome)
        self._count()

    def _publish(self, estimate: BeltEstimate) -> None:
        self.states += 1
        check_message(deserialize_message(self._state_bytes.write(estimate), BeltState))

    def _look_at(self, outcome: Outcome) -> None:
        if outcome.alarm is not None:
            check_message(alarm_message(self.pipeline.drive_name, outcome.alarm))
            check_row(self.pipeline.drive_status())
        if outcome.calibration is not None:
            self._diagnose()

    def _count(self) -> None:
        """Check that nothing was lost, and keep the counts for the block."""
        health = self.pipeline.health
        self.waiting = self.pipeline.waiting
        self._ledger.check(health.accepted, health.rejections, self.waiting)
        accepted, rejections = self._counted
        self.accepted += health.accepted - accepted
        self.rejected += np.subtract(health.rejections, rejections)
        self._counted = health.accepted, health.rejections

    def call(self) -> None:
        """Do one of the things that services, timers and parameters do."""
        self.calls += 1
        calls = (
            self._reset,
            self._jump,
            self._acknowledge,
            self.pipeline.calibrate,
            self._maintain,
            self._maintain,
            self._retune,
            self._learn,
            self._learn,
            self._restore,
            self._watch,
            self._watch,
            self._diagnose,
            self._diagnose,
            self.inputs.begin,
            self.inputs.flush,
            self.inputs.flush,
            self.pipeline.begin,
        )
        calls[int(self._random.integers(len(calls)))]()

    def _reset(self) -> None:
        if self._random.random() < 0.3:
            self.pipeline.reset()
            self._ledger.begin(0)
            self._counted = (0, (0,) * len(Rejection))

    def _jump(self) -> None:
        behind = self._graph.now_ns() - round(10.0 ** self._random.uniform(0.0, 17.0))
        if self.pipeline.reset_after_jump(behind):
            health = self.pipeline.health
            self._ledger.begin(health.accepted + sum(health.rejections))

    def _acknowledge(self) -> None:
        status = self.pipeline.acknowledge()
        if status is not None:
            check_message(alarm_message(self.pipeline.drive_name, status))

    def _wild(self, typical: float) -> float:
        random = self._random
        way = random.random()
        if way < 0.2:
            return float(random.choice(SPECIAL))
        if way < 0.3:
            return math.nan
        return typical * float(10.0 ** random.normal(0.0, 1.0 if way < 0.8 else 4.0))

    def _maintain(self) -> None:
        tension = self._wild(self.settings.prior.tension)
        kind = MaintenanceKind(int(self._random.integers(1, 4)))
        try:
            maintenance = Maintenance(kind, tension, self._wild(0.1 * tension))
        except DriveError:
            self.refusals += 1
            return
        assert "nan" not in self.pipeline.maintain(maintenance)

    def _retune(self) -> None:
        settings = retuned(self._random, self._base)
        self.pipeline.retune(settings)
        self.inputs.retune(settings.limits.greatest_gap)

    def _learn(self) -> None:
        try:
            self._learned = self.pipeline.learned(1e9 + self._steady) or self._learned
        except MemoryRefusedError:
            self.refusals += 1

    def _restore(self) -> None:
        if self._learned is not None:
            elapsed = self._random.choice([0.0, 1.0, 3600.0, _YEAR, 1e300, math.inf, -1.0])
            self.pipeline.restore(self._learned, float(elapsed))

    def _watch(self) -> None:
        self._look_at(self.pipeline.watch(self._graph.now_ns()))

    def _diagnose(self) -> None:
        report = self.pipeline.input_report()
        check_row(self.pipeline.drive_status())
        check_row(self.pipeline.input_status(report), idle=report.received == 0)
        row = self.pipeline.calibration_status()
        if row is not None:
            check_row(row)

    def finish(self) -> None:
        """Take in what waits, and check once more."""
        self.inputs.flush()
        self.inputs.flush()
        assert self.inputs.pending == 0
        self._diagnose()
        self._count()
        last_ns = self._ledger.last_ns
        if self.waiting > 0 and last_ns is not None:
            self.settled = True  # by a stamp far ahead, which ends the pool
            self._take(Measurement(last_ns + _AHEAD_NS, 1.0, 1.0), "", last_ns)
        self._count()
