"""From input to state beside a bare relay of the same messages, by turns in the same run."""

from pathlib import Path
from statistics import median
from typing import NamedTuple

import numpy as np

from belt_ros.settings import load_settings
from benchmarks.estimation.judged import SOURCES
from benchmarks.estimation.report import verdicts
from benchmarks.graph import relay
from benchmarks.graph.bench import INPUT, STATE, bench
from benchmarks.graph.counter import Heard
from benchmarks.graph.plan import Block, Plan, Sent
from benchmarks.graph.rate import answered_together
from benchmarks.graph.signals import CHANGING, STEADY, loaded

NODE, RELAY = "node", "relay"
BLOCK = 12.0  # [s] before it is the other's turn: two cycles of the load
_LATENCY, _PROCESSOR = 2.0, 3.0  # times the relay's, allowed
_ANSWERED = 0.98  # of a turn's messages, for a comparison; the gap before a turn costs two
_WARM = 1  # turns of each that do not count


class Turn(NamedTuple):
    """One program's turn."""

    case: str
    program: str
    turn: int
    sources: str
    sent: int
    expected: int  # states, each of pooled messages
    states: int
    p50: float  # [us]
    p99: float  # [us]
    processor: float  # per message [us]


def run_latency(
    params: Path, rate: float, seconds: float, depth: int, *, steady: bool
) -> list[Turn]:
    """Measure at `rate` [Hz], `seconds` for each of the two, in turns."""
    settings = load_settings(params)
    cycle = loaded(settings, rate, STEADY if steady else CHANGING)
    together = answered_together(settings, rate)
    turns = _WARM + max(round(seconds / BLOCK), 1)
    with bench() as place:
        node = place.start_node(
            params, input_reliability="reliable", input_depth=depth, longest_pool=0.0
        )
        other = place.start_relay(depth)
        pair = (
            Block((INPUT,), rate, BLOCK, node.pid),
            Block((relay.TOPICS[0],), rate, BLOCK, other.pid),
        )
        plan = Plan(cycle.joints, cycle.save(place.folder), pair * turns)
        sent, (states, relayed), _ = place.run(plan, (STATE, relay.TOPICS[1]), node)
    case = f"{rate:g} Hz{', steady load' if steady else ''}"
    pooled = (together - 1) / rate
    rows = []
    for number in range(_WARM, turns):
        rows.append(_turn(case, NODE, number - _WARM, sent[2 * number], states, together, pooled))
        rows.append(_turn(case, RELAY, number - _WARM, sent[2 * number + 1], relayed, 1, 0.0))
    return rows


def _turn(
    case: str, program: str, number: int, sent: Sent, heard: Heard, together: int, pooled: float
) -> Turn:
    arrived = heard.between(sent.first_ns, sent.last_ns)
    delays = arrived.delays(pooled) * 1e6 if arrived.stamps.size else np.full(1, np.nan)
    p50, p99 = np.quantile(delays, (0.5, 0.99)).tolist()
    spent = sent.processor_ns * 1e-3 / sent.ticks
    expected = sent.ticks // together
    states = arrived.stamps.size
    return Turn(case, program, number, SOURCES, sent.ticks, expected, states, p50, p99, spent)


def latency_verdicts(rows: list[Turn]) -> list[str]:
    """Return what was to be reached, and what was: medians of the ratios of neighbouring turns."""
    lines = []
    for case in dict.fromkeys(row.case for row in rows):
        pairs = _pairs([row for row in rows if row.case == case])
        delay = median(node.p50 / other.p50 for node, other in pairs)
        spent = median(node.processor / other.processor for node, other in pairs)
        answered = min(row.states / row.expected for pair in pairs for row in pair)
        told = f"; {answered:.0%} answered in the worst turn"
        all_answered = answered >= _ANSWERED
        lines += [
            (
                f"{case}: p50 from input to state at most {_LATENCY:g} times the relay's",
                f"{delay:.2f}{'' if all_answered else told}",
                delay <= _LATENCY and all_answered,
            ),
            (
                f"{case}: processor time per message at most {_PROCESSOR:g} times the relay's",
                f"{spent:.2f}{'' if all_answered else told}",
                spent <= _PROCESSOR and all_answered,
            ),
        ]
    return verdicts(lines)


def _pairs(rows: list[Turn]) -> list[tuple[Turn, Turn]]:
    nodes = sorted((row for row in rows if row.program == NODE), key=lambda row: row.turn)
    relays = sorted((row for row in rows if row.program == RELAY), key=lambda row: row.turn)
    return list(zip(nodes, relays, strict=True))


def latency_lines(rows: list[Turn]) -> tuple[list[str], list[list[str]]]:
    """Return head and lines of the table: medians over the turns."""
    head = ["rate", "program", "turns", "sent", "states"]
    head += ["p50 [us]", "p99 [us]", "processor per message [us]"]
    lines = []
    for case, program in dict.fromkeys((row.case, row.program) for row in rows):
        group = [row for row in rows if (row.case, row.program) == (case, program)]
        counts = (len(group), sum(row.sent for row in group), sum(row.states for row in group))
        numbers = (
            median(row.p50 for row in group),
            median(row.p99 for row in group),
            median(row.processor for row in group),
        )
        lines.append([case, program, *map(str, counts), *(f"{each:.0f}" for each in numbers)])
    return head, lines
