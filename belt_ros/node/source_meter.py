"""What one topic brings: how often, how late, and what that says of its sender's clock."""

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from belt_ros.node.missing import Missing

SKEW_LIMIT = 0.02
"""Difference between two senders' clocks that is worth telling [s].

More than the wait for a bus cycle or a scheduler explains, and than NTP leaves on a local network.
Less would go unnoticed, more would not: of pulleys that gain 60 rad/s in a second, it makes a slip
of 1.2 % at 100 rad/s, as much as the creep of a loaded belt."""

AGE_LIMIT = 10.0
"""Age of stamps at arrival [s] that no network explains, but a bag without /clock does."""

_PERIODS = 8  # as in NTP's clock filter, RFC 5905, section 10


@dataclass(frozen=True, slots=True)
class SourceReport:
    """One period of one topic.

    Attributes
    ----------
    topic : str
        Its full name.
    rate : float
        Messages a second [Hz], usable or not.
    latency_mean, latency_max : float
        From a message's stamp to its arrival, both on ROS time [s]; NaN: none came.
    clock_offset : float
        The least latency of the last eight periods in which any came [s]; NaN: none ever. Delays
        only add to it, so it is nearest to what the clocks of sender and receiver differ by.
        Negative: the stamps are of the future.
    silence : float
        Since the last message, or since counting began [s].
    missing : float
        Messages that did not come, by the stamps of those that did; NaN: cannot be told.
    """

    topic: str
    rate: float
    latency_mean: float
    latency_max: float
    clock_offset: float
    silence: float
    missing: float = math.nan


class SourceMeter:
    """Counts what one topic brings. Times are seconds on a steady clock."""

    def __init__(self, topic: str, now: float) -> None:
        self._topic = topic
        self._last = self._since = now
        self._received = 0
        self._latencies = _Latencies()
        self._least: deque[float] = deque(maxlen=_PERIODS)
        self._missing = Missing()

    def count(self, latency: float, now: float, stamp_ns: int | None = None) -> None:
        """Count one message; `latency` [s] is NaN, and there is no stamp, where that is no time."""
        self._received += 1
        if stamp_ns is not None:
            self._missing.hear(stamp_ns)
        self._last = now
        self._latencies.add(latency)

    def report(self, now: float) -> SourceReport:
        """Report the period that ends now, and begin the next."""
        period, latencies = now - self._since, self._latencies
        if latencies.count:
            self._least.append(latencies.least)
        report = SourceReport(
            topic=self._topic,
            rate=self._received / period if period > 0.0 else 0.0,
            latency_mean=latencies.sum / latencies.count if latencies.count else math.nan,
            latency_max=latencies.greatest if latencies.count else math.nan,
            clock_offset=min(self._least, default=math.nan),
            silence=now - self._last,
            missing=self._missing.report(),
        )
        self._since, self._received, self._latencies = now, 0, _Latencies()
        return report


class _Latencies:
    """Sum and range of the latencies in a period."""

    def __init__(self) -> None:
        self.count = 0
        self.sum = 0.0
        self.least = math.inf
        self.greatest = -math.inf

    def add(self, latency: float) -> None:
        if math.isfinite(latency):
            self.count += 1
            self.sum += latency
            self.least = min(self.least, latency)
            self.greatest = max(self.greatest, latency)


def missing_messages(sources: Iterable[SourceReport]) -> float:
    """Return how many messages are missing, of every topic once; NaN: of none can that be told."""
    known = {each.topic: each.missing for each in sources if math.isfinite(each.missing)}
    return sum(known.values()) if known else math.nan


class ClockSkew(NamedTuple):
    """By how much [s] the stamps of one topic are ahead of those of another."""

    seconds: float
    ahead: str
    behind: str


def clock_skew(sources: Iterable[SourceReport]) -> ClockSkew | None:
    """Return the greatest skew between two topics; None if fewer than two have stamps."""
    known = [source for source in sources if math.isfinite(source.clock_offset)]
    if len(known) < 2:
        return None
    ahead = min(known, key=lambda source: source.clock_offset)
    behind = max(known, key=lambda source: source.clock_offset)
    return ClockSkew(behind.clock_offset - ahead.clock_offset, ahead.topic, behind.topic)


def clock_trouble(
    sources: Sequence[SourceReport], skew_limit: float = SKEW_LIMIT, age_limit: float = AGE_LIMIT
) -> str:
    """Return what is wrong with the stamps and what to do, in a sentence; "" if nothing is.

    Parameters
    ----------
    sources : sequence of SourceReport
        Of one drive.
    skew_limit : float
        How far two topics' stamps may be apart, and one's in the future of ROS time [s].
    age_limit : float
        How old stamps may be at arrival [s].
    """
    skew = clock_skew(sources)
    if skew is not None and skew.seconds > skew_limit:
        return (
            f"the stamps of {skew.ahead} are {skew.seconds:.3g} s ahead of those of {skew.behind}: "
            "synchronise their senders' clocks (PTP, chrony), and stamp when measuring"
        )
    for source in sources:
        if source.clock_offset < -skew_limit:
            return (
                f"the stamps of {source.topic} are {-source.clock_offset:.3g} s in the future of "
                "ROS time: synchronise the clocks, or set use_sim_time if there is a /clock"
            )
        if source.clock_offset > age_limit:
            return (
                f"the stamps of {source.topic} are {source.clock_offset:.3g} s old when they come: "
                "have its sender stamp its messages, synchronise the clocks, or set use_sim_time "
                "and play the bag with --clock"
            )
    return ""
