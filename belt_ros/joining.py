"""Join the ROS graph so that the first answers of others are heard.

Fast DDS announces a participant before it listens (`RTPSParticipantImpl::enable`, still so in 3.6).
Whoever is there answers within some tenths of a millisecond, and once only; what comes before it
listens is lost. The newcomer then finds him by what he announces anyway, which is every three
seconds: neither hears the other until then. So a program that joins lets nothing run that would
take an answer before it listens. See docs/decisions.md for figures.
"""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from rclpy.node import Node

_TASKS = Path("/proc/self/task")
# Hidden, as all names that begin so; what follows __node:= is for another node.
_NAME = "_belt_ros_joins"


@contextmanager
def joining() -> Iterator[None]:
    """Join the graph, for who makes his nodes within, by which time others have been found.

    For the default context, after `rclpy.init`; all its nodes share one participant.
    """
    with undisturbed():
        node = Node(
            _NAME, use_global_arguments=False, enable_rosout=False, start_parameter_services=False
        )
    try:
        yield
    finally:
        node.destroy_node()


@contextmanager
def undisturbed() -> Iterator[None]:
    """Let threads that are begun within wait until this one does, or the end.

    They share one processor with it and may not interrupt it; afterwards all is as it was. Where a
    system does not know or allow that, nothing is changed.
    """
    before = _threads()
    try:
        processors, policy = os.sched_getaffinity(0), os.sched_getscheduler(0)
        priority, patient = os.sched_getparam(0), os.SCHED_BATCH
    except (AttributeError, OSError):  # not Linux
        yield
        return
    try:
        with suppress(OSError):  # a container may forbid it
            # By the process, so that those that start together do not meet on one.
            os.sched_setaffinity(0, {sorted(processors)[os.getpid() % len(processors)]})
            if policy == os.SCHED_OTHER:
                os.sched_setscheduler(0, patient, priority)
        yield
    finally:
        for thread in (_threads() - before) | {threading.get_native_id()}:
            with suppress(OSError):  # it has ended meanwhile
                os.sched_setaffinity(thread, processors)
                os.sched_setscheduler(thread, policy, priority)


def _threads() -> set[int]:
    """Return the ids of this process's threads, as far as the system tells."""
    try:
        return {int(task.name) for task in _TASKS.iterdir()}
    except OSError:
        return set()
