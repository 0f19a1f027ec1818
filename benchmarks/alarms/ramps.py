"""Load ramps to gross slip: when was the drive warned of it?"""

import math
from typing import NamedTuple

import numpy as np

from belt_ros.estimation import AlarmStatus, Condition, Knowledge
from belt_ros.rig import measured
from belt_ros.rig.scenario import Scenario
from belt_ros.settings import DriveSettings
from benchmarks.alarms.cases import KNOWLEDGE, LEARNED, Case, monitor_of
from benchmarks.alarms.raw_slip import THRESHOLDS, RawSlip
from benchmarks.estimation.campaign import Task
from benchmarks.estimation.cells import BELTS, STIFFNESSES
from benchmarks.estimation.draws import Condition as Drawn
from benchmarks.estimation.draws import drawn_condition, scenario_of
from benchmarks.estimation.judged import SOURCES
from benchmarks.estimation.store import Format, number

METHOD = "ramp"
RATE = 50.0  # [Hz]
RAMPS = (2.0, 4.0, 8.0)  # [s]
_BEGIN = 6.0  # [s]
_BASE, _TOP = 0.3, 1.2  # share of the true capacity
_VISIT = 0.97  # share at which the tension is learned
OF_THE_BELT = (
    Condition.LOW_MARGIN,
    Condition.GROSS_SLIP,
    Condition.TRACTION_LOST,
    Condition.TENSION_LOST,
    Condition.FRICTION_LOST,
)


class Ramp(NamedTuple):
    """What came of one ramp; times since the start of the run [s], NaN: never."""

    method: str
    case: str
    seed: int
    sources: str
    ramp: float  # [s] from 30 to 120 % of capacity
    began: float
    slipped: float  # when gross slip truly began
    warned: float  # when the first alarm rose on the ramp that was still on then
    condition: int  # its condition
    learned: int  # 1: the estimator said when the ramp began that tension is learned
    held_back: int  # 1: a sensor was called implausible, or the estimator lost, before
    crossed: tuple[float, ...]  # when raw slip crossed `raw_slip.THRESHOLDS`


def ramp_scenario(
    case: Case, settings: DriveSettings, seed: int, ramp: float
) -> tuple[Scenario, Drawn, float]:
    """Return a ramp on a drawn drive, what its belt is, and the error of a tension gauge."""
    random = np.random.default_rng([case.seed, seed])
    duration = _BEGIN + ramp + 0.2
    condition = drawn_condition(random, settings, duration)
    speed = BELTS[case.belt].speed

    def torque(at: float, share: float) -> float:
        return share * condition.capacity(settings, at, speed)

    points = [(1.1, 0.0), (1.3, _BASE)]
    if case.knowledge == LEARNED:
        points += [(2.0, _BASE), (2.6, _VISIT), (3.6, _VISIT), (3.8, _BASE)]
    points += [(_BEGIN, _BASE), (_BEGIN + ramp, _TOP)]
    values: dict[str, object] = {
        "name": case.name,
        "duration": duration,
        "sample_rate": RATE,
        "speed": [[0.0, 0.0], [0.8, speed]],
        "load": [[at, torque(at, share)] for at, share in points],
    }
    gauge = float(random.standard_normal())
    return scenario_of(random, settings, condition, values), condition, gauge


def run_ramp(case: Case, seed: int) -> list[Ramp]:
    """Run one ramp up to gross slip."""
    settings = case.settings(seed)
    ramp = RAMPS[seed % len(RAMPS)]
    scenario, condition, gauge = ramp_scenario(case, settings, seed, ramp)
    monitor = monitor_of(case, settings, float(condition.tension[0]), gauge)
    raw = RawSlip(settings, _BEGIN)
    status: AlarmStatus | None = None
    slipped, learned, held_back = math.nan, 0, 0
    for measurement, truth in measured(settings, scenario):
        now = measurement.stamp_ns * 1e-9
        output = monitor.step(measurement)
        status = output.alarm or status
        raw.take(measurement)
        if now <= _BEGIN and output.estimate is not None:
            learned = int(output.estimate.tension_knowledge is Knowledge.LEARNED)
        held_back |= status is not None and any(
            each.active and each.condition >= Condition.SENSOR_STALE for each in status.conditions
        )
        if now >= _BEGIN and truth.gross_slip:
            slipped = now
            break
    warned, about = _warning(status)
    return [
        Ramp(
            METHOD,
            case.name,
            seed,
            SOURCES,
            ramp,
            _BEGIN,
            slipped,
            warned,
            about,
            learned,
            int(held_back),
            tuple(raw.crossed.tolist()),
        )
    ]


def _warning(status: AlarmStatus | None) -> tuple[float, int]:
    """When the first of the alarms of the belt that are on rose on the ramp, and its condition."""
    on = [
        (each.first_ns * 1e-9, int(each.condition))
        for each in (status.conditions if status else ())
        if each.active and each.condition in OF_THE_BELT and each.first_ns * 1e-9 >= _BEGIN
    ]
    return min(on, default=(math.nan, int(Condition.NONE)))


def jobs(runs: int, containing: str = "") -> list[Task[Ramp]]:
    """Return `runs` ramps of every case whose name contains a text, the first of all first."""
    cases = [Case(*key) for key in _keys()]
    return [
        Task(METHOD, case.name, seed, run_ramp, (case, seed))
        for seed in range(runs)
        for case in cases
        if containing in case.name
    ]


def _keys() -> list[tuple[str, float, str]]:
    return [
        (belt, stiffness, knowledge)
        for belt in BELTS
        for stiffness in STIFFNESSES
        for knowledge in KNOWLEDGE
    ]


_CROSSED = Ramp._fields.index("crossed")


def _fields(row: Ramp) -> list[str]:
    crossed = " ".join(f"{value:.2f}" for value in row.crossed)
    return [
        *(number(value) if isinstance(value, float) else str(value) for value in row[:_CROSSED]),
        crossed,
    ]


def _row(fields: list[str]) -> Ramp:
    method, case, seed, sources, ramp, began, slipped, warned, about, learned, held, crossed = (
        fields
    )
    times = tuple(map(float, crossed.split()))
    assert len(times) == THRESHOLDS.size
    return Ramp(
        method,
        case,
        int(seed),
        sources,
        float(ramp),
        float(began),
        float(slipped),
        float(warned),
        int(about),
        int(learned),
        int(held),
        times,
    )


FORM = Format(Ramp._fields, _fields, _row)
