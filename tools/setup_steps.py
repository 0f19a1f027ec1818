"""The steps of set-up: commands that run in the environment, with their output in a log."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
VENV_PYTHON = VENV / "bin" / "python"
LOG = VENV / "setup.log"
PATH_VARIABLES = ("AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH", "LD_LIBRARY_PATH", "PYTHONPATH")


class SetupError(Exception):
    """What went wrong, in words for the user."""


def venv_paths() -> dict[str, str]:
    """Return where the virtual environment keeps headers and modules."""
    scheme = "venv" if "venv" in sysconfig.get_scheme_names() else "posix_prefix"
    modules = sysconfig.get_path("purelib", scheme, {"base": str(VENV), "platbase": str(VENV)})
    return {"include": sysconfig.get_paths()["include"], "purelib": modules}


def child_environment() -> dict[str, str]:
    """Return the caller's environment without traces of another virtual environment or colcon."""
    environment = dict(os.environ)
    if environment.pop("_ROS_WHEELS_BOOTSTRAP_COMPLETE", None):
        for name in PATH_VARIABLES:
            environment.pop(name, None)
    for name in list(environment):
        if name.startswith(("COLCON_", "_BELT_ROS_")) or name in ("VIRTUAL_ENV", "PYTHONHOME"):
            del environment[name]
    # What a step imports is compiled once, for whoever imports it later.
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    environment["PATH"] = f"{VENV / 'bin'}{os.pathsep}{environment.get('PATH', os.defpath)}"
    return environment


def run_quietly(*command: str | Path) -> subprocess.CompletedProcess[str]:
    """Run a command for its answer."""
    arguments = [str(part) for part in command]
    environment = child_environment()
    return subprocess.run(arguments, env=environment, capture_output=True, text=True, check=False)


class Step:
    """A step that has begun, with its output in a log."""

    def __init__(self, name: str, *command: str | Path, log: Path = LOG) -> None:
        self._name = name
        self._log = log
        self._began = time.monotonic()
        arguments = [str(part) for part in command]
        with log.open("a") as output:
            output.write(f"\n$ {' '.join(arguments)}\n")
            output.flush()
            # A step that outlives a killed set-up keeps the lock that it inherits.
            self._process = subprocess.Popen(
                arguments,
                cwd=ROOT,
                env=child_environment(),
                stdout=output,
                stderr=subprocess.STDOUT,
                close_fds=False,
            )

    @property
    def ended(self) -> bool:
        """Whether it has come to its end, good or bad."""
        return self._process.poll() is not None

    def wait(self) -> None:
        """Show the step's name and how long it takes; raise SetupError where it fails."""
        moving = sys.stdout.isatty()
        print(f"  {self._name} ...", end="", flush=True)
        try:
            while self._process.poll() is None:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    self._process.wait(timeout=1.0)
                if moving:
                    print(f"\r  {self._name} ... {self._seconds()} s", end="", flush=True)
        except BaseException:
            self.stop()
            raise
        if self._process.returncode:
            print(" failed")
            last = self._log.read_text(errors="replace").splitlines()[-12:]
            advice = f"Step '{self._name}' failed. Full log: {self._log}"
            raise SetupError("\n".join([*last, "", advice]))
        print(f"\r  {self._name} ..." if moving else "", f"{self._seconds()} s")

    def stop(self) -> None:
        """End the step, done or not."""
        self._process.terminate()
        self._process.wait()

    def _seconds(self) -> int:
        return round(time.monotonic() - self._began)


def run_logged(name: str, *command: str | Path) -> None:
    """Run one step with its output in the log; show its name and how long it takes."""
    Step(name, *command).wait()
