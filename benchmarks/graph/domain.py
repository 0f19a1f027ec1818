"""A ROS domain that nobody else on this machine uses."""

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_DOMAINS = range(1, 101)  # above these, DDS ports meet those that Linux hands out by itself


@contextmanager
def own_domain() -> Iterator[dict[str, str]]:
    """Claim a domain, of which the tests know as well; yield the environment of its programs.

    Raises
    ------
    RuntimeError
        If every domain is taken.
    """
    for domain in _DOMAINS:
        lock = Path(tempfile.gettempdir()) / f"ros_domain_{domain}_{os.getuid()}.lock"
        with lock.open("w") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield _environment(domain)
            return
    raise RuntimeError("every ROS domain is taken")


def _environment(domain: int) -> dict[str, str]:
    """Return the environment of who runs the node: no checks that only tests switch on."""
    environment = {k: v for k, v in os.environ.items() if k != "ROS_PYTHON_CHECK_FIELDS"}
    return environment | {
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "PYTHONUNBUFFERED": "1",
    }
