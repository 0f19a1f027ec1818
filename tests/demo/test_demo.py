"""The demonstration as a user runs it, on the bag that the project ships."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed")
pytest.importorskip("belt_msgs", reason="belt_msgs is not built")

from belt_ros.demo.main import _prepare

ROOT = Path(__file__).resolve().parents[2]
BAG = ROOT / "tests" / "data" / "rig_bag"


def belt_demo(domain: int, where: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "belt_ros.cli", "demo", *arguments],
        cwd=where,
        env={**os.environ, "ROS_DOMAIN_ID": str(domain), "COLUMNS": "120"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )


def test_a_bag_is_played_shown_recorded_and_drawn(ros_domain: int, tmp_path: Path) -> None:
    config = ROOT / "config" / "paper_drive.yaml"
    done = belt_demo(ros_domain, tmp_path, "--bag", str(BAG), "--config", str(config))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "701 states for 701 joint states" in done.stdout
    assert "margin" in done.stdout
    assert (tmp_path / "belt_demo" / "bag" / "metadata.yaml").is_file()
    assert (tmp_path / "belt_demo" / "demo.png").stat().st_size > 20_000


def test_a_bag_without_its_drive_is_refused_in_one_line(ros_domain: int, tmp_path: Path) -> None:
    done = belt_demo(ros_domain, tmp_path, "--bag", str(BAG))
    assert done.returncode == 1
    assert "CONFIG=" in done.stdout
    assert "Traceback" not in done.stdout + done.stderr


def test_a_directory_of_the_users_is_not_overwritten(ros_domain: int, tmp_path: Path) -> None:
    (tmp_path / "belt_demo").mkdir()
    (tmp_path / "belt_demo" / "thesis.txt").write_text("mine")
    done = belt_demo(ros_domain, tmp_path)
    assert done.returncode == 1
    assert (tmp_path / "belt_demo" / "thesis.txt").read_text() == "mine"


def test_what_a_demonstration_left_that_was_ended_at_once_is_replaced(tmp_path: Path) -> None:
    output = tmp_path / "belt_demo"
    for name in ("first", "second"):
        _prepare(output)  # and is ended before any process of its own has begun
        (output / name).touch()
    assert not (output / "first").exists()
