"""Fast input, pooled: what comes within some milliseconds is taken in as one, its mean.

A belt is far slower than the cycle of a servo drive. All that some milliseconds of white noise say
is in their mean (`span`), whose variance is that of one sample over their number; the filter's work
then grows with time, not with the number of messages.
"""

import math

from belt_ros.estimation.measurement import Measurement
from belt_ros.estimation.span import Span

_SECOND = 1e9
_AHEAD = 1.5  # intervals, so that jitter decides nothing
_TURN = 2.0 * math.pi


class Pool:
    """Means of consecutive measurements, in spans of `period` [s]; 0 hands on every one.

    A span ends with the last measurement to be expected in it, by the interval before, so that none
    waits for a message of the next. What comes at longer intervals passes untouched.

    Parameters
    ----------
    period : float
        Length of a span [s].
    turns : tuple of float
        One turn of either joint, seen at its pulley [rad]; angles wrap by it.
    """

    def __init__(self, period: float, turns: tuple[float, float] = (_TURN, _TURN)) -> None:
        self._span = Span(period, turns)
        self.retune(period)
        self._last_ns: int | None = None
        self._newest_ns: int | None = None  # of those that were pooled

    def retune(self, period: float) -> None:
        """Pool in spans of another `period` [s]; what has been pooled leaves with what follows."""
        self._span.period = period
        self._period_ns = round(period * _SECOND)

    def overtaken(self, stamp_ns: int) -> bool:
        """Whether a stamp is not later than the last one pooled, though perhaps than their mean."""
        newest_ns = self._newest_ns
        return newest_ns is not None and 0 <= newest_ns - stamp_ns < self._period_ns

    def take(self, measurement: Measurement) -> tuple[Measurement, ...]:
        """Take in a measurement; return what is to be handed on: nothing, a mean, or it untouched.

        Where time goes back, stands still or makes a gap, what has been pooled goes before it.
        """
        before, self._last_ns = self._last_ns, measurement.stamp_ns
        if before is None:
            return (measurement,)
        interval = measurement.stamp_ns - before
        if not 0 < interval < self._period_ns:
            return (*self.flush(), measurement)
        self._newest_ns = measurement.stamp_ns
        self._span.add(measurement)
        if measurement.stamp_ns + _AHEAD * interval <= self._span.first_ns + self._period_ns:
            return ()
        if self._span.count == 1:
            self._span.clear()
            return (measurement,)
        return (self._span.mean(),)

    @property
    def waiting(self) -> int:
        """How many measurements have been pooled and not handed on."""
        return self._span.pooled

    def flush(self) -> tuple[Measurement, ...]:
        """Return the mean of what has been pooled, if anything has."""
        return (self._span.mean(),) if self._span.count else ()
