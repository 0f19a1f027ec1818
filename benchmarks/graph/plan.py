"""What the sender is to send, and what it says of what it sent: JSON between two processes."""

import json
from pathlib import Path
from typing import NamedTuple


class Block(NamedTuple):
    """A stretch of time in which messages go out at one rate."""

    topics: tuple[str, ...]  # each gets a message at every tick
    rate: float  # ticks a second [Hz]
    seconds: float
    watched: int = -1  # process whose processor time is wanted; -1: none
    pause: float = 1.0  # [s] after it, in which what is under way arrives


class Plan(NamedTuple):
    """All that one sender does."""

    joints: tuple[str, ...]
    cycle: str  # NumPy file (samples, 2, joints): velocities and efforts, sent over and over
    blocks: tuple[Block, ...]
    depth: int = 1000  # of the publishers' queues


class Sent(NamedTuple):
    """What became of a block."""

    first_ns: int  # stamps on the wall clock
    last_ns: int
    ticks: int
    latest: float  # by which a message went out after it was due [s]
    processor_ns: int  # used by the watched process, the pause included; -1: not watched


def save_plan(plan: Plan, path: Path) -> None:
    """Write a plan."""
    path.write_text(json.dumps(plan), encoding="utf-8")


def load_plan(path: Path) -> Plan:
    """Read a plan."""
    joints, cycle, blocks, *rest = json.loads(path.read_text(encoding="utf-8"))
    made = tuple(Block(tuple(topics), *others) for topics, *others in blocks)
    return Plan(tuple(joints), cycle, made, *rest)


def save_sent(sent: list[Sent], path: Path) -> None:
    """Write what was sent."""
    path.write_text(json.dumps(sent), encoding="utf-8")


def load_sent(path: Path) -> list[Sent]:
    """Read what was sent."""
    return [Sent(*each) for each in json.loads(path.read_text(encoding="utf-8"))]
