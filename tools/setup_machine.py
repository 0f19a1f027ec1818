"""What set-up finds on this machine, and what it misses there."""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import sys
import sysconfig
from pathlib import Path

from setup_steps import SetupError, run_quietly

OLDEST_PYTHON = (3, 10)
NEWEST_PYTHON_OF_WHEELS = (3, 14)
WHEELS = "wheels"


def base_python() -> str:
    """Return the interpreter behind an active virtual environment or a pyenv shim."""
    name = "python{}.{}".format(*sys.version_info)
    behind = Path(sys.base_prefix) / "bin" / name
    return str(behind) if behind.exists() else sys.executable


def sourced_distribution() -> str | None:
    """Return the name of the ROS 2 distribution that is sourced, if it is and works."""
    if not os.environ.get("AMENT_PREFIX_PATH"):
        return None
    distribution = os.environ.get("ROS_DISTRO")
    if distribution and run_quietly(base_python(), "-c", "import rclpy").returncode == 0:
        return distribution
    return None


def unsuitable_machine(ros: str) -> str | None:
    """Return what no package can mend: the wrong Python, system or processor."""
    python = sys.version_info[:2]
    here = f"{sys.executable} is {platform.python_version()}"
    if python < OLDEST_PYTHON:
        return "Python >= {}.{}; {} (choose with PYTHON=...)".format(*OLDEST_PYTHON, here)
    if ros != WHEELS:
        return None
    system = f"{platform.system()} {platform.machine()}"
    if system != "Linux x86_64":
        return f"ROS 2, sourced: its Python wheels are for Linux x86_64, not {system}"
    if python > NEWEST_PYTHON_OF_WHEELS:
        newest = "{}.{}".format(*NEWEST_PYTHON_OF_WHEELS)
        return f"Python <= {newest} for the ROS 2 wheels; {here} (choose with PYTHON=...)"
    return None


def missing_packages() -> dict[str, str]:
    """Return what is missing in words, each with the system package that brings it."""
    version = "{}.{}".format(*sys.version_info)
    # Debian's packages serve Debian's Python; another one is to be completed by its own means.
    package = f"python{version}" if sys.base_prefix == "/usr" else "python3"
    missing = {}
    if not importlib.util.find_spec("venv") or not importlib.util.find_spec("ensurepip"):
        missing[f"the venv module of Python {version}"] = f"{package}-venv"
    if not (Path(sysconfig.get_paths()["include"]) / "Python.h").exists():
        missing[f"the C headers of Python {version} (Python.h)"] = f"{package}-dev"
    if not shutil.which(os.environ.get("CXX") or "g++"):
        missing["a C++ compiler (g++)"] = "g++"
    return missing


def check_prerequisites(ros: str) -> None:
    """Raise SetupError naming what is missing, and how to install it."""
    unsuitable = unsuitable_machine(ros)
    if unsuitable:
        raise SetupError(f"Cannot set up belt_ros here. It needs {unsuitable}.")
    missing = missing_packages()
    if missing:
        names = "\n".join(f"  - {thing}" for thing in missing)
        install = f"sudo apt install {' '.join(missing.values())}"
        raise SetupError(f"Cannot set up belt_ros yet. Missing:\n{names}\nInstall:\n  {install}")
