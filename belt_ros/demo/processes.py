"""The demonstration's other processes: the node, and the rig where no bag is played."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from types import TracebackType

_PATIENCE = 5.0  # [s] for a process to end after SIGINT


class Process:
    """A program of this package in a process of its own, its output in a log file.

    Used as a context: it is interrupted on leaving, and killed if that does not help.
    """

    def __init__(self, module: str, log: Path, *arguments: str) -> None:
        self.log = log
        self._file = log.open("wb")
        # A session of its own: Ctrl-C is the demonstration's, which then ends the others.
        self._process = subprocess.Popen(
            [sys.executable, "-m", module, "--ros-args", *arguments],
            stdout=self._file,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
        )

    def __enter__(self) -> "Process":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.stop()

    @property
    def exit_code(self) -> int | None:
        """Its exit code, None while it runs."""
        return self._process.poll()

    def stop(self) -> None:
        """Interrupt it and wait."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
            try:
                self._process.wait(_PATIENCE)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._file.close()

    def last_words(self, lines: int = 5) -> str:
        """Return the end of its log."""
        text = self.log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
        return "\n".join(text[-lines:])
