"""Many drives in one process, by one joint state of all joints: what it costs, if it keeps up."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from numpy.typing import NDArray

from belt_ros.settings import load_settings, read_parameters
from benchmarks.estimation.judged import SOURCES
from benchmarks.estimation.report import verdicts
from benchmarks.graph.bench import INPUT, NODE_NAME, bench
from benchmarks.graph.counter import Heard
from benchmarks.graph.plan import Block, Plan
from benchmarks.graph.rate import WARM_UP, answered_together
from benchmarks.graph.signals import loaded

_Floats = NDArray[np.float64]
_ALL = 0.999  # of the states that should come, for a node that keeps up with every measurement
_LATE = 0.1  # [s] by which the slowest hundredth may be late


class Drives(NamedTuple):
    """One run."""

    case: str
    sources: str
    drives: int
    rate: float  # of each drive [Hz]
    sent: int  # measurements of all drives, warm-up included
    used: int  # of those, in the drives' last states
    expected: int  # states, in the time that counts, of what the drives ask to be pooled
    states: int
    pooled: float  # span of messages in one state, median of the last second [s]
    p50: float  # from the stamp of the last message in a state to the state's arrival [us]
    p99: float  # [us]
    longest: float  # [us]
    lag: float  # median of the last second [us]; it grows if the node cannot keep up
    processor: float  # share of one core
    growth: int  # of the memory [B]

    @property
    def unused(self) -> int:
        """Measurements that are in no state, beside those that wait for others to be pooled."""
        span = self.pooled if math.isfinite(self.pooled) else 0.0
        waiting = round(span * self.rate) * self.drives
        return max(self.sent - self.used - waiting, 0)


def drive_names(count: int) -> tuple[str, ...]:
    """Return the drives' names."""
    return tuple(f"drive_{number}" for number in range(count))


def several_parameters(params: Path, count: int) -> dict[str, object]:
    """Return the parameters of a node of so many drives like that of a file, but for the joints."""
    common = {name: value for name, value in read_parameters(params).items() if name != "name"}
    settings = load_settings(params)
    parameters: dict[str, object] = {"drives": list(drive_names(count)), **common}
    for number, name in enumerate(drive_names(count)):
        parameters[f"{name}.driver.joint"] = f"{settings.driver.name}_{number}"
        parameters[f"{name}.driven.joint"] = f"{settings.driven.name}_{number}"
    return parameters


def run_drives(
    params: Path, count: int, rate: float, seconds: float, depth: int, pool_period: float | None
) -> Drives:
    """Run so many drives in one node, with a `pool_period` [s] of their own."""
    told = {} if pool_period is None else {"limits.pool_period": pool_period}
    settings = load_settings(params, told)
    together = answered_together(settings, rate)
    cycle = loaded(settings, rate).repeated(count)
    states = tuple(f"{NODE_NAME}/{name}/state" for name in drive_names(count))
    with bench() as place:
        written = place.folder / "drives.yaml"
        parameters = several_parameters(params, count) | told
        written.write_text(yaml.safe_dump({"/**": {"ros__parameters": parameters}}))
        node = place.start_node(written, input_reliability="reliable", input_depth=depth)
        counts = Block((INPUT,), rate, seconds, node.pid)
        blocks = (counts._replace(seconds=WARM_UP, pause=0.0), counts)
        plan = Plan(cycle.joints, cycle.save(place.folder), blocks)
        (warm, run), heard, memory = place.run(plan, states, node)
    counted = [each.between(run.first_ns, run.last_ns) for each in heard]
    ending = [each.between(run.last_ns - 1_000_000_000, run.last_ns) for each in counted]
    p50, p99, longest = np.quantile(_microseconds(counted, rate), (0.5, 0.99, 1.0)).tolist()
    return Drives(
        case=f"{count} drives at {rate:g} Hz" + (f", {together} pooled" if together > 1 else ""),
        sources=SOURCES,
        drives=count,
        rate=rate,
        sent=(warm.ticks + run.ticks) * count,
        used=sum(int(each.state(-1).accepted_count) for each in heard if each.messages),
        expected=run.ticks // together * count,
        states=sum(np.unique(each.stamps).size for each in counted),
        pooled=float(np.median(_all([_apart(each) for each in ending]))),
        p50=p50,
        p99=p99,
        longest=longest,
        lag=float(np.median(_microseconds(ending, rate))),
        processor=run.processor_ns / (run.last_ns - run.first_ns + counts.pause * 1e9),
        growth=memory.growth(run.first_ns, run.last_ns),
    )


def _apart(heard: Heard) -> _Floats:
    """Return how long after the one before it each state but the first is stamped [s]."""
    return np.diff(heard.stamps) * 1e-9


def _microseconds(heard: list[Heard], rate: float) -> _Floats:
    """Return all delays [us]. A state's messages are those since the state before it."""
    delays = [
        (each.arrivals[1:] - each.stamps[1:]) * 1e-9 - 0.5 * (_apart(each) - 1.0 / rate)
        for each in heard
    ]
    return _all(delays) * 1e6


def _all(parts: list[_Floats]) -> _Floats:
    """Return all numbers; NaN where there are none."""
    found = np.concatenate(parts)
    return found if found.size else np.full(1, np.nan)


def drives_verdicts(rows: list[Drives]) -> list[str]:
    """Return what was to be reached, and what was."""
    lines = []
    for row in rows:
        late = f"p99 {row.p99 * 1e-6:.3f} s"
        pooled = f"of {row.pooled:.3g} s each at the end"
        lines += [
            (
                f"{row.case}: every state, 99 % of them within {_LATE:g} s",
                f"{row.states / row.expected:.2%}, {late}",
                row.states >= _ALL * row.expected and row.p99 * 1e-6 <= _LATE,
            ),
            (
                f"{row.case}: every measurement in a state, 99 % of these within {_LATE:g} s",
                f"{row.unused} of {row.sent} in none; {pooled}, {late}",
                row.unused == 0 and row.p99 * 1e-6 <= _LATE,
            ),
        ]
    return verdicts(lines)


def drives_lines(rows: list[Drives]) -> tuple[list[str], list[list[str]]]:
    """Return head and lines of the table."""
    head = ["run", "measurements", "in no state", "states", "of", "one is of [ms]", "p50 [us]"]
    head += ["p99 [us]", "longest [ms]", "lag at the end [ms]", "processor", "memory [MB]"]
    lines = [
        [
            row.case,
            *(str(row.sent), str(row.unused), str(row.states), str(row.expected)),
            f"{row.pooled * 1e3:.0f}",
            *(f"{row.p50:.0f}", f"{row.p99:.0f}"),
            *(f"{row.longest * 1e-3:.1f}", f"{row.lag * 1e-3:.1f}", f"{row.processor:.0%}"),
            f"{row.growth / 1e6:+.2f}",
        ]
        for row in rows
    ]
    return head, lines
