"""Program of the node: `belt_node`."""

import gc
import signal
import sys
from collections.abc import Sequence
from types import FrameType

import rclpy
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from belt_ros.joining import joining
from belt_ros.program_arguments import ends_at_once

_USAGE = """\
usage: belt_node --ros-args --params-file DRIVE.yaml [-p NAME:=VALUE] [-r OLD:=NEW]

Estimates slip, tension and friction of belt drives, and publishes them with alarms. Make the file
with `belt init`, check it with `belt check`; `belt parameters` lists what can stand in it."""
_LONGEST_WAIT = 0.1  # [s] until a signal is noticed while nothing else happens


def make_executor() -> Executor:
    """Return the cheapest executor there is: events cost a third of the CPU of wait sets."""
    try:
        from rclpy.experimental.events_executor import EventsExecutor  # noqa: PLC0415
    except ImportError:  # older than Kilted and late Jazzy
        return SingleThreadedExecutor()
    return EventsExecutor()


class _Stop:
    """Set by SIGINT or SIGTERM, however often they come: launch and a shell may both send them.

    While the node is made, which may be a minute of compiling, they end the program at once. Later
    they only leave word: rclpy's own handlers would invalidate the context in the middle of a
    callback, whose publishing then raises.
    """

    def __init__(self) -> None:
        self.requested = False
        self.making = True
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._request)

    def _request(self, number: int, frame: FrameType | None) -> None:
        del number, frame
        self.requested = True
        # Python gives up its handlers before the process ends: one more would still kill it.
        for each in (signal.SIGINT, signal.SIGTERM):
            signal.signal(each, signal.SIG_IGN)
        if self.making:
            raise SystemExit(0)


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM; return the exit code."""
    stop = _Stop()
    code = ends_at_once("belt_node", args, _USAGE)
    if code is not None:
        return code
    rclpy.init(
        args=None if args is None else list(args),
        signal_handler_options=SignalHandlerOptions.NO,
    )
    with joining():
        # So that --help is quick, and others are found meanwhile.
        from belt_ros.node.belt_node import BeltNode  # noqa: PLC0415

        node = BeltNode()
    executor = make_executor()
    executor.add_node(node)
    # What is imported by now stays; looking through it for garbage would hold up input for 0.2 s.
    gc.freeze()
    stop.making = False
    # spin() of EventsExecutor would do nothing but burn CPU.
    while rclpy.ok() and not stop.requested:
        executor.spin_once(timeout_sec=_LONGEST_WAIT)
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
