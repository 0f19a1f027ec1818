"""Install packages: by uv, in a sixth of pip's time, or by pip where uv does not do."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from setup_machine import WHEELS
from setup_steps import ROOT, VENV, VENV_PYTHON, SetupError, run_logged, run_quietly

if TYPE_CHECKING:
    from pathlib import Path

TOOLS = ROOT / "tools"
ANOTHER_INDEX = re.compile(r"\.(index-url|no-index)=")  # an extra one may still be needed: by pip
UV = VENV / "bin" / "uv"


def requirements(ros: str) -> list[Path]:
    """Return the files that name what is installed beside belt_ros and what it needs."""
    files = [TOOLS / "requirements-build.txt"]
    return files + ([TOOLS / "requirements-ros.txt"] if ros == WHEELS else [])


def pip_install(ros: str) -> list[str | Path]:
    """Return the command that installs, with what it may not change where ROS 2 is sourced."""
    command: list[str | Path]
    command = [VENV_PYTHON, "-m", "pip", "install", "--disable-pip-version-check", "--no-input"]
    # Less than half of all modules are ever imported; those are compiled then.
    command += ["--no-compile"]
    if ros != WHEELS:
        # The messages of the installation were compiled for its numpy, and run with no other.
        constraints = VENV / "constraints.txt"
        numpy = run_quietly(VENV_PYTHON, "-c", "import numpy; print(numpy.__version__)")
        constraints.write_text(f"numpy=={numpy.stdout.strip()}\n" if numpy.returncode == 0 else "")
        command += ["-c", constraints]
    return command


def uv_may_install(ros: str) -> bool:
    """Whether uv is to be tried: it sees no sourced ROS 2, and asks no index that pip is told."""
    if ros != WHEELS:
        return False
    configured = run_quietly(VENV_PYTHON, "-m", "pip", "config", "list")
    return configured.returncode == 0 and not ANOTHER_INDEX.search(configured.stdout)


def install_packages(ros: str) -> None:
    """Install belt_ros in editable form, with all it needs, ROS 2 wheels, and tools."""
    what: list[str | Path] = [part for file in requirements(ros) for part in ("-r", file)]
    what += ["-e", ".[dev]"]
    name = "belt_ros, ROS 2 and tools" if ros == WHEELS else f"belt_ros beside ROS 2 {ros}"
    if uv_may_install(ros):
        try:
            run_logged("uv", *pip_install(ros), "uv")
            # Copies, for set-up repairs some files, which are not to change in uv's cache.
            uv = (UV, "pip", "install", "--python", VENV_PYTHON, "--link-mode", "copy")
            run_logged(name, *uv, *what)
        except SetupError as error:
            print(error, "pip tries as well.", sep="\n")
        else:
            return
    run_logged(f"{name}, by pip", *pip_install(ros), *what)
