"""What `belt init` writes is what the live node starts from."""

import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed")
pytest.importorskip("belt_msgs", reason="belt_msgs is not built")
sys.path.insert(0, str(Path(__file__).parents[1] / "node"))

from node_harness import NodeProcess

from belt_ros.starter import answers_from, drive_yaml

pytestmark = pytest.mark.ros


def test_the_node_starts_from_it_and_listens(ros_domain: int, tmp_path: Path) -> None:
    answers = answers_from(
        {
            "name": "Förderer 1: links",
            "driver_radius": 0.08,
            "driven_radius": 0.12,
            "centre_distance": 1,
            "belt": "polyester-flat",
            "size": 0.05,
            "driver_inertia": 1,
            "driven_mass": 3,
            "driver_counts": 8192,
            "torque": "current",
            "torque_constant": 0.1,
            "input": "pulley_state",
        }
    )
    path = tmp_path / "drive.yaml"
    path.write_text(drive_yaml(answers), encoding="utf-8")
    with NodeProcess(ros_domain, tmp_path / "log", path) as node:
        node.wait_for_log("active, listening")
        assert "/driver/state" in node.log
        assert "Förderer 1: links" in node.log
