"""The life campaign: the estimator through each phase of a drive's life, and after it."""

import dataclasses
import math
import time
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation import Measurement, Phase, Rejection
from belt_ros.rig import Truth, measured
from belt_ros.rig.scenario import Scenario
from belt_ros.settings import DriveSettings
from benchmarks.estimation.campaign import Task
from benchmarks.estimation.cells import BELTS, cell_settings
from benchmarks.estimation.draws import Condition, drawn_condition, scenario_of
from benchmarks.estimation.judged import INTERVALS, SOURCES, of_estimate, of_truth
from benchmarks.estimation.life_scripts import BEGIN, DURATION, SCRIPTS, Points, Script
from benchmarks.estimation.statistics import TWO_SIDED_95
from benchmarks.estimation.store import Format, number

METHOD = "belt_ros"
RATE = 100.0  # [Hz]
_JUDGED_EVERY = 10  # samples
_STAYS_RIGHT = 0.5  # [s]
_TENSION_LOST_OVER = 0.1  # [s]


class Life(NamedTuple):
    """What came of one run through one phase."""

    method: str
    case: str  # the phase
    seed: int
    sources: str
    drive: str
    judged: int  # instants during the phase
    held: tuple[int, ...]  # of them, by quantity of `INTERVALS`
    slip_width: float  # median stated deviation of slip during the phase
    right_after: float  # [s] from the end of the phase; NaN: not by the end of the run
    watched: float  # [s] from the end of the phase to that of the run
    not_numbers: int  # samples at which something judged was no number
    rejected: int  # samples turned away
    lost: int  # samples in phase LOST
    resets: int  # of the filter
    microseconds: float  # of processor a sample, median


def life_scenario(script: Script, settings: DriveSettings, seed: int) -> Scenario:
    """Return a script played on a drive that is a draw from its priors.

    While creep develops, its slip is beside it as far as the estimator takes it to be.
    """
    cell = script.cell(seed)
    random = np.random.default_rng([cell.seed, seed])
    condition = drawn_condition(random, settings, DURATION)
    speed = BELTS[cell.belt].speed
    values: dict[str, object] = {
        "name": script.name,
        "condition.undeveloped_creep": 1.0,
        "duration": DURATION,
        "sample_rate": RATE,
        "speed": [[at, share * speed] for at, share in script.speed],
        "load": _load(script.load, settings, condition, speed),
    }
    lost = np.interp(condition.times, (BEGIN, BEGIN + _TENSION_LOST_OVER), (1, script.tension_left))
    weakened = condition._replace(tension=condition.tension * lost)
    return scenario_of(random, settings, weakened, values)


def _load(
    points: Points, settings: DriveSettings, condition: Condition, speed: float
) -> list[list[float]]:
    """Points of the load [N m]; see `Script`."""
    per_deceleration = settings.drive.driven.inertia * speed
    load = []
    for at, share, *decelerations in points:
        torque = share * condition.capacity(settings, at, speed)
        load.append([at, torque + per_deceleration * sum(decelerations)])
    return load


def life_samples(
    script: Script, settings: DriveSettings, seed: int
) -> Iterator[tuple[Measurement, Truth]]:
    """Run a script on the rig, with the sensors that it takes away."""
    begin, end = script.span
    absent: dict[str, Any] = dict.fromkeys(script.missing, math.nan)
    for measurement, truth in measured(settings, life_scenario(script, settings, seed)):
        during = begin <= measurement.stamp_ns * 1e-9 < end
        if during and script.silent:
            continue
        yield (dataclasses.replace(measurement, **absent) if during else measurement), truth


def run_script(script: Script, seed: int) -> list[Life]:
    """Judge the estimator on one draw of a phase."""
    settings = cell_settings(script.cell(seed))
    monitor = settings.monitor()
    watch = Watch(script.span)
    lost, seconds = 0, []
    for count, (measurement, truth) in enumerate(life_samples(script, settings, seed)):
        began = time.process_time()
        monitor.step(measurement)
        seconds.append(time.process_time() - began)
        estimate = monitor.estimate
        assert estimate is not None, "the rig's first measurement is a good one"
        stated, true = of_estimate(estimate), of_truth(truth)
        z = np.array([(stated[n].value - true[n]) / stated[n].stddev for n in INTERVALS])
        watch.see(count, measurement.stamp_ns * 1e-9, z, stated["slip"].stddev)
        lost += estimate.phase is Phase.LOST
    health = monitor.health
    return [
        Life(
            METHOD,
            script.name,
            seed,
            SOURCES,
            script.cell(seed).name,
            watch.judged,
            tuple(watch.held.tolist()),
            float(np.median(watch.widths)) if watch.widths else math.nan,
            watch.right_after,
            DURATION - script.span[1],
            watch.not_numbers,
            sum(health.rejections) - health.rejections[Rejection.NONE],
            lost,
            health.resets,
            float(np.median(seconds)) * 1e6,
        )
    ]


class Watch:
    """Counts how intervals hold through a phase, and when they hold again after it."""

    def __init__(self, span: tuple[float, float]) -> None:
        self._begin, self._end = span
        self._right_since: float | None = None
        self.judged = 0
        self.held = np.zeros(len(INTERVALS), dtype=np.int64)
        self.widths: list[float] = []
        self.right_after = math.nan
        self.not_numbers = 0

    def see(self, count: int, now: float, z: NDArray[np.float64], slip_width: float) -> None:
        """Take in the normalised errors (quantities,) of one sample."""
        inside = np.abs(z) < TWO_SIDED_95
        self.not_numbers += not np.all(np.isfinite(z))
        if self._begin <= now < self._end:
            if count % _JUDGED_EVERY == 0:
                self.judged += 1
                self.held += inside
                self.widths.append(slip_width)
        elif now >= self._end and math.isnan(self.right_after):
            self._follow(now, right=bool(np.all(inside)))

    def _follow(self, now: float, *, right: bool) -> None:
        if not right:
            self._right_since = None
            return
        since = self._right_since = now if self._right_since is None else self._right_since
        if now - since >= _STAYS_RIGHT - 1e-9:
            self.right_after = since - self._end


def jobs(runs: int, containing: str = "") -> list[Task[Life]]:
    """Return `runs` runs of every phase whose name contains a text, the first of all first."""
    return [
        Task(METHOD, script.name, seed, run_script, (script, seed))
        for seed in range(runs)
        for script in SCRIPTS
        if containing in script.name
    ]


_HELD = Life._fields.index("held")


def _fields(life: Life) -> list[str]:
    values = (*life[:_HELD], *life.held, *life[_HELD + 1 :])
    return [number(value) if isinstance(value, float) else str(value) for value in values]


def _row(fields: list[str]) -> Life:
    method, case, seed, sources, drive, judged, *rest = fields
    count = len(INTERVALS)
    held, (width, after, watched, *counts, microseconds) = rest[:count], rest[count:]
    not_numbers, rejected, lost, resets = map(int, counts)
    return Life(
        method,
        case,
        int(seed),
        sources,
        drive,
        int(judged),
        tuple(map(int, held)),
        float(width),
        float(after),
        float(watched),
        not_numbers,
        rejected,
        lost,
        resets,
        float(microseconds),
    )


FORM = Format(
    (*Life._fields[:_HELD], *(f"{name}_held" for name in INTERVALS), *Life._fields[_HELD + 1 :]),
    _fields,
    _row,
)
