"""Hours of varying load, up to 60 % of what the belt can truly carry: nothing is to be raised."""

from typing import NamedTuple

import numpy as np

from belt_ros.estimation import Condition
from belt_ros.estimation.traction import SHARE
from belt_ros.rig import measured
from belt_ros.rig.scenario import Scenario
from belt_ros.settings import DriveSettings
from benchmarks.alarms.cases import PRIOR, Case
from benchmarks.alarms.raw_slip import RawSlip
from benchmarks.estimation.campaign import Task
from benchmarks.estimation.cells import BELTS, STIFFNESSES
from benchmarks.estimation.draws import Condition as Drawn
from benchmarks.estimation.draws import drawn_condition, scenario_of
from benchmarks.estimation.judged import SOURCES
from benchmarks.estimation.store import Format, number

METHOD = "hours"
RATE = 20.0  # [Hz]
DURATION = 900.0  # [s] of a run
GREATEST = 0.6  # share of the true capacity
_LEVEL = (2.0, 20.0)  # [s] that a level of the load lasts
_CHANGE = (0.1, 2.0)  # [s] that it takes to get there
_BEGIN = 2.0  # [s]


class Hours(NamedTuple):
    """What came of one run under varying load."""

    method: str
    case: str
    seed: int
    sources: str
    duration: float  # [s]
    traction: float  # least true traction, over that of what the estimator was told
    greatest_raw_slip: float  # low-passed
    raised: tuple[int, ...]  # times, by `CONDITIONS`


CONDITIONS = tuple(condition for condition in Condition if condition is not Condition.NONE)


def truly_lost(row: Hours) -> bool:
    """Whether the belt truly has lost traction against what was told."""
    return row.traction < SHARE


def hours_scenario(
    case: Case, settings: DriveSettings, seed: int, duration: float
) -> tuple[Scenario, Drawn]:
    """Return a run of `duration` [s] under varying load, and what its belt is."""
    random = np.random.default_rng([case.seed, seed, 1])
    condition = drawn_condition(random, settings, duration)
    speed = BELTS[case.belt].speed
    points = [[0.0, 0.0], [_BEGIN, 0.0]]
    while points[-1][0] < duration - _LEVEL[1] - _CHANGE[1]:
        at = points[-1][0] + random.uniform(*_CHANGE)
        end = at + random.uniform(*_LEVEL)
        least = min(condition.capacity(settings, t, speed) for t in (points[-1][0], at, end))
        torque = float(GREATEST * random.uniform(0.05, 1.0) * least)
        points += [[at, torque], [end, torque]]
    values: dict[str, object] = {
        "name": case.name,
        "duration": duration,
        "sample_rate": RATE,
        "speed": [[0.0, 0.0], [1.0, speed]],
        "load": points,
    }
    return scenario_of(random, settings, condition, values), condition


def run_hours(case: Case, seed: int, duration: float = DURATION) -> list[Hours]:
    """Run the alarms under `duration` [s] of varying load."""
    settings = case.settings(seed)
    scenario, condition = hours_scenario(case, settings, seed, duration)
    monitor = settings.monitor()
    raw = RawSlip(settings, _BEGIN)
    counts: dict[Condition, int] = {}
    for measurement, _ in measured(settings, scenario):
        status = monitor.step(measurement).alarm
        raw.take(measurement)
        for each in () if status is None else status.conditions:
            counts[each.condition] = max(counts.get(each.condition, 0), each.count)
    speed = BELTS[case.belt].speed
    told = _capacity_as_told(settings, speed)
    times = np.linspace(0.0, duration, 46)
    traction = min(condition.capacity(settings, float(t), speed) for t in times) / told
    return [
        Hours(
            METHOD,
            case.name,
            seed,
            SOURCES,
            duration,
            traction,
            raw.greatest,
            tuple(counts.get(each, 0) for each in CONDITIONS),
        )
    ]


def _capacity_as_told(settings: DriveSettings, speed: float) -> float:
    prior = settings.prior
    told = Drawn(
        np.zeros(1),
        np.array([prior.tension]),
        np.array([prior.friction_coefficient]),
        np.array([prior.friction_stiffness]),
    )
    return told.capacity(settings, 0.0, speed)


def jobs(runs: int, containing: str = "") -> list[Task[Hours]]:
    """Return `runs` runs of each belt, its kf in turn."""
    found = []
    for seed in range(runs):
        for belt in BELTS:
            case = Case(belt, STIFFNESSES[seed % len(STIFFNESSES)], PRIOR)
            if containing in case.name:
                found.append(Task(METHOD, case.name, seed, run_hours, (case, seed)))
    return found


_RAISED = Hours._fields.index("raised")


def _fields(row: Hours) -> list[str]:
    values = (*row[:_RAISED], *row.raised)
    return [number(value) if isinstance(value, float) else str(value) for value in values]


def _row(fields: list[str]) -> Hours:
    method, case, seed, sources, duration, traction, raw, *raised = fields
    assert len(raised) == len(CONDITIONS)
    numbers = float(duration), float(traction), float(raw)
    return Hours(method, case, int(seed), sources, *numbers, tuple(map(int, raised)))


FORM = Format((*Hours._fields[:_RAISED], *(c.name.lower() for c in CONDITIONS)), _fields, _row)
