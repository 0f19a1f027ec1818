"""Program ``belt_rig``: plays a scenario of the virtual rig and ends with it."""

import signal
import sys
from types import FrameType

import rclpy
from rclpy.signals import SignalHandlerOptions

from belt_ros.joining import joining
from belt_ros.parameter_table import SettingsError
from belt_ros.program_arguments import ends_at_once
from belt_ros.rig.node import RigNode

_USAGE = """\
usage: belt_rig --ros-args -p config_file:=DRIVE.yaml -p scenario_file:=SCENARIO.yaml
                [-p NAME:=VALUE] [-r OLD:=NEW]

Plays a virtual drive on ROS 2 topics, with faults on request. `belt rig --help` says how to do it
with less to type, and how to write a bag instead."""


class _Stop:
    """Set by SIGINT or SIGTERM, however often they come."""

    def __init__(self) -> None:
        self.requested = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._request)

    def _request(self, _number: int, _frame: FrameType | None) -> None:
        self.requested = True

    def settle(self) -> None:
        """Let no further signal disturb the end of a process that has been told to stop."""
        if self.requested:
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, signal.SIG_IGN)

    def __call__(self) -> bool:
        return self.requested or not rclpy.ok()


def main(args: list[str] | None = None) -> int:
    """Run the rig; return the exit code: 0 at the end or when told to stop, 2 for bad input."""
    stopped = _Stop()
    code = ends_at_once("belt_rig", args, _USAGE)
    if code is not None:
        return code
    # The handlers of rclpy would raise out of whatever runs; these only leave word.
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    node: RigNode | None = None
    try:
        with joining():
            node = RigNode()
        node.play(stopped)
    except SettingsError as error:
        rclpy.logging.get_logger("belt_rig").fatal(str(error))
        return 2
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
        stopped.settle()
    return 0


if __name__ == "__main__":
    sys.exit(main())
