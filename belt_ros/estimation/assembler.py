"""Samples of several sources, at different rates and out of order, made one row of measurements.

Knows no clock: how long anything waits is counted in stamps. Each source has a watermark, the stamp
before which nothing more is to come of it: the newest it has sent, less the disorder allowed. What
all watermarks have passed is complete and leaves at once; what one source holds up leaves when
stamps have moved on by the window (the watermarks of Akidau et al. 2015, 10.14778/2824032.2824076,
with a timeout for sources that are idle).
"""

import math
from bisect import insort
from collections.abc import Sequence
from operator import attrgetter
from typing import NamedTuple

from belt_ros.estimation.measurement import Measurement, Sensor

_NANOSECONDS = 1e9
_stamp = attrgetter("stamp_ns")
_values = attrgetter(*(sensor.name.lower() for sensor in Sensor))


class Dropped(NamedTuple):
    """A sample that came too late, or from a stretch of time that nothing followed."""

    source: int
    stamp_ns: int


def joined(first: Measurement, other: Measurement) -> Measurement | None:
    """Return what both measured, with the stamp of `first`; None if they measured the same."""
    pairs = [(a, b, math.isnan(a)) for a, b in zip(_values(first), _values(other), strict=True)]
    if any(not (missing or math.isnan(b)) for _, b, missing in pairs):
        return None
    return Measurement(first.stamp_ns, *(b if missing else a for a, b, missing in pairs))


class _Stretch:
    """Samples of a stretch of time without a jump: a queue by stamp for each source."""

    def __init__(self, sources: int, stamp_ns: int) -> None:
        self.queues: list[list[Measurement]] = [[] for _ in range(sources)]
        self.heard: list[int | None] = [None] * sources  # the newest stamp of each
        self.oldest = self.newest = stamp_ns
        self.pending = 0

    def add(self, source: int, sample: Measurement) -> None:
        stamp_ns = sample.stamp_ns
        heard = self.heard[source]
        if heard is None or stamp_ns >= heard:
            self.heard[source] = stamp_ns
            self.queues[source].append(sample)
        else:
            insort(self.queues[source], sample, key=_stamp)
        self.oldest = min(self.oldest, stamp_ns)
        self.newest = max(self.newest, stamp_ns)
        self.pending += 1

    def head(self) -> int:
        """Return the earliest stamp that is pending."""
        return min(queue[0].stamp_ns for queue in self.queues if queue)

    def take(self, slop: int) -> Measurement:
        """Remove the earliest sample, joined with what others say within `slop` [ns] of it.

        The result has the earliest stamp, which is one that a sensor gave: a later one, or a mean,
        would overtake samples in between that cannot be joined.
        """
        reach = self.head() + slop
        near = [
            (queue[0].stamp_ns, source)
            for source, queue in enumerate(self.queues)
            if queue and queue[0].stamp_ns <= reach
        ]
        near.sort()
        result = self._pop(near[0][1])
        for _, source in near[1:]:
            both = joined(result, self.queues[source][0])
            if both is not None:
                self._pop(source)
                result = both
        return result

    def _pop(self, source: int) -> Measurement:
        self.pending -= 1
        return self.queues[source].pop(0)

    def live(self, source: int, gap: int) -> bool:
        """Whether a source has been heard within `gap` [ns], or may still be in its first."""
        heard = self.heard[source]
        return self.newest - (self.oldest if heard is None else heard) <= gap

    def drain(self, slop: int) -> list[Measurement]:
        """Remove everything, in order."""
        drained = []
        while self.pending:
            drained.append(self.take(slop))
        return drained

    def dropped(self) -> list[Dropped]:
        """Return all that is pending as dropped."""
        return [
            Dropped(source, sample.stamp_ns)
            for source, queue in enumerate(self.queues)
            for sample in queue
        ]


class Assembler:
    """Put samples of several sources in the order of their stamps, and join those of one instant.

    A sample waits until every live source has been heard at or past it, but no longer than `window`
    of stamps. Then it leaves, joined with samples of other sources that are stamped at most `slop`
    later and measured something else. What is older than what has left is dropped.

    Stamps farther than `gap` from the newest are a stretch of their own, e.g. of a bag that begins
    again. They are held until every live source has gone there, or until they span more than the
    window while nothing came from where time was. Then all from before the jump leaves, and time
    goes on there, forwards or backwards; who takes the measurements sees the jump. If anything does
    come from where time was, they are dropped, as one wild stamp, or a source whose clock is wrong.

    A single source without disorder is passed through as it is: who takes its measurements knows
    what to make of stamps that do not follow.

    In what order samples arrive makes no difference, as long as those of one source are less than
    `disorder` out of order, and those of two sources less than `window` - `slop`; no source is
    silent for `gap` - `window`; and no more than `most` wait.

    Parameters
    ----------
    window : float
        How long a sample waits for other sources [s]. Taken to be no less than `disorder`.
    slop : float
        Stamps of one instant may differ by this [s]. A speed is then wrong by what it changes in
        that time.
    sources : int
        Their number.
    most : int
        How many samples may wait.
    disorder : float
        By how much stamps of one source may be out of order [s]. Every sample waits that long.
    gap : float
        A source silent for longer than this [s] is not waited for; stamps that jump by more are a
        jump. Taken to be no less than `window`.

    Raises
    ------
    ValueError
        If a time is negative or not finite, or a number not positive.
    """

    def __init__(
        self,
        window: float,
        slop: float,
        sources: int,
        most: int,
        disorder: float = 0.0,
        gap: float = 1.0,
    ) -> None:
        if not all(math.isfinite(time) and time >= 0.0 for time in (window, slop, disorder, gap)):
            raise ValueError("window, slop, disorder and gap are finite and not negative")
        if sources < 1 or most < 1:
            raise ValueError("there is at least one source, and room for at least one sample")
        window = max(window, disorder)
        self._window, self._slop, self._disorder, self._gap = (
            round(time * _NANOSECONDS) for time in (window, slop, disorder, max(gap, window))
        )
        self._sources = sources
        self._most = most
        self._direct = sources == 1 and disorder == 0.0
        self._now: _Stretch | None = None
        self._elsewhere: _Stretch | None = None
        self._released: int | None = None  # the last stamp that left the present stretch

    def retune(self, gap: float) -> None:
        """Take another `gap` [s] from now on.

        What is held as a jump that no longer is one is dropped with the next sample.
        """
        self._gap = max(round(gap * _NANOSECONDS), self._window)

    @property
    def pending(self) -> int:
        """Number of samples that wait."""
        return sum(part.pending for part in (self._now, self._elsewhere) if part is not None)

    def add(self, source: int, sample: Measurement) -> Sequence[Measurement | Dropped]:
        """Take in a sample; return what is ready, in order, and what is dropped.

        Parameters
        ----------
        source : int
            Which source it is of, from 0.
        sample : Measurement
            What it measured; NaN: nothing.
        """
        if self._direct:
            return [sample]
        now = self._now
        if now is None:
            now = self._now = _Stretch(self._sources, sample.stamp_ns)
        elif abs(sample.stamp_ns - now.newest) > self._gap:
            return self._add_elsewhere(now, source, sample)
        dropped = self._give_up_elsewhere()
        if self._released is not None and sample.stamp_ns < self._released:
            return [*dropped, Dropped(source, sample.stamp_ns)]
        now.add(source, sample)
        return [*dropped, *self._ready(now)]

    def flush(self) -> list[Measurement]:
        """Return all that waits, in order; what is held as a jump becomes one."""
        flushed = self._drain(self._now)
        if self._elsewhere is not None:
            flushed += self._settle(self._elsewhere)
            flushed += self._drain(self._now)
        return flushed

    def _drain(self, stretch: _Stretch | None) -> list[Measurement]:
        drained = [] if stretch is None else stretch.drain(self._slop)
        if drained:
            self._released = drained[-1].stamp_ns
        return drained

    def _ready(self, now: _Stretch) -> list[Measurement]:
        """Remove what need not wait any longer."""
        ready: list[Measurement] = []
        while now.pending:
            head = now.head()
            waits = now.newest - head <= self._window and self.pending <= self._most
            if waits and not self._complete(now, head):
                break
            ready.append(now.take(self._slop))
            self._released = ready[-1].stamp_ns
        return ready

    def _complete(self, now: _Stretch, head: int) -> bool:
        """Whether no live source can still send anything that belongs to, or before, `head`."""
        reach = head + self._slop
        for source, heard in enumerate(now.heard):
            queue = now.queues[source]
            until = min(queue[0].stamp_ns, reach) if queue else reach
            watermark = -math.inf if heard is None else heard - self._disorder
            if watermark < until and now.live(source, self._gap):
                return False
        return True

    def _add_elsewhere(
        self, now: _Stretch, source: int, sample: Measurement
    ) -> list[Measurement | Dropped]:
        """Take in a sample from far off the present time."""
        dropped: list[Dropped] = []
        there = self._elsewhere
        if there is None or abs(sample.stamp_ns - there.newest) > self._gap:
            dropped = self._give_up_elsewhere()
            there = self._elsewhere = _Stretch(self._sources, sample.stamp_ns)
        there.add(source, sample)
        if not self._has_jumped(now, there):
            return [*dropped]
        before = self._drain(now)
        return [*dropped, *before, *self._settle(there)]

    def _has_jumped(self, now: _Stretch, there: _Stretch) -> bool:
        """Whether time goes on `there`."""
        all_there = all(
            there.heard[source] is not None
            for source, heard in enumerate(now.heard)
            if heard is not None and now.live(source, self._gap)
        )
        lasting = there.newest - there.oldest > self._window
        return all_there or lasting or self.pending > self._most

    def _settle(self, there: _Stretch) -> list[Measurement]:
        """Go on in another stretch."""
        self._now, self._elsewhere, self._released = there, None, None
        return self._ready(there)

    def _give_up_elsewhere(self) -> list[Dropped]:
        dropped = [] if self._elsewhere is None else self._elsewhere.dropped()
        self._elsewhere = None
        return dropped
