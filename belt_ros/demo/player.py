"""Plays a bag's joint states to the graph, at the pace of the recording or of who listens."""

import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from belt_ros.drive_inputs import JOINT_STATE, feeds
from belt_ros.node_tables import InputKind
from belt_ros.replay.contents import Contents
from belt_ros.replay.discovery import find_joint_states
from belt_ros.settings import DriveSettings

_SECONDS = 1e-9
_MOST_WAITING = 100  # messages, half of what the node's input holds
_PATIENCE = 1.0  # [s] without any answer


class Player:
    """Publish serialised joint states of `bag` when they are due, from the first call on.

    A recording may be faster than the node: then it waits, so that nothing is lost. Messages that
    the node turns away are never answered, so it does not wait for ever.

    Parameters
    ----------
    bag : Path
    settings : DriveSettings
    publish : callable
        Takes a serialised joint state.
    answered : callable
        Returns how many have been answered so far.

    Raises
    ------
    BagError
        If the bag cannot be read.
    """

    def __init__(
        self,
        bag: Path,
        settings: DriveSettings,
        publish: Callable[[bytes], None],
        answered: Callable[[], int],
    ) -> None:
        self.sent = 0
        self._publish = publish
        self._answered = answered
        self._progress = (0, 0.0)  # answers, and when they last became more
        self._contents = Contents(bag)
        try:
            topic = _playable(self._contents, settings)
            self._messages = self._contents.messages({topic: JOINT_STATE})
            self._next = next(self._messages, None)
        except BaseException:
            self._contents.close()
            raise
        self._first_ns = 0 if self._next is None else self._next[1]
        self._begin: float | None = None

    def __enter__(self) -> "Player":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._contents.close()

    def play(self) -> bool:
        """Publish what is due; return whether there is more."""
        if self._begin is None:
            self._begin = time.monotonic()
        elapsed = time.monotonic() - self._begin
        while self._next is not None:
            _, log_ns, content = self._next
            if (log_ns - self._first_ns) * _SECONDS > elapsed or self._crowded():
                return True
            self._publish(content)
            self.sent += 1
            self._next = next(self._messages, None)
        return False

    def _crowded(self) -> bool:
        """Whether too many messages wait for an answer that may still come."""
        now = time.monotonic()
        answered = self._answered()
        if answered > self._progress[0] or self.sent == 0:
            self._progress = (answered, now)
        return self.sent - answered >= _MOST_WAITING and now - self._progress[1] < _PATIENCE


def _playable(contents: Contents, settings: DriveSettings) -> str:
    """Return the topic of the drive's joint states, defined as the graph defines them."""
    joints = settings.driver, settings.driven
    topic = find_joint_states(contents, joints, None)
    (feed,) = feeds(InputKind.JOINT_STATE, "", joints, loads=False)
    contents.reader(JOINT_STATE, feed.fields)
    return topic
