"""Plays a bag's joint states to the graph, at the pace at which they were recorded."""

import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from belt_ros.replay import JointStateBag
from belt_ros.settings import DriveSettings

_SECONDS = 1e-9


class Player:
    """Publish serialised joint states of `bag` when they are due, from the first call on.

    Raises
    ------
    BagError
        If the bag cannot be read.
    """

    def __init__(
        self, bag: Path, settings: DriveSettings, publish: Callable[[bytes], None]
    ) -> None:
        self.sent = 0
        self._publish = publish
        self._source = JointStateBag(bag, settings.driver, settings.driven)
        self._messages = self._source.serialised()
        self._next = next(self._messages, None)
        self._first_ns = 0 if self._next is None else self._next[0]
        self._begin: float | None = None

    def __enter__(self) -> "Player":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._source.close()

    def play(self) -> bool:
        """Publish what is due; return whether there is more."""
        if self._begin is None:
            self._begin = time.monotonic()
        elapsed = time.monotonic() - self._begin
        while self._next is not None:
            log_ns, content = self._next
            if (log_ns - self._first_ns) * _SECONDS > elapsed:
                return True
            self._publish(content)
            self.sent += 1
            self._next = next(self._messages, None)
        return False
