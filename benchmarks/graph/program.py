"""A program in a process of its own, and what it costs."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from types import FrameType, TracebackType

ROOT = Path(__file__).resolve().parents[2]
_PATIENCE = 20.0  # [s] for a process to end after SIGINT
_NOTICING = 0.01  # [s]


_running: set["Program"] = set()


class ProgramError(RuntimeError):
    """A program ended, or did not come to the point, before it should."""


def processor_ns(pid: int) -> int:
    """Return the processor time [ns] that a process has used, by Linux's clock of that process."""
    return time.clock_gettime_ns((~pid << 3) | 2)


def resident_bytes(pid: int) -> int:
    """Return the memory [B] that a process holds in RAM."""
    for line in Path(f"/proc/{pid}/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) * 1024
    raise ProgramError(f"process {pid} holds no memory any more")


def die_together() -> None:
    """Let SIGTERM end what runs, too: what is left over in a ROS domain spoils who comes next."""

    def end(signum: int, frame: FrameType | None) -> None:
        del frame
        for program in tuple(_running):
            program.kill()
        os._exit(128 + signum)

    signal.signal(signal.SIGTERM, end)


class Program:
    """`python -m module arguments`, its output in a log file. As a context: stopped at the end."""

    def __init__(
        self, module: str, log: Path, environment: Mapping[str, str], *arguments: str
    ) -> None:
        self._module = module
        self._log = log
        with log.open("w", encoding="utf-8") as file:
            self._process = subprocess.Popen(
                [sys.executable, "-m", module, *arguments],
                stdout=file,
                stderr=subprocess.STDOUT,
                stdin=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C is the benchmark's, which then ends the others
                cwd=ROOT,
                env=dict(environment),
            )
        _running.add(self)

    def __enter__(self) -> "Program":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.stop()

    @property
    def pid(self) -> int:
        """Number of its process."""
        return self._process.pid

    @property
    def alive(self) -> bool:
        """Whether it runs."""
        return self._process.poll() is None

    @property
    def log(self) -> str:
        """What it has said so far."""
        return self._log.read_text(encoding="utf-8", errors="replace")

    def wait_for(self, text: str, timeout: float = 120.0) -> None:
        """Wait until it says `text`.

        Raises
        ------
        ProgramError
            If it ends before, or takes longer than `timeout` [s].
        """
        end = time.monotonic() + timeout
        while text not in self.log:
            if not self.alive or time.monotonic() > end:
                raise ProgramError(f"{self._module}: no {text!r} in\n{self.log}")
            time.sleep(_NOTICING)

    def wait(self, timeout: float) -> None:
        """Wait until it has ended by itself, well.

        Raises
        ------
        ProgramError
            If it failed, or takes longer than `timeout` [s].
        """
        try:
            code = self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            code = None
        if code != 0:
            raise ProgramError(f"{self._module} ended with {code}:\n{self.log}")

    def kill(self) -> None:
        """End it as a loss of power would."""
        self._process.kill()
        self._process.wait()

    def stop(self) -> None:
        """Interrupt it and wait."""
        _running.discard(self)
        if self.alive:
            self._process.send_signal(signal.SIGINT)
            try:
                self._process.wait(_PATIENCE)
            except subprocess.TimeoutExpired:
                self.kill()
