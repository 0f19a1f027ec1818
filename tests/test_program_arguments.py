"""The programs that are ROS 2 nodes say how they are used, and start for nothing else."""

import subprocess
import sys

import pytest

PROGRAMS = pytest.mark.parametrize("program", ["node", "rig"])


def run(program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", f"belt_ros.{program}.main", *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


@PROGRAMS
@pytest.mark.parametrize("flag", ["--help", "-h"])
def test_help_says_how_it_is_used(program: str, flag: str) -> None:
    result = run(program, flag)
    assert result.returncode == 0
    assert result.stdout.startswith(f"usage: belt_{program} --ros-args -")
    assert result.stderr == ""


@PROGRAMS
def test_what_is_unknown_is_named_and_starts_nothing(program: str) -> None:
    result = run(program, "--ros-args", "-p", "a:=1", "--", "--rate", "5")
    assert result.returncode == 2
    assert f"belt_{program}: --rate is unknown" in result.stderr
    assert "Traceback" not in result.stderr


@PROGRAMS
@pytest.mark.parametrize("words", [("--params-file", "/nowhere.yaml"), ("-p", "bad")])
def test_what_ros_does_not_understand_is_said_in_a_line(program: str, words: list[str]) -> None:
    result = run(program, "--ros-args", *words)
    assert result.returncode == 1
    assert f"belt_{program}: Failed to parse ROS arguments" in result.stderr
    assert words[1] in result.stderr
    assert "Traceback" not in result.stderr
