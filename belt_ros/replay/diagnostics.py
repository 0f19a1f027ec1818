"""Diagnostics on the time line of the bag: a row of the drive and one of its input each second.

Without the figures of the live node that a bag does not have: what processing took, and clocks.
"""

import math
from collections.abc import Callable, Iterator

from belt_ros.diagnostic_rows import Level, Row, drive_row, judge_fit, judge_rejected, words
from belt_ros.estimation import AlarmStatus, BeltEstimate, Health, Rejection, Severity
from belt_ros.replay.drive_bag import Sample

NODE_NAME = "belt_node"
_PERIOD_NS = 1_000_000_000
_SECONDS = 1e-9
Rows = tuple[int, tuple[Row, ...]]


class _Input:
    """What came in one period."""

    def __init__(self) -> None:
        self.received = 0
        self.rejected = [0] * len(Rejection)
        self.age_sum = 0.0
        self.age_max = -math.inf

    def count(self, sample: Sample, reason: Rejection) -> None:
        self.received += 1
        if reason is not Rejection.NONE:
            self.rejected[reason] += 1
        self.age_sum += sample.age
        self.age_max = max(self.age_max, sample.age)


class DiagnosticsLog:
    """Makes rows of diagnostics of what the monitor makes of a bag.

    Parameters
    ----------
    drive_name, topics : str
    greatest_gap : float
        Time after which the estimate is stale [s].
    health : callable
        Returns the monitor's health.
    """

    def __init__(
        self, drive_name: str, topics: str, greatest_gap: float, health: Callable[[], Health]
    ) -> None:
        self._drive_name = drive_name
        self._topics = topics
        self._gap = greatest_gap
        self._health = health
        self._due_ns: int | None = None
        self._began_ns = self._heard_ns = self._used_ns = 0
        self._input = _Input()
        self._estimate: BeltEstimate | None = None
        self._alarm: AlarmStatus | None = None

    def before(self, log_ns: int) -> Iterator[Rows]:
        """Yield log time [ns] and rows of what fell due before something is logged at `log_ns`.

        In a gap there is one row that says so, not one every second.
        """
        if self._due_ns is None or log_ns < self._heard_ns:
            self._began_ns = self._used_ns = log_ns
            self._due_ns = log_ns + _PERIOD_NS
        elif log_ns >= self._due_ns:
            yield self._report(self._due_ns)
            silent_ns = self._used_ns + math.ceil(self._gap / _SECONDS) + 1
            silent_ns = max(silent_ns, self._due_ns)
            if silent_ns < log_ns and silent_ns != self._began_ns:
                yield self._report(silent_ns)
            periods = (log_ns - self._due_ns) // _PERIOD_NS + 1
            self._due_ns += periods * _PERIOD_NS
        self._heard_ns = log_ns

    def add(
        self,
        sample: Sample,
        reason: Rejection,
        estimate: BeltEstimate | None,
        alarm: AlarmStatus | None,
    ) -> Row | None:
        """Take in what came of a sample; return the drive's row if its alarm has become worse."""
        self._input.count(sample, reason)
        if reason is Rejection.NONE:
            self._used_ns = sample.log_ns
        if estimate is not None:
            self._estimate = estimate
        return None if alarm is None else self.add_alarm(sample.log_ns, alarm)

    def add_alarm(self, log_ns: int, alarm: AlarmStatus) -> Row | None:
        """Take in the alarm's new status; return the drive's row if that has become worse."""
        before = Severity.NORMAL if self._alarm is None else self._alarm.severity
        self._alarm = alarm
        return self._drive_row(log_ns) if alarm.severity > before else None

    def end(self) -> Rows | None:
        """Return log time [ns] and rows of the last, unfinished period; None if it is empty."""
        return self._report(self._heard_ns) if self._input.received else None

    def _report(self, now_ns: int) -> Rows:
        rows = (self._drive_row(now_ns), self._input_row(now_ns))
        self._began_ns, self._input = now_ns, _Input()
        return now_ns, rows

    def _drive_row(self, now_ns: int) -> Row:
        unused = max(now_ns - self._used_ns, 0) * _SECONDS
        return drive_row(
            NODE_NAME, self._drive_name, self._estimate, self._alarm, unused, self._gap
        )

    def _input_row(self, now_ns: int) -> Row:
        health = self._health()
        came, period = self._input, (now_ns - self._began_ns) * _SECONDS
        values: dict[str, float] = {
            "input rate [Hz]": came.received / period if period > 0.0 else 0.0,
            "accepted": health.accepted,
            "resets": health.resets,
            "rejected": sum(health.rejections),
        }
        if came.received:
            values["latency mean [ms]"] = 1e3 * came.age_sum / came.received
            values["latency max [ms]"] = 1e3 * came.age_max
        for reason, count in zip(Rejection, health.rejections, strict=True):
            if reason is not Rejection.NONE:
                values[f"rejected {words(reason)}"] = count
        for sensor, fit in health.sensor_fits:
            values[f"fit {sensor} mean [-]"] = fit.mean
        level, message = self._judge_input(health)
        name = f"{NODE_NAME}: {self._drive_name} input"
        return Row(level, name, self._drive_name, message, values)

    def _judge_input(self, health: Health) -> tuple[Level, str]:
        came = self._input
        if not came.received:
            return Level.STALE, f"nothing on {self._topics}"
        accepted = sum(came.rejected) < came.received
        return judge_rejected(tuple(came.rejected), accepted=accepted) or judge_fit(health)
