"""The alarms' status of one drive as it is told, also by what no measurement has changed."""

import dataclasses

from belt_ros.estimation import AlarmStatus, BeltMonitor, Condition, Severity
from belt_ros.node.unwatched import unwatched_alarm


class ToldAlarm:
    """Knows what was last told of the alarms of `monitor`."""

    def __init__(self, monitor: BeltMonitor) -> None:
        self._monitor = monitor
        self._status: AlarmStatus | None = None
        self._watched = True  # as last told

    @property
    def status(self) -> AlarmStatus | None:
        """The present status of the alarms; None before anything is told."""
        return self._status

    def change(self, status: AlarmStatus | None) -> bool:
        """Take note of what is told now, if anything; return whether it is worse than before."""
        if status is None:
            return False
        before = Severity.NORMAL if self._status is None else self._status.severity
        self._status, self._watched = status, True
        return status.severity > before

    def again(self) -> AlarmStatus | None:
        """Return the status, for there is an estimate, if the last told is that nobody watches."""
        if not self._watched:
            self.change(self._monitor.acknowledge(Condition.NONE))  # releases nothing, but tells
            return self._status
        return None

    def unwatch(self, now_ns: int) -> AlarmStatus | None:
        """Return what to tell while nobody watches from `now_ns` [ns] on; None: there is nothing.

        Where nothing was told yet, nobody takes the belt for watched.
        """
        self._watched = self._status is None
        return self._as_watched(now_ns)

    def _as_watched(self, now_ns: int) -> AlarmStatus | None:
        if self._status is None or self._watched:
            return self._status
        return unwatched_alarm(self._monitor.name, self._status, now_ns)

    def acknowledge(self, now_ns: int) -> AlarmStatus | None:
        """Release all latches; return what to tell at `now_ns` [ns], None if that is nothing."""
        status = self._monitor.acknowledge()
        if status is None:
            return None
        self._status = status
        return self._as_watched(now_ns)

    def take_back(self, now_ns: int) -> AlarmStatus | None:
        """Return what to tell after a reset at `now_ns` [ns]; None if there is nothing to forget.

        It has no number of before.
        """
        if self._status is None:
            return None
        status = self._monitor.alarm.acknowledge(None)  # of what there is nothing any more
        message = f"{self._monitor.name}: no alarm condition; estimation was started anew"
        self.change(dataclasses.replace(status, stamp_ns=now_ns, message=message))
        return self._status
