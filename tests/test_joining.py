"""A program joins the ROS graph so that it hears who answers at once, and leaves no trace of it."""

import os
import subprocess
import sys
import threading
from collections.abc import Iterator

import pytest

pytest.importorskip("rclpy")
from belt_ros.joining import undisturbed

pytestmark = pytest.mark.skipif(not hasattr(os, "SCHED_BATCH"), reason="no Linux")

# How many threads a program has, of what kinds: as it joins, has joined, and has a node.
PROGRAM = """
import os
import rclpy
from belt_ros import joining

def tell():
    tasks = [int(name) for name in os.listdir("/proc/self/task")]
    kinds = {(len(os.sched_getaffinity(each)), os.sched_getscheduler(each)) for each in tasks}
    print(len(tasks), sorted(kinds), sep=";")

class Node(joining.Node):
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        tell()

joining.Node = Node
rclpy.init()
with joining.joining():
    tell()
    node = rclpy.create_node("belt_node")
tell()
print(node.get_node_names())
"""


@pytest.fixture
def waiting() -> Iterator[int]:
    """Id of a thread that has been there before."""
    begun, over = threading.Event(), threading.Event()
    thread = threading.Thread(target=lambda: (begun.set(), over.wait()))
    thread.start()
    begun.wait()
    assert thread.native_id is not None
    yield thread.native_id
    over.set()
    thread.join()


def kind(thread: int) -> tuple[set[int], int]:
    return os.sched_getaffinity(thread), os.sched_getscheduler(thread)


def test_threads_begun_within_share_a_processor_and_do_not_interrupt(waiting: int) -> None:
    before = kind(0)
    over = threading.Event()
    with undisturbed():
        thread = threading.Thread(target=over.wait)
        thread.start()
        assert thread.native_id is not None
        within, own = kind(thread.native_id), kind(0)
        assert kind(waiting) == before
    after = kind(thread.native_id)
    over.set()
    thread.join()
    assert within == own
    assert len(within[0]) == 1
    assert within[1] == os.SCHED_BATCH
    assert after == kind(0) == before


def test_all_is_as_before_when_something_goes_wrong() -> None:
    before = kind(0)
    with pytest.raises(RuntimeError), undisturbed():
        raise RuntimeError
    assert kind(0) == before


@pytest.mark.parametrize("forbidden", ["sched_setaffinity", "sched_setscheduler"])
def test_where_it_is_forbidden_a_program_joins_as_any(forbidden: str, monkeypatch) -> None:
    def refuse(*_arguments: object) -> None:
        raise PermissionError

    before = kind(0)
    allowed = getattr(os, forbidden)
    monkeypatch.setattr(os, forbidden, refuse)
    with undisturbed():
        monkeypatch.setattr(os, forbidden, allowed)
    assert kind(0) == before


def test_where_it_is_unknown_a_program_joins_as_any(monkeypatch) -> None:
    before = kind(0)
    monkeypatch.delattr(os, "sched_getaffinity")
    with undisturbed():
        pass
    monkeypatch.undo()
    assert kind(0) == before


def told_by(domain: int) -> list[str]:
    result = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env={**os.environ, "ROS_DOMAIN_ID": str(domain)},
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    return result.stdout.splitlines()


@pytest.mark.ros
def test_a_node_has_the_participant_that_joined_and_free_threads(ros_domain: int) -> None:
    *told, names = told_by(ros_domain)
    counts, kinds = zip(*(line.split(";") for line in told), strict=True)
    assert len(set(counts)) == 1  # a second participant would have threads of its own
    own = f"({len(os.sched_getaffinity(0))}, {os.SCHED_OTHER})"
    assert f"(1, {os.SCHED_BATCH})" in kinds[0]
    assert kinds[1] == kinds[2] == f"[{own}]"
    assert names == "['belt_node']"
