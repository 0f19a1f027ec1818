"""Program that notes stamp and arrival of states: `... counter result [--keep] topic [topic ...]`.

Nothing is decoded but the stamp, so that the counter takes little of the machine that it is to
measure. It writes what it noted when it is interrupted; of the messages the last, or all with
`--keep`.
"""

import itertools
import signal
import struct
import sys
import threading
import time
from array import array
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import rclpy
from belt_msgs.msg import BeltState
from numpy.typing import NDArray
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from rclpy.signals import SignalHandlerOptions

from belt_ros.node.main import make_executor

_STAMP = struct.Struct("<iI")
_STAMP_AT = 4  # after the header of the encapsulation
_SECOND = 1_000_000_000
_DEPTH = 10_000


class Heard(NamedTuple):
    """What arrived on one topic."""

    stamps: NDArray[np.int64]  # [ns]
    arrivals: NDArray[np.int64]  # [ns], on the wall clock, as the stamps
    messages: tuple[bytes, ...]  # the last of them, or all

    @classmethod
    def load(cls, path: Path) -> "list[Heard]":
        """Read what a counter wrote, in the order of its topics."""
        heard = []
        with np.load(path) as parts:
            for place in range(len(parts.files) // 3):
                times, sizes = parts[f"times_{place}"], parts[f"sizes_{place}"]
                ends = np.cumsum(sizes).tolist()
                raw = parts[f"bytes_{place}"].tobytes()
                messages = tuple(raw[a:b] for a, b in zip([0, *ends[:-1]], ends, strict=True))
                heard.append(cls(times[:, 0], times[:, 1], messages))
        return heard

    def state(self, place: int) -> BeltState:
        """Return one of the messages that were kept."""
        return deserialize_message(self.messages[place], BeltState)

    def arrived(self, first_ns: int, last_ns: int) -> "Heard":
        """Return what arrived within these, ends included, where all messages were kept."""
        return self._chosen((self.arrivals >= first_ns) & (self.arrivals <= last_ns))

    def between(self, first_ns: int, last_ns: int) -> "Heard":
        """Return what is stamped within these, ends included."""
        return self._chosen((self.stamps >= first_ns) & (self.stamps <= last_ns))

    def _chosen(self, chosen: NDArray[np.bool_]) -> "Heard":
        messages = self.messages
        if len(messages) == len(chosen):
            messages = tuple(itertools.compress(messages, chosen))
        return Heard(self.stamps[chosen], self.arrivals[chosen], messages)

    def delays(self, pooled: float = 0.0) -> NDArray[np.float64]:
        """From the stamp of the last message in a state to the state's arrival [s].

        A state of messages pooled over some time is stamped in the middle of it: from the first of
        them to the last it takes `pooled` [s].
        """
        return (self.arrivals - self.stamps).astype(np.float64) * 1e-9 - 0.5 * pooled


class _Notes:
    """Of one topic."""

    def __init__(self, *, keep: bool) -> None:
        self.times = array("q")
        self.messages: deque[bytes] = deque(maxlen=None if keep else 1)

    def take(self, message: bytes) -> None:
        """Note a message."""
        seconds, nanoseconds = _STAMP.unpack_from(message, _STAMP_AT)
        self.times.extend((seconds * _SECOND + nanoseconds, time.time_ns()))
        self.messages.append(message)


def main(arguments: Sequence[str]) -> None:
    """Listen until interrupted."""
    stopping = threading.Event()
    signal.signal(signal.SIGINT, lambda *_: stopping.set())
    result, keep = Path(arguments[0]), "--keep" in arguments
    topics = [each for each in arguments[1:] if each != "--keep"]
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("counter")
    notes = [_Notes(keep=keep) for _ in topics]
    for topic, each in zip(topics, notes, strict=True):
        take: Callable[..., None] = each.take
        node.create_subscription(BeltState, topic, take, QoSProfile(depth=_DEPTH), raw=True)
    executor = make_executor()
    executor.add_node(node)
    sys.stdout.write("ready\n")
    while not stopping.is_set():
        executor.spin_once(timeout_sec=0.1)
    parts: dict[str, Any] = {}
    for place, each in enumerate(notes):
        parts[f"times_{place}"] = np.array(each.times, dtype=np.int64).reshape(-1, 2)
        parts[f"sizes_{place}"] = np.array([len(message) for message in each.messages], np.int64)
        parts[f"bytes_{place}"] = np.frombuffer(b"".join(each.messages), dtype=np.uint8)
    with result.open("wb") as file:
        np.savez(file, **parts)
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main(sys.argv[1:])
