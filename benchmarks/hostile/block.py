"""A block of messages to one drive, all drawn from one seed, and what came of it."""

import os
import statistics
import traceback
import warnings
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from belt_ros.estimation import Rejection
from belt_ros.node_tables import InputKind
from benchmarks.estimation.judged import SOURCES
from benchmarks.estimation.store import Format, number
from benchmarks.hostile.drives import BASES, hostile_settings
from benchmarks.hostile.messages import Messages
from benchmarks.hostile.motion import Motion
from benchmarks.hostile.session import Session, Step
from benchmarks.hostile.spoiling import Spoiler

METHOD = "hostile"
MESSAGES = 500  # of a block
CASES = ("joint_state", "recorded_joint_state", "pulley_state", "float64")
_ROOT = Path(__file__).resolve().parents[2]
_CALLS = (0.0, 1e-3, 1e-2, 0.1)  # calls per message


class Block(NamedTuple):
    """What came of a block. `fault` is empty unless it ended early, by what it says."""

    method: str
    case: str
    seed: int
    sources: str
    messages: int
    accepted: int
    waiting: int  # in a pool at the end
    states: int
    calls: int
    refusals: int  # of services, as they should
    members: int  # most alive
    median: float  # [us] for an estimate
    slowest: float  # [us]
    of_slowest: int  # members alive in the slowest
    rejected: tuple[int, ...]
    fault: str


_WHOLE, _BEFORE = 7, 10  # numbers before the times, and before the rejections


def _fields(row: Block) -> list[str]:
    times = (number(row.median), number(row.slowest), str(row.of_slowest))
    return [*map(str, row[:11]), *times, *map(str, row.rejected), row.fault]


def _row(fields: list[str]) -> Block:
    method, case, seed, sources, *rest = fields
    rejected, fault = rest[_BEFORE:-1], rest[-1]
    values: list[Any] = [*map(int, rest[:_WHOLE]), *map(float, rest[_WHOLE : _BEFORE - 1])]
    values += [int(rest[_BEFORE - 1]), tuple(map(int, rejected)), fault]
    return Block._make([method, case, int(seed), sources, *values])


FORM = Format(
    (
        *("method", "case", "seed", "sources", "messages", "accepted", "waiting", "states"),
        *("calls", "refusals", "members", "median", "slowest", "of_slowest"),
        *(reason.name.lower() for reason in Rejection),
        "fault",
    ),
    _fields,
    _row,
)


def run_block(seed: int, block: int) -> list[Block]:
    """Run a block; nothing that a drive does wrong leaves here but as its `fault`."""
    _warm_up()
    return [run_messages(seed, block, MESSAGES)]


@cache
def _warm_up() -> None:
    """Load what is compiled, so that no step is timed with that."""
    for block in range(len(CASES)):
        run_messages(0, block, 100)


def run_messages(seed: int, block: int, messages: int) -> Block:
    """Send messages of a drive and kind that follow from the numbers of seed and block."""
    random = np.random.default_rng([seed, block])
    case = CASES[block % len(CASES)]
    base = str(random.choice(BASES))
    settings = hostile_settings(random, base)
    kind = InputKind(case.removeprefix("recorded_"))
    session = Session(settings, base, kind, random)
    stream = Stream(session, case, random)
    fault = ""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            stream.send(messages)
            session.finish()
        except (Exception, Warning) as error:  # noqa: BLE001
            fault = _told(error)
    return _result(case, block, session, fault)


class Stream:
    """Plausible rows, spoiled, as messages, with calls between them."""

    def __init__(self, session: Session, case: str, random: np.random.Generator) -> None:
        settings = session.settings
        self._session, self._case, self._random = session, case, random
        self._motion = Motion(settings, random)
        self._spoiler = Spoiler(settings.limits, random)
        self._messages = Messages(settings, random, recorded=case.startswith("recorded"))
        self._calls = float(random.choice(_CALLS))

    def send(self, messages: int) -> None:
        """Send no fewer than `messages`, and no more than a row's more."""
        session, random = self._session, self._random
        while session.messages < messages:
            row = self._spoiler.spoil(self._motion.next(), self._motion)
            for topic, message in self._told(row):
                session.send(topic, message, self._motion.stamp_ns)
                if random.random() < self._calls:
                    session.call()

    def _told(self, row: Any) -> Any:
        if self._case == "pulley_state":
            return self._messages.pulley_states(row)
        if self._case == "float64":
            return self._messages.numbers(row)
        return [("/joint_states", self._messages.joint_state(row))]


def _told(error: BaseException) -> str:
    """Return an error, and where it was raised, in one line."""
    frames = traceback.extract_tb(error.__traceback__)[-4:]
    places = [f"{os.path.relpath(frame.filename, _ROOT)}:{frame.lineno}" for frame in frames]
    return f"{type(error).__name__}: {error} ({' < '.join(reversed(places))})".replace("\n", " ")


def _result(case: str, block: int, session: Session, fault: str) -> Block:
    steps = session.steps or [Step(0.0, 0)]
    slowest = max(steps)
    return Block(
        METHOD,
        case,
        block,
        SOURCES,
        session.messages,
        session.accepted,
        session.waiting,
        session.states,
        session.calls,
        session.refusals,
        max(step.members for step in steps),
        1e6 * statistics.median(step.seconds for step in steps),
        1e6 * slowest.seconds,
        slowest.members,
        tuple(session.rejected.tolist()),
        fault,
    )
