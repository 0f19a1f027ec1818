"""Fixtures of the node's tests; without ROS 2 there is nothing to test here."""

from collections.abc import Iterator

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed")
pytest.importorskip("belt_msgs", reason="belt_msgs is not built")

from node_harness import Client


@pytest.fixture
def client(ros_domain: int) -> Iterator[Client]:
    client = Client(ros_domain)
    yield client
    client.close()
