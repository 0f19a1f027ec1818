"""The profile for a node that is started again: Fast DDS does not wait for the one killed."""

import os
import subprocess
import sys
import time

import pytest
import rclpy
from node_harness import ROOT
from rclpy.context import Context

pytestmark = pytest.mark.ros
PROFILE = ROOT / "config" / "fastdds_respawn.xml"
PATIENCE = 20.0  # [s] to start and to be found
FORGOTTEN = 5.0  # [s]; by its default, Fast DDS waits for 20
PUBLISHER = """
import rclpy, time
from std_msgs.msg import Empty
rclpy.init()
node = rclpy.create_node("publisher")
publisher = node.create_publisher(Empty, "topic", 1)
time.sleep(60.0)
"""


def test_a_killed_process_is_forgotten_before_it_is_back(ros_domain: int) -> None:
    context = Context()
    rclpy.init(context=context, domain_id=ros_domain)
    listener = rclpy.create_node("listener", context=context)

    def await_count(publishers: int, patience: float) -> None:
        began = time.monotonic()
        while listener.count_publishers("topic") != publishers:
            assert time.monotonic() < began + patience, f"{publishers} publishers are not seen"
            time.sleep(0.02)

    domain = {"ROS_DOMAIN_ID": str(ros_domain), "FASTDDS_DEFAULT_PROFILES_FILE": str(PROFILE)}
    process = subprocess.Popen([sys.executable, "-c", PUBLISHER], env={**os.environ, **domain})
    try:
        await_count(1, PATIENCE)
        process.kill()
        await_count(0, FORGOTTEN)
    finally:
        process.kill()
        process.wait()
        listener.destroy_node()
        rclpy.shutdown(context=context)
