"""kill -9 at random moments: how soon the node is back, and with what it had learned."""

import math
import random
import time
from pathlib import Path
from statistics import median
from typing import NamedTuple

import numpy as np
from belt_msgs.msg import BeltState

from belt_ros.settings import load_settings
from benchmarks.estimation.judged import SOURCES
from benchmarks.estimation.report import verdicts
from benchmarks.graph.bench import INPUT, NODE, READY, STATE, Bench, bench
from benchmarks.graph.counter import Heard
from benchmarks.graph.plan import Block, Plan, save_plan
from benchmarks.graph.signals import loaded

LEARNING = 15.0  # [s] before the first kill
_SHORTEST, _LONGEST = 1.5, 6.0  # [s] of running before a kill
_STARTING = 4  # every so manieth kill comes while the node starts
_SAVING = 0.5  # [s] between two savings, so that many kills meet one
_WITHIN = 1.0  # [s] from the first message, in which all must be back
_FORGOTTEN = 1.1  # times the deviation before, above which something was forgotten
_KNOWN = ("tension_knowledge", "friction_stiffness_knowledge", "friction_coefficient_knowledge")
_SECOND = 1e9


class Kill(NamedTuple):
    """One kill and the start after it; NaN where the node was killed before it had said a thing."""

    case: str
    number: int
    sources: str
    while_starting: int  # 1: this run was killed while the node started
    ran: float  # from being active to the kill that ended the run before [s]
    ready: float  # from the start of the process to being active [s]
    back: float  # from the first message taken to the first state that a subscriber hears [s]
    states: float  # in the first second, of the messages sent in it
    known_before: int  # quantities learned, in the last state that was certainly saved
    known_after: int  # of those, still known as learned within a second
    tension: float  # its standard deviation after a second, of that before
    stiffness: float  # the same of ln kf


class Life(NamedTuple):
    """One run of the node, on the wall clock [ns]."""

    begin_ns: int
    active_ns: int  # 0: killed before
    end_ns: int


def run_kill(params: Path, rate: float, kills: int, seed: int) -> list[Kill]:
    """Kill the node so often, at a steady rate of input [Hz]."""
    cycle = loaded(load_settings(params), rate)
    with bench() as place:
        longest = LEARNING + (kills + 1) * 60.0
        plan = Plan(cycle.joints, cycle.save(place.folder), (Block((INPUT,), rate, longest),))
        save_plan(plan, place.folder / "plan")
        noted = place.folder / "heard"
        counter = place.start("benchmarks.graph.counter", str(noted), "--keep", STATE)
        counter.wait_for("ready")
        place.start("benchmarks.graph.sender", str(place.folder / "plan"), str(place.folder / "-"))
        lives = _lives(place, params, random.Random(seed), kills)
        counter.stop()
        (heard,) = Heard.load(noted)
    return judged(lives, heard, rate)


def _lives(place: Bench, params: Path, chance: random.Random, kills: int) -> list[Life]:
    """Start and kill the node; it lives once more than it is killed."""
    lives: list[Life] = []
    for number in range(kills + 1):
        starting = number % _STARTING == _STARTING - 1 and number < kills
        begin = time.time_ns()
        node = place.start(
            NODE,
            *("--ros-args", "--params-file", str(params)),
            *("-p", f"memory_file:={place.folder / 'learned.yaml'}"),
            *("-p", f"memory_period:={_SAVING}"),
        )
        active = 0
        if starting:
            time.sleep(chance.uniform(0.0, lives[-1].active_ns - lives[-1].begin_ns) / _SECOND)
        else:
            node.wait_for(READY)
            active = time.time_ns()
            time.sleep(LEARNING if number == 0 else chance.uniform(_SHORTEST, _LONGEST))
        node.kill()
        lives.append(Life(begin, active, time.time_ns()))
    return lives


def judged(lives: list[Life], heard: Heard, rate: float) -> list[Kill]:
    """Return a row for each life but the first, from all states that were heard."""
    rows = []
    before = lives[0]
    for number, life in enumerate(lives[1:]):
        rows.append(_kill(number, before, life, heard, rate))
        before = life if life.active_ns else before
    return rows


def _kill(number: int, before: Life, life: Life, heard: Heard, rate: float) -> Kill:
    """Compare the states before a kill with those after it."""
    ran = (before.end_ns - before.active_ns) / _SECOND
    case, nan = f"{rate:g} Hz", math.nan
    if not life.active_ns:
        return Kill(case, number, SOURCES, 1, ran, nan, nan, nan, 0, 0, nan, nan)
    ready = (life.active_ns - life.begin_ns) / _SECOND
    # What was learned is written some time after it is read off; two periods are enough for that.
    # Of a run too short for that, what it began with, which is the run's before.
    saved = heard.arrived(0, before.end_ns - round(2.0 * _SAVING * _SECOND))
    after = heard.arrived(life.active_ns - round(_SECOND), life.end_ns)
    old, never = saved.state(-1), math.inf
    known = [name for name in _KNOWN if getattr(old, name) == BeltState.KNOWLEDGE_LEARNED]
    if not after.stamps.size:  # the subscriber has not found the node at all before it was killed
        return Kill(case, number, SOURCES, 0, ran, ready, never, 0.0, len(known), 0, never, never)
    first = after.state(0)
    unseen = int(first.accepted_count) - 1 + int(sum(first.rejection_counts))
    first_ns = int(after.stamps[0]) - round(unseen / rate * _SECOND)
    back = (int(after.arrivals[0]) - first_ns) / _SECOND
    second = after.between(first_ns, first_ns + round(_WITHIN * _SECOND))
    if not second.stamps.size:  # the subscriber found the node later: nothing is back in time
        return Kill(case, number, SOURCES, 0, ran, ready, back, 0.0, len(known), 0, never, never)
    new = second.state(-1)
    kept = [name for name in known if getattr(new, name) == BeltState.KNOWLEDGE_LEARNED]
    return Kill(
        case,
        number,
        SOURCES,
        0,
        ran,
        ready,
        back,
        int(np.unique(second.stamps).size + unseen) / (rate * _WITHIN),
        len(known),
        len(kept),
        float(new.mean_tension_stddev / old.mean_tension_stddev),
        float(new.friction_stiffness_log_stddev / old.friction_stiffness_log_stddev),
    )


def kill_verdicts(rows: list[Kill]) -> list[str]:
    """Return what was to be reached, and what was."""
    back = [row for row in rows if not row.while_starting]
    knew = [row for row in back if row.known_before > 0]
    good = sum(row.back <= _WITHIN for row in back)
    kept = sum(row.known_after == row.known_before for row in knew)
    narrow = sum(max(row.tension, row.stiffness) <= _FORGOTTEN for row in back)
    return verdicts(
        [
            (
                f"back within {_WITHIN:g} s of the first message",
                f"{good} of {len(back)}",
                good == len(back) > 0,
            ),
            (
                "what was learned is learned again within that time",
                f"{kept} of {len(knew)}",
                kept == len(knew) > 0,
            ),
            (
                f"deviations of tension and ln kf at most {_FORGOTTEN:g} times those before",
                f"{narrow} of {len(back)}",
                narrow == len(back) > 0,
            ),
        ]
    )


def kill_lines(rows: list[Kill]) -> tuple[list[str], list[list[str]]]:
    """Return head and lines of the table: medians and extremes over the kills."""
    back = [row for row in rows if not row.while_starting]

    def line(name: str, values: list[float], form: str) -> list[str]:
        return [name, *(format(f(values), form) for f in (min, median, max))]

    lines = [
        line("process started until active [s]", [row.ready for row in back], ".2f"),
        line("first message until its state [ms]", [row.back * 1e3 for row in back], ".1f"),
        line("states in the first second, of messages", [row.states for row in back], ".2f"),
        line("quantities learned before", [row.known_before for row in back], ".0f"),
        line("of them learned after", [row.known_after for row in back], ".0f"),
        line("deviation of the tension, of that before", [row.tension for row in back], ".2f"),
        line("deviation of ln kf, of that before", [row.stiffness for row in back], ".2f"),
    ]
    return [f"{len(rows)} kills, {len(rows) - len(back)} while starting", *_EXTREMES], lines


_EXTREMES = ("least", "median", "greatest")
