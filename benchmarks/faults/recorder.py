"""Program that keeps what a drive says, and acknowledges: `... recorder result seconds`.

It acknowledges so many seconds after the rig's first truth, and writes what it heard when it is
interrupted.
"""

import signal
import struct
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import rclpy
from belt_msgs.msg import BeltState, SlipAlarm
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

_DEPTH = 10_000
_HEAD = struct.Struct("<Bqi")  # topic, arrival [ns], size
_LATCHED = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
STATE, ALARM, DIAGNOSTICS, TRUTH = range(4)
_TOPICS: tuple[tuple[str, type, QoSProfile], ...] = (
    ("belt_node/state", BeltState, QoSProfile(depth=_DEPTH)),
    ("belt_node/alarm", SlipAlarm, _LATCHED),
    ("/diagnostics", DiagnosticArray, QoSProfile(depth=100)),
    ("belt_rig/truth", BeltState, QoSProfile(depth=_DEPTH)),
)


class Heard(NamedTuple):
    """A message, and when it came on the wall clock [ns]."""

    arrival_ns: int
    message: Any


def load(path: Path) -> tuple[list[Heard], ...]:
    """Read what a recorder wrote: messages of state, alarm, diagnostics, truth."""
    raw = path.read_bytes()
    heard: tuple[list[Heard], ...] = tuple([] for _ in _TOPICS)
    place = 0
    while place < len(raw):
        topic, arrival, size = _HEAD.unpack_from(raw, place)
        place += _HEAD.size
        message = deserialize_message(raw[place : place + size], _TOPICS[topic][1])
        heard[topic].append(Heard(arrival, message))
        place += size
    return heard


class _Recorder:
    """Notes everything, and acknowledges once."""

    def __init__(self, node: Node, acknowledge: float) -> None:
        self.parts: list[bytes] = []
        self._wait = acknowledge
        self._due = -1.0
        self._service: Any = node.create_client(Trigger, "belt_node/acknowledge")
        for topic, (name, kind, qos) in enumerate(_TOPICS):
            node.create_subscription(kind, name, self._taker(topic), qos, raw=True)
        # The rig waits for subscribers of its readings only; now it waits for this one as well.
        node.create_subscription(JointState, "joint_states", lambda _: None, 1, raw=True)

    def _taker(self, topic: int) -> Any:
        def take(message: bytes) -> None:
            self.parts += [_HEAD.pack(topic, time.time_ns(), len(message)), message]
            if topic == TRUTH and self._due < 0.0:
                self._due = time.monotonic() + self._wait

        return take

    def attend(self) -> None:
        """Acknowledge if it is time."""
        if 0.0 <= self._due <= time.monotonic():
            self._due = float("inf")
            self._service.call_async(Trigger.Request())


def main(arguments: Sequence[str]) -> None:
    """Listen until interrupted."""
    stopping = threading.Event()
    signal.signal(signal.SIGINT, lambda *_: stopping.set())
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("recorder")
    recorder = _Recorder(node, float(arguments[1]))
    # Where several messages come at once, the other executor leaves some for later.
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    while not stopping.is_set():
        executor.spin_once(timeout_sec=0.05)
        recorder.attend()
    Path(arguments[0]).write_bytes(b"".join(recorder.parts))
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main(sys.argv[1:])
