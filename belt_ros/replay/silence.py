"""That nothing usable comes, noticed when it has lasted too long, not only when it is over.

The live node asks its clock ten times a second. In a bag log time passes from one message to the
next, and the moment at which a clock would have told lies between them.
"""

import math
from typing import NamedTuple

from belt_ros.estimation import AlarmStatus, BeltMonitor, Measurement, Rejection
from belt_ros.replay.drive_bag import Sample

_SECONDS = 1e-9


class Silent(NamedTuple):
    """At a log time [ns], silence has changed the alarms."""

    log_ns: int
    alarm: AlarmStatus


class Silence:
    """Tells the monitor of silence.

    Stamps may be on another clock than the log: times told to the monitor go on from the stamp of
    the last measurement that was used.

    Attributes
    ----------
    too_long : bool
        Whether nothing usable had come for too long when `before` was last asked.
    """

    def __init__(self, monitor: BeltMonitor) -> None:
        self.too_long = False
        self._monitor = monitor
        self._used_ns: int | None = None  # log time from when on nothing usable has come
        self._heard_ns = 0
        self._latency_ns = 0  # of the last measurement that was used

    def before(self, log_ns: int) -> Silent | None:
        """Return what silence has changed before something is logged at `log_ns`, if anything."""
        if self._used_ns is None or log_ns < self._heard_ns:
            self._used_ns = log_ns
        self._heard_ns = log_ns
        told_ns = self._used_ns + math.ceil(self._monitor.longest_silence / _SECONDS) + 1
        self.too_long = told_ns < log_ns
        if not self.too_long:
            return None
        silence = (told_ns - self._used_ns) * _SECONDS
        alarm = self._monitor.silent(self.stamp_at(told_ns), silence)
        return None if alarm is None else Silent(told_ns, alarm)

    def take(self, sample: Sample, reason: Rejection) -> None:
        """Hear what became of a sample."""
        if reason is Rejection.NONE and isinstance(sample.content, Measurement):
            self._used_ns = sample.log_ns
            self._latency_ns = sample.log_ns - sample.content.stamp_ns

    def stamp_at(self, log_ns: int) -> int:
        """Return what the clock of the stamps shows at a log time [ns]."""
        return log_ns - self._latency_ns
