"""At a steady rate: what is lost, what latency, what memory."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.settings import DriveSettings, load_settings
from benchmarks.estimation.judged import SOURCES
from benchmarks.estimation.report import verdicts
from benchmarks.graph.bench import INPUT, STATE, bench
from benchmarks.graph.plan import Block, Plan, Sent
from benchmarks.graph.program import processor_ns
from benchmarks.graph.signals import loaded

CASES = ((1000.0, 600.0), (4000.0, 60.0))  # [Hz], [s]
WARM_UP = 5.0  # [s] before what counts
_GROWTH = 1_000_000  # [B] that are allowed
_MEGABYTE = 1e6


class Rate(NamedTuple):
    """One run at one rate. Delays are from stamp to arrival of the state at a subscriber."""

    case: str
    sources: str
    sent: int
    accepted: int  # by the node, of all that was sent
    rejected: int
    states: int  # that arrived, of those sent in the time that counts
    together: int  # messages that are answered by one state
    p50: float  # [us]
    p99: float  # [us]
    longest: float  # [us]
    gap: float  # longest between the stamps of two states, in intervals that are expected
    growth: int  # of the node's memory [B]
    processor: float  # of the node, share of one core
    sender_late: float  # at most [ms]

    @property
    def unseen(self) -> int:
        """Messages that never reached the node's estimator, or were in its pool at the end."""
        return self.sent - self.accepted - self.rejected


def run_rate(
    params: Path, rate: float, seconds: float, depth: int, warm_up: float = WARM_UP
) -> Rate:
    """Send at `rate` [Hz] for `seconds`, after a warm-up; every process reliable."""
    settings = load_settings(params)
    cycle = loaded(settings, rate)
    together = answered_together(settings, rate)
    with bench() as place:
        node = place.start_node(
            params, input_reliability="reliable", input_depth=depth, longest_pool=0.0
        )
        counts = Block((INPUT,), rate, seconds, node.pid)
        blocks = (counts._replace(seconds=warm_up, pause=0.0), counts)
        plan = Plan(cycle.joints, cycle.save(place.folder), blocks)
        sent, (heard,), memory = place.run(plan, (STATE,), node)
        assert processor_ns(node.pid) > 0  # it is still there
    warm, run = sent
    counted = heard.between(run.first_ns, run.last_ns)
    delays = (
        counted.delays((together - 1) / rate) * 1e6 if counted.stamps.size else np.full(1, np.nan)
    )
    last = heard.state(-1) if heard.messages else None
    return Rate(
        case=f"{rate:g} Hz for {seconds:g} s",
        sources=SOURCES,
        sent=warm.ticks + run.ticks,
        accepted=0 if last is None else int(last.accepted_count),
        rejected=0 if last is None else int(sum(last.rejection_counts)),
        states=int(np.unique(counted.stamps).size),
        together=together,
        p50=float(np.median(delays)),
        p99=float(np.quantile(delays, 0.99)),
        longest=float(np.max(delays)),
        gap=_longest_gap(counted.stamps) * rate / together,
        growth=memory.growth(run.first_ns, run.last_ns),
        processor=run.processor_ns * 1e-9 / _duration(run, counts.pause),
        sender_late=run.latest * 1e3,
    )


def answered_together(settings: DriveSettings, rate: float) -> int:
    """Return how many messages at `rate` [Hz] the node pools for one state."""
    return max(math.floor(rate * settings.limits.pool_period), 1)


def _longest_gap(stamps: NDArray[np.int64]) -> float:
    """Return the longest time between two stamps [s], infinite if there are fewer."""
    return float(np.max(np.diff(np.unique(stamps)))) * 1e-9 if stamps.size > 1 else math.inf


def _duration(sent: Sent, pause: float) -> float:
    return (sent.last_ns - sent.first_ns) * 1e-9 + pause


def rate_verdicts(rows: list[Rate]) -> list[str]:
    """Return what was to be reached, and what was."""
    lines = []
    for row in rows:
        lines += [
            (
                f"{row.case}: no message lost",
                f"{row.unseen} of {row.sent} before the estimator, "
                f"{row.states} states, of {row.together} messages each; longest gap between two "
                f"{row.gap:.1f} times that",
                row.unseen <= row.together,
            ),
            (
                f"{row.case}: memory grows by less than 1 MB",
                f"{row.growth / _MEGABYTE:+.2f} MB",
                row.growth < _GROWTH,
            ),
        ]
    return verdicts(lines)


def rate_lines(rows: list[Rate]) -> tuple[list[str], list[list[str]]]:
    """Return head and lines of the table of runs."""
    head = [
        *("run", "sent", "accepted", "rejected", "states", "p50 [us]", "p99 [us]", "max [ms]"),
        *("processor", "sender late [ms]"),
    ]
    lines = [
        [
            row.case,
            *map(str, (row.sent, row.accepted, row.rejected, row.states)),
            *(f"{value:.0f}" for value in (row.p50, row.p99)),
            f"{row.longest * 1e-3:.1f}",
            f"{row.processor:.0%}",
            f"{row.sender_late:.1f}",
        ]
        for row in rows
    ]
    return head, lines
