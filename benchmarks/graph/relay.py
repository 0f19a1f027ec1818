"""Program that answers each joint state with a belt state of which only the stamp is new.

The bare cost of taking a message in and giving one out, by the node's executor and in its language.
"""

import signal
import sys
import threading

import rclpy
from belt_msgs.msg import BeltState
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState

from belt_ros.node.main import make_executor

TOPICS = ("relay/joint_states", "relay/state")


def main(depth: int) -> None:
    """Relay until interrupted."""
    stopping = threading.Event()
    signal.signal(signal.SIGINT, lambda *_: stopping.set())
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("relay")
    answer = BeltState(drive_name="paper_drive")
    publisher = node.create_publisher(BeltState, TOPICS[1], QoSProfile(depth=depth))

    def relay(message: JointState) -> None:
        answer.header.stamp = message.header.stamp
        publisher.publish(answer)

    node.create_subscription(JointState, TOPICS[0], relay, QoSProfile(depth=depth))
    executor = make_executor()
    executor.add_node(node)
    sys.stdout.write("ready\n")
    while not stopping.is_set():
        executor.spin_once(timeout_sec=0.1)
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main(int(sys.argv[1]))
