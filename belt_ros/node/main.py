"""Program of the node: `belt_node`."""

import signal
import sys
from collections.abc import Sequence

import rclpy
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor

from belt_ros.node.belt_node import BeltNode

_WAKE_PERIOD = 1.0  # [s]


def _make_executor() -> Executor:
    """Return the cheapest executor there is: events cost a third of the CPU of wait sets."""
    try:
        from rclpy.experimental.events_executor import EventsExecutor  # noqa: PLC0415
    except ImportError:  # before Kilted
        return SingleThreadedExecutor()
    return EventsExecutor()


def _spin(executor: Executor) -> None:
    """Run until shutdown. `EventsExecutor.spin` would do nothing but burn CPU."""
    try:
        while rclpy.ok():
            executor.spin_once(timeout_sec=_WAKE_PERIOD)
    except ExternalShutdownException:
        pass


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until it is interrupted; return the exit code.

    rclpy ends the loop on SIGINT and SIGTERM. Python's own handler would raise at any place, also
    during teardown, since launch and a shell may both send the signal.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        rclpy.init(args=None if args is None else list(args))
    except RuntimeError as error:  # a parameter file that is not there, a misspelt argument
        sys.stderr.write(f"belt_node: {error}\n")
        return 1
    node = BeltNode()
    executor = _make_executor()
    executor.add_node(node)
    _spin(executor)
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
