"""Whether the node keeps up with its input, and how far it is to pool what it cannot follow.

A node that is asked for more than its processor gives falls behind: its queue grows until messages
are dropped, and all that it says, alarms too, is as old as the queue is long. Pooled (`pooling`),
nearly all that the messages say is kept, for a fraction of the work. While a timer of the same
executor is overdue, it waits in the queue like all that came before it; once that may be so for
anything, such as a file that was written, but not for long.

Of rclpy's executors this is so of the one that hands out events in the order in which they came,
`EventsExecutor`; others let timers overtake messages, and nothing is noticed here.
"""

_OVERDUE = 0.05  # [s] that the timer may come late ...
_BEHIND = 0.1  # ... and that messages may come before it then, each time until more is pooled
_SHARES = (0.0, 1.0 / 9.0, 1.0 / 3.0, 1.0)  # of the longest time over which may be pooled
_PATIENCE = 10.0  # [s] of being in time after which less is pooled ...
_MOST_PATIENCE = 600.0  # ... at most, where less has been too little again and again
_SHOWS = 60.0  # [s] after which it shows that less was too little, at the latest


class KeepingUp:
    """Over what time the node has to pool, judged by messages that come before an overdue timer.

    Parameters
    ----------
    period : float
        Of the timer [s].
    longest : float
        Over which may be pooled at most [s]; 0: never.
    """

    def __init__(self, period: float, longest: float) -> None:
        self._period = period
        self._most = len(_SHARES) - 1 if longest > 0.0 else 0
        self._longest = longest
        self.begin()

    def begin(self) -> None:
        """Begin anew, with nothing pooled."""
        self._level = 0
        self._timer: float | None = None  # when it last came [s]
        self._heard = False  # a message, since then
        self._behind: float | None = None  # since when messages come before an overdue timer [s]
        self._in_time = 0.0  # [s] for which the timer has come in time, between messages
        self._lowered: float | None = None  # when less was pooled, last [s]
        self._patience = _PATIENCE

    @property
    def pool_period(self) -> float:
        """Over what time measurements are to be averaged, at least [s]."""
        return _SHARES[self._level] * self._longest

    def message(self, now: float) -> bool:
        """Hear of a message, at `now` [s] of a steady clock; whether `pool_period` has changed."""
        self._heard = True
        if self._timer is None or now - self._timer < self._period + _OVERDUE:
            return False
        if self._behind is None:
            self._behind = now
        if now - self._behind < _BEHIND:
            return False
        self._behind = now
        self._in_time = 0.0
        if self._level == self._most:
            return False
        if self._lowered is not None:
            soon = now - self._lowered < max(self._patience, _SHOWS)
            self._patience = min(2.0 * self._patience, _MOST_PATIENCE) if soon else _PATIENCE
            self._lowered = None
        self._level += 1
        return True

    def timer(self, now: float) -> bool:
        """Hear of the timer, at `now` [s] of the same clock; whether `pool_period` has changed."""
        last, self._timer, self._behind = self._timer, now, None
        heard, self._heard = self._heard, False
        if last is None or not heard or now - last > self._period + _OVERDUE:
            return False
        self._in_time += now - last
        if self._level == 0 or self._in_time < self._patience:
            return False
        self._in_time = 0.0
        self._lowered = now
        self._level -= 1
        return True
