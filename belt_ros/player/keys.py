"""The space bar of a terminal; where there is no terminal, no key is ever pressed.

Nor is one while the terminal belongs to others, as to a shell that has put this program into the
background: who touches its settings there, or reads from it, is stopped by the system.
"""

import os
import select
import sys
import termios
import tty
from types import TracebackType
from typing import Any

_MOST = 256  # keys at once


class Keys:
    """Single key presses, as long as this context lasts."""

    def __init__(self) -> None:
        self._terminal = sys.stdin.fileno() if sys.stdin and sys.stdin.isatty() else None
        if not self._ours:
            self._terminal = None
        self._before: list[Any] = []

    def __enter__(self) -> "Keys":
        if self._terminal is not None:
            self._before = termios.tcgetattr(self._terminal)
            tty.setcbreak(self._terminal)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._terminal is not None and self._ours:
            termios.tcsetattr(self._terminal, termios.TCSADRAIN, self._before)

    @property
    def _ours(self) -> bool:
        """Whether the terminal, if there is one, listens to this program."""
        if self._terminal is None:
            return False
        try:
            return os.tcgetpgrp(self._terminal) == os.getpgrp()
        except OSError:  # it is not the one that stops and wakes this program
            return True

    @property
    def there(self) -> bool:
        """Whether there is anyone to press one."""
        return self._terminal is not None

    def space(self) -> bool:
        """Whether the space bar was pressed since the last call; other keys are ignored."""
        if self._terminal is None or not self._ours:
            return False
        if not select.select([self._terminal], [], [], 0.0)[0]:
            return False
        return os.read(self._terminal, _MOST).count(b" ") % 2 == 1
