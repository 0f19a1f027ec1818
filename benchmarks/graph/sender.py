"""Program that publishes joint states by a plan: `python -m benchmarks.graph.sender plan result`.

Messages are serialised once; stamps and numbers are then written into the bytes, so that the sender
takes little of the machine that it is to measure. Every process stamps with the same wall clock.
"""

import struct
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import rclpy
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState

from benchmarks.graph.plan import Block, Plan, Sent, load_plan, save_sent
from benchmarks.graph.program import processor_ns

_STAMP = struct.Struct("<iI")
_STAMP_AT = 4  # after the header of the encapsulation
_SECOND = 1_000_000_000
_DISCOVERY = 60.0  # [s]


class JointStateBytes:
    """A serialised JointState whose stamp, velocities and efforts are written in place."""

    def __init__(self, joints: Sequence[str]) -> None:
        marks = [1.0 + place for place in range(2 * len(joints))]
        velocity, effort = marks[: len(joints)], marks[len(joints) :]
        message = JointState(name=list(joints), velocity=velocity, effort=effort)
        self._bytes = bytearray(serialize_message(message))
        self._places = tuple(
            self._bytes.index(struct.pack(f"<{len(joints)}d", *part)) for part in (velocity, effort)
        )

    def filled(self, stamp_ns: int, numbers: NDArray[np.float64]) -> bytes:
        """Return the message with a stamp and with `numbers` (2, joints)."""
        _STAMP.pack_into(self._bytes, _STAMP_AT, *divmod(stamp_ns, _SECOND))
        for place, part in zip(self._places, numbers, strict=True):
            raw = part.tobytes()
            self._bytes[place : place + len(raw)] = raw
        return bytes(self._bytes)


def main(arguments: Sequence[str]) -> None:
    """Send."""
    plan, result = load_plan(Path(arguments[0])), Path(arguments[1])
    rclpy.init()
    node = rclpy.create_node("sender")
    publishers = _publishers(node, plan)
    _wait_for_listeners(publishers)
    message, cycle = JointStateBytes(plan.joints), np.load(plan.cycle)
    sent = []
    for block in plan.blocks:
        before = _used(block)
        found = _send(block, [publishers[topic] for topic in block.topics], message, cycle)
        time.sleep(block.pause)
        spent = _used(block) - before if block.watched >= 0 else -1
        sent.append(found._replace(processor_ns=spent))
        save_sent(sent, result)
    node.destroy_node()
    rclpy.shutdown()


def _publishers(node: Node, plan: Plan) -> dict[str, Publisher[JointState]]:
    topics = dict.fromkeys(topic for block in plan.blocks for topic in block.topics)
    quality = QoSProfile(depth=plan.depth)
    return {topic: node.create_publisher(JointState, topic, quality) for topic in topics}


def _wait_for_listeners(publishers: dict[str, Publisher[JointState]]) -> None:
    end = time.monotonic() + _DISCOVERY
    for topic, publisher in publishers.items():
        while publisher.get_subscription_count() == 0:
            if time.monotonic() > end:
                raise TimeoutError(f"nobody listens to {topic}")
            time.sleep(0.01)
    time.sleep(1.0)  # that one is known does not mean that the other side knows as well


def _used(block: Block) -> int:
    return processor_ns(block.watched) if block.watched >= 0 else -1


def _send(
    block: Block,
    publishers: list[Publisher[JointState]],
    message: JointStateBytes,
    cycle: NDArray[np.float64],
) -> Sent:
    """Publish at an even pace; what is late goes out at once."""
    ticks, period = round(block.seconds * block.rate), 1.0 / block.rate
    began = time.perf_counter()
    first = stamp = 0
    latest = 0.0
    for tick in range(ticks):
        early = began + tick * period - time.perf_counter()
        if early > 0.0:
            time.sleep(early)
        latest = max(latest, -early)
        stamp = time.time_ns()
        first = first or stamp
        filled = message.filled(stamp, cycle[tick % len(cycle)])
        for publisher in publishers:
            publisher.publish(filled)
    return Sent(first, stamp, ticks, latest, -1)


if __name__ == "__main__":
    main(sys.argv[1:])
