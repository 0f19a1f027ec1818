"""Without ROS 2 there is nothing to play to."""

import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed")
pytest.importorskip("belt_msgs", reason="belt_msgs is not built")

sys.path.insert(0, str(Path(__file__).parents[1] / "node"))
