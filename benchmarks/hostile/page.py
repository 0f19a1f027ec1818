"""What came of all blocks, as a page."""

from collections.abc import Sequence

import numpy as np

from belt_ros.estimation import Rejection
from benchmarks.estimation.report import table
from benchmarks.hostile.block import CASES, Block

_FEWEST = 50  # estimates of a block whose median says something


def sections(rows: Sequence[Block]) -> list[str]:
    """Return the page without its last line."""
    messages = sum(row.messages for row in rows)
    return [
        "# Hostile messages",
        "",
        f"{messages:,} seeded random messages in {len(rows)} blocks, each to a drive of its own",
        "whose parameters lie anywhere within their ranges: streams of a drive that runs, stands,",
        "reverses and slips, with readings that are NaN, infinite, subnormal, at the limits or",
        "stuck, stamps that stand still, jump or are no times, and joint states out of shape;",
        "between them service calls, changed parameters and restored memories. After each message",
        "every number that goes out is checked to be finite, deviations and probabilities to be",
        "such, and that no measurement is lost or counted twice.",
        "",
        *_by_kind(rows),
        "",
        *_by_reason(rows),
        "",
        *_cost(rows),
        "",
        *_faults(rows),
        "",
    ]


def _by_kind(rows: Sequence[Block]) -> list[str]:
    head = ("input", "messages", "accepted", "rejected", "left in a pool", "states", "calls")
    lines = []
    for case in (*CASES, "all"):
        of_case = [row for row in rows if case in (row.case, "all")]
        counts = (
            sum(row.messages for row in of_case),
            sum(row.accepted for row in of_case),
            sum(sum(row.rejected) for row in of_case),
            sum(row.waiting for row in of_case),
            sum(row.states for row in of_case),
            sum(row.calls for row in of_case),
        )
        lines.append([case.replace("_", " "), *(f"{count:,}" for count in counts)])
    return [
        *table(head, lines),
        "",
        "Messages of several topics are joined to one measurement where they belong together, so",
        "fewer are accepted or rejected than messages sent.",
    ]


def _by_reason(rows: Sequence[Block]) -> list[str]:
    total = np.sum([row.rejected for row in rows], axis=0)
    reasons = [reason for reason in Rejection if reason is not Rejection.NONE]
    lines = [[reason.name.lower().replace("_", " "), f"{total[reason]:,}"] for reason in reasons]
    return table(("rejected as", "measurements"), lines)


def _cost(rows: Sequence[Block]) -> list[str]:
    told = [row for row in rows if row.states >= _FEWEST]
    if not told:
        return []
    most = max(rows, key=lambda row: row.members)
    slow = max(told, key=lambda row: row.slowest / row.median)
    ratios = np.array([row.slowest / row.median for row in told])
    longest = max(row.slowest for row in told)
    return [
        f"Most members alive: {most.members} (block {most.seed}). Slowest estimate of a block over",
        f"its median, processor time: {np.median(ratios):.1f} in half of the blocks, at most",
        f"{slow.slowest / slow.median:.0f} ({slow.slowest / 1e3:.1f} ms with {slow.of_slowest}",
        f"members, block {slow.seed}). Slowest of all: {longest / 1e3:.1f} ms.",
    ]


def _faults(rows: Sequence[Block]) -> list[str]:
    faulty = [row for row in rows if row.fault]
    if not faulty:
        return ["No exception, nothing but finite numbers out, every measurement counted once."]
    head = ("block", "input", "after messages", "what")
    return [
        f"**{len(faulty)} blocks ended early.**",
        "",
        *table(head, [[str(r.seed), r.case, str(r.messages), r.fault] for r in faulty], 4),
    ]
