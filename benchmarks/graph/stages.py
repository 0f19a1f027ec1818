"""Where the time of one message goes: each stage of the node called by itself."""

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import fmean, median
from typing import Any, NamedTuple, TypeVar

import rclpy
from belt_msgs.msg import BeltState
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from belt_ros.drive_inputs import measurement_from_joint_state
from belt_ros.estimation import BeltFilter, Measurement
from belt_ros.node.conversions import nanoseconds, time_message
from belt_ros.settings import DriveSettings, load_settings
from belt_ros.state_bytes import StateBytes
from benchmarks.estimation.judged import SOURCES
from benchmarks.estimation.report import verdicts
from benchmarks.graph.bench import bench
from benchmarks.graph.signals import Cycle, loaded

_TOPIC = "stages/state"
_WARM = 100  # messages that do not count
_DESERIALISE, _CONVERT, _STEP = "deserialise", "joint state to measurement", "BeltMonitor.step"
_PREDICT, _UPDATE, _READ = "  BeltFilter.predict", "  BeltFilter.update", "  BeltFilter.readings"
_STATE, _PUBLISH = "estimate to bytes", "publish"
_WHOLE = (_DESERIALISE, _CONVERT, _STEP, _STATE, _PUBLISH)

_Result = TypeVar("_Result")
_Publish = Callable[[bytes], None]


class Stage(NamedTuple):
    """One stage."""

    case: str
    sources: str
    calls: int
    middle: float  # median [us]
    mean: float  # [us], with what is done only now and then


class _Watch:
    """Times of each stage [us]."""

    def __init__(self) -> None:
        self.times: dict[str, list[float]] = {}

    def time(self, stage: str, call: Callable[..., _Result], *arguments: Any) -> _Result:
        """Call, and note what it takes."""
        began = time.thread_time_ns()
        result = call(*arguments)
        self.times.setdefault(stage, []).append((time.thread_time_ns() - began) * 1e-3)
        return result


def run_stages(params: Path, rate: float, seconds: float) -> list[Stage]:
    """Time every stage on a drive's messages at `rate` [Hz], `seconds` of them, none pooled."""
    settings = load_settings(params, {"limits.pool_period": 0.0})
    watch = _Watch()
    with _publisher() as publish:
        _walk(settings, _messages(loaded(settings, rate), rate, seconds), publish, watch)
    return [
        Stage(stage, SOURCES, len(times) - _WARM, median(times[_WARM:]), fmean(times[_WARM:]))
        for stage, times in watch.times.items()
    ]


def _messages(cycle: Cycle, rate: float, seconds: float) -> Iterator[bytes]:
    for sample in range(_WARM + round(seconds * rate)):
        velocities, efforts = cycle.numbers[sample % len(cycle.numbers)].tolist()
        message = JointState(name=list(cycle.joints), velocity=velocities, effort=efforts)
        message.header.stamp = time_message(round((1.0 + sample / rate) * 1e9))
        yield serialize_message(message)


@contextmanager
def _publisher() -> Iterator[_Publish]:
    """Give a publisher with one subscriber, in a domain of their own."""
    with bench() as place:
        os.environ.update(place.environment)
        counter = place.start("benchmarks.graph.counter", str(place.folder / "heard"), _TOPIC)
        counter.wait_for("ready")
        context = rclpy.Context()
        rclpy.init(context=context)
        node = rclpy.create_node("stages", context=context)
        publisher = node.create_publisher(BeltState, _TOPIC, QoSProfile(depth=100))
        while publisher.get_subscription_count() == 0:
            time.sleep(0.01)
        yield publisher.publish
        node.destroy_node()
        rclpy.shutdown(context=context)


def _walk(
    settings: DriveSettings, messages: Iterator[bytes], publish: _Publish, watch: _Watch
) -> None:
    monitor = settings.monitor()
    states = StateBytes(settings.name, BeltState.get_fields_and_field_types())
    alone = BeltFilter(settings.drive, settings.prior, settings.noise, settings.drift)
    for raw in messages:
        message = watch.time(_DESERIALISE, deserialize_message, raw, JointState)
        measurement = watch.time(
            _CONVERT, measurement_from_joint_state, settings.driver, settings.driven, message
        )
        assert isinstance(measurement, Measurement), measurement
        estimate = watch.time(_STEP, monitor.step, measurement).estimate
        assert estimate is not None
        assert estimate.stamp_ns == nanoseconds(message.header.stamp)
        _walk_filter(alone, measurement, settings.limits.standstill_speed, watch)
        state = watch.time(_STATE, states.write, estimate)
        watch.time(_PUBLISH, publish, state)


def _walk_filter(
    alone: BeltFilter, measurement: Measurement, slowest: float, watch: _Watch
) -> None:
    """Time the parts of a step on a filter of its own."""
    if alone.stamp_ns is None:
        alone.start(measurement)
        return
    watch.time(_PREDICT, alone.predict, measurement)
    watch.time(_UPDATE, alone.update)
    watch.time(_READ, alone.view, slowest)


def stage_verdicts(rows: list[Stage]) -> list[str]:
    """Return the sum of the stages, beside the highest rate that it would allow."""
    whole = sum(row.mean for row in rows if row.case in _WHOLE)
    reached = f"{whole:.0f} us, {1e6 / whole:.0f} messages a second at most"
    return verdicts([("1000 messages a second on one core", reached, whole < 1000.0)])


def stage_lines(rows: list[Stage]) -> tuple[list[str], list[list[str]]]:
    """Return head and lines of the table."""
    whole = sum(row.middle for row in rows if row.case in _WHOLE)
    lines = [
        [
            row.case.replace("  ", "&nbsp;&nbsp;"),
            f"{row.middle:.1f}",
            f"{row.mean:.1f}",
            f"{row.middle / whole:.0%}",
            str(row.calls),
        ]
        for row in rows
    ]
    return ["stage", "median [us]", "mean [us]", "share", "calls"], lines
