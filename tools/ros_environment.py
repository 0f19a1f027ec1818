"""Set what sourcing ROS 2 would set, at the start of the virtual environment's Python.

`setup_environment.py` copies this module into `.venv`, where a .pth file imports it, and records
the variables beside it. The dynamic linker reads LD_LIBRARY_PATH only when a process starts, so
Python is started once more where a variable was incomplete.
"""

import json
import os
import sys

# Names the environment last completed, so that a variable that will not stay cannot loop.
_GUARD = "_BELT_ROS_ENVIRONMENT"


def completed(environment: "dict[str, str]", recorded: "dict[str, list[str]]") -> "dict[str, str]":
    """Return the environment with the recorded entries that it lacks put in front.

    Parameters
    ----------
    environment
        Variables as they are.
    recorded
        Entries that each variable must hold, in order.

    """
    result = dict(environment)
    for name, wanted in recorded.items():
        if name in environment and not name.endswith("PATH"):
            continue
        present = [entry for entry in environment.get(name, "").split(os.pathsep) if entry]
        lacking = [entry for entry in wanted if entry not in present]
        if lacking:
            result[name] = os.pathsep.join(lacking + present)
    return result


def _activate() -> None:
    with open(os.path.join(sys.prefix, "ros_environment.json"), encoding="utf-8") as file:
        environment = completed(dict(os.environ), json.load(file))
    if environment != dict(os.environ) and os.environ.get(_GUARD) != sys.prefix:
        environment[_GUARD] = sys.prefix
        os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], environment)


if os.path.exists(os.path.join(sys.prefix, "ros_environment.json")):
    _activate()
