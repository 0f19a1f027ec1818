"""What all tests share: a ROS domain of their own, on this machine only."""

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import hypothesis
import pytest

# Read when rclpy starts and when message classes are imported, so set before either.
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ["ROS_PYTHON_CHECK_FIELDS"] = "1"

# Read when numpy is imported. Tests run side by side already; threads for matrices of a few dozen
# rows wait for each other more than they compute (measured: tests of natural modes took twice the
# processor time).
os.environ["OPENBLAS_NUM_THREADS"] = "1"

# The same examples every time: what fails here fails everywhere.
hypothesis.settings.register_profile("repeatable", derandomize=True)
hypothesis.settings.load_profile("repeatable")

# Files whose tests take seconds each, for they play in real time or simulate minutes. They come
# first, those that wait beside those that compute, so that no worker ends long after the others.
_LONG = (
    "test_fault_suite",
    "test_estimation_slice",
    "test_steady_load",
    "test_rig_outputs",
    "test_cluster",
    "test_kept_memory",
    "test_load_sensors_in_filter",
    "test_positions_in_filter",
    "test_missing_speed_in_filter",
    "test_play",
    "test_running_fleet",
    "test_several_drives",
    "test_estimation_life",
    "test_demo",
    "test_process",
    "test_monitor_life",
    "test_rig_node",
    "test_lifecycle",
    "test_alarm_hours",
    "test_with_rig",
)

_DOMAINS = range(1, 101)  # above these, DDS ports meet those that Linux hands out by itself


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    places = {name: place for place, name in enumerate(_LONG)}
    items.sort(key=lambda item: places.get(item.path.stem, len(places)))


@contextmanager
def claimed_domain() -> Iterator[int]:
    """Claim a ROS domain that no other test on this machine uses, in whatever process."""
    for domain in _DOMAINS:
        lock = Path(tempfile.gettempdir()) / f"ros_domain_{domain}_{os.getuid()}.lock"
        with lock.open("w") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield domain
            return
    pytest.fail("every ROS domain is taken")


@pytest.fixture
def ros_domain() -> Iterator[int]:
    with claimed_domain() as domain:
        yield domain


@pytest.fixture(scope="module")
def module_ros_domain() -> Iterator[int]:
    with claimed_domain() as domain:
        yield domain
