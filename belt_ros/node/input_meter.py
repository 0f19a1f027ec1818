"""What arrives, how late, and how long it takes: counted on a steady clock, reported in periods."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from belt_ros.estimation import Rejection
from belt_ros.node.source_meter import SourceMeter, SourceReport


@dataclass(frozen=True)
class InputReport:
    """One period of the input.

    Attributes
    ----------
    period : float
        Its length [s].
    received : int
        Measurements that came, and messages that made none.
    rejected : tuple of int
        By `Rejection`; the place of `Rejection.NONE` counts nothing.
    latency_mean, latency_max : float
        From a message's stamp to its arrival, both on ROS time [s]; NaN: none came.
    processing_mean, processing_max : float
        From arrival to the estimate [s]; NaN: none came.
    silence : float
        Since the last message, or since the node became active [s].
    unused : float
        Since the last message that was accepted, or since the node became active [s].
    sources : tuple of SourceReport
        What each topic brought; first those that were named to the meter.
    silent : bool
        Whether the silence is longer than it may be.
    """

    period: float
    received: int
    rejected: tuple[int, ...]
    latency_mean: float
    latency_max: float
    processing_mean: float
    processing_max: float
    silence: float
    unused: float
    sources: tuple[SourceReport, ...] = ()
    silent: bool = False

    @property
    def rate(self) -> float:
        """Measurements a second [Hz]."""
        return self.received / self.period if self.period > 0.0 else 0.0

    @property
    def accepted(self) -> int:
        """Messages that were used."""
        return self.received - sum(self.rejected)

    @property
    def main_rejection(self) -> Rejection:
        """The commonest reason in this period."""
        most = max(self.rejected)
        return Rejection(self.rejected.index(most)) if most else Rejection.NONE


class InputMeter:
    """Counts what arrives, and on which of `topics` nothing does. Times are steady seconds."""

    def __init__(self, now: float, topics: Iterable[str] = ()) -> None:
        self._last_received = now
        self._last_accepted = now
        self._sources = {topic: SourceMeter(topic, now) for topic in topics}
        self._begin(now)

    def _begin(self, now: float) -> None:
        self._since = now
        self._received = 0
        self._rejected = [0] * len(Rejection)
        self._latency_sum = self._processing_sum = 0.0
        self._latency_max = self._processing_max = -math.inf

    def heard(self, source: str, latency: float, now: float, stamp_ns: int | None = None) -> None:
        """Count a message on a topic as it comes, whatever becomes of it.

        `latency` is that from its stamp to its arrival [s]; NaN, without `stamp_ns` [ns], where the
        stamp is no time.
        """
        meter = self._sources.get(source)
        if meter is None:
            meter = self._sources[source] = SourceMeter(source, self._since)
        meter.count(latency, now, stamp_ns)

    def count(self, reason: Rejection, latency: float, began: float, ended: float) -> None:
        """Count one measurement, handled from `began` to `ended`."""
        self._received += 1
        self._last_received = began
        if reason is Rejection.NONE:
            self._last_accepted = began
        else:
            self._rejected[reason] += 1
        processing = ended - began
        self._latency_sum += latency
        self._latency_max = max(self._latency_max, latency)
        self._processing_sum += processing
        self._processing_max = max(self._processing_max, processing)

    def unused(self, now: float) -> float:
        """Return the time since the last message that was accepted [s]."""
        return now - self._last_accepted

    def report(self, now: float, longest_silence: float = math.inf) -> InputReport:
        """Report the period that ends now, and begin the next; all times in s."""
        came = self._received > 0
        silence = now - self._last_received
        report = InputReport(
            period=now - self._since,
            received=self._received,
            rejected=tuple(self._rejected),
            latency_mean=self._latency_sum / self._received if came else math.nan,
            latency_max=self._latency_max if came else math.nan,
            processing_mean=self._processing_sum / self._received if came else math.nan,
            processing_max=self._processing_max if came else math.nan,
            silence=silence,
            unused=self.unused(now),
            sources=tuple(meter.report(now) for meter in self._sources.values()),
            silent=silence > longest_silence,
        )
        self._begin(now)
        return report
