"""The cost of a step, beside that of filterpy's unscented filter with an empty model.

Both are timed by turns in one process, so that whatever else the machine does meets them alike.
"""

import time
from collections.abc import Callable, Sequence
from statistics import fmean, median
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation import BeltFilter, Measurement
from belt_ros.estimation.state import STATES
from belt_ros.mechanics import torque_capacity
from belt_ros.rig import measured
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.settings import DriveSettings
from benchmarks.estimation.campaign import Task
from benchmarks.estimation.cells import BELTS, Cell, cell_settings
from benchmarks.estimation.draws import speeds_and_torques
from benchmarks.estimation.judged import SOURCES
from benchmarks.estimation.kalman import stock
from benchmarks.estimation.model import SENSED
from benchmarks.estimation.store import Format, number

SETTLED, ALIVE = "settled", "whole bank alive"
LIMITS = {SETTLED: 1.0, ALIVE: 5.0}  # of a step over filterpy's
STEP, FILTER = "BeltMonitor.step", "predict and update of every measurement"
_STIFFNESS = 8.1e7  # [N/m2]
_RATE = 100.0  # [Hz]
_SETTLING = 40.0  # [s] of running until the drive counts as settled
_LEVELS = (0.3, 0.8, 0.5) * 3  # of the capacity
_BLOCK = 20  # steps timed at a time
_BLOCKS = 40
_WARM = 10  # steps after a start that are not timed

_Floats = NDArray[np.float64]
_Step = Callable[[Measurement], None]


class Cost(NamedTuple):
    """One repeat of one measurement."""

    method: str
    case: str  # belt, part
    seed: int  # number of the repeat
    sources: str
    own: float  # median [us]
    mean: float  # [us], with what is done only now and then
    stock: float  # median [us], filterpy with an empty model
    members: int  # Gaussians alive at the end; -1: not known


class _Monitor:
    """Everything: checks, filter, readings, alarm."""

    members = -1

    def __init__(self, settings: DriveSettings) -> None:
        self._monitor = settings.monitor()

    def __call__(self, measurement: Measurement) -> None:
        """Take in a measurement."""
        self._monitor.step(measurement)


class _Filter:
    """The filter alone."""

    def __init__(self, settings: DriveSettings) -> None:
        self._filter = BeltFilter(settings.drive, settings.prior, settings.noise, settings.drift)

    @property
    def members(self) -> int:
        """Number of Gaussians alive."""
        return self._filter.members

    def __call__(self, measurement: Measurement) -> None:
        """Take in a measurement."""
        if self._filter.stamp_ns is None:
            self._filter.start(measurement)
        else:
            self._filter.predict(measurement)
            self._filter.update()


METHODS: dict[str, type[_Monitor] | type[_Filter]] = {STEP: _Monitor, FILTER: _Filter}


def run_cost(method: str, belt: str, part: str, seed: int) -> list[Cost]:
    """Time one drive by one method."""
    settings = cell_settings(Cell(belt, _STIFFNESS, 0.8, "fine"))
    samples = _drive(settings, BELTS[belt].speed, seed)
    make = METHODS[method]
    warm = round(_SETTLING * _RATE) if part == SETTLED else _WARM
    empty = _empty()
    step = None
    own: list[float] = []
    others: list[float] = []
    for block in range(_BLOCKS):
        if step is None or part == ALIVE:
            step = make(settings)
            for measurement in samples[:warm]:
                step(measurement)
        begin = warm + (block * _BLOCK if part == SETTLED else 0)
        chosen = samples[begin : begin + _BLOCK]
        own += _timed(step, chosen)
        others += _timed(empty, chosen)
    assert step is not None
    case = f"{belt}, {part}"
    times = (median(own), fmean(own), median(others))
    return [Cost(method, case, seed, SOURCES, *times, step.members)]


def _drive(settings: DriveSettings, speed: float, seed: int) -> list[Measurement]:
    """Measurements of a drive that idles, is loaded in levels, and goes on at the last of them."""
    capacity = float(torque_capacity(settings.drive, settings.prior.tension, speed))
    load = [[0.0, 0.0]]
    for level, share in enumerate(_LEVELS):
        begin = 1.0 + 2.0 * level
        load += [[begin, load[-1][1]], [begin + 0.2, share * capacity]]
    values: dict[str, object] = {
        "duration": _SETTLING + _BLOCK * _BLOCKS / _RATE,
        "sample_rate": _RATE,
        "seed": float(seed),
        "speed": speed,
        "load": load,
    }
    scenario = scenario_from_mapping(values, settings)
    return [measurement for measurement, _ in speeds_and_torques(measured(settings, scenario))]


def _empty() -> _Step:
    """filterpy's filter of as many states and sensors, with nothing in its model."""
    kalman = stock(lambda x, _dt: x, STATES)
    kalman.R = np.eye(len(SENSED))
    reading = np.zeros(len(SENSED))

    def step(_: Measurement) -> None:
        kalman.predict()
        kalman.update(reading)

    return step


def _timed(step: _Step, measurements: Sequence[Measurement]) -> list[float]:
    """Return how long each step takes [us]."""
    seconds = []
    for measurement in measurements:
        began = time.perf_counter_ns()
        step(measurement)
        seconds.append((time.perf_counter_ns() - began) * 1e-3)
    return seconds


def jobs(runs: int, containing: str = "") -> list[Task[Cost]]:
    """Return `runs` repeats of every measurement whose drive's name contains a text."""
    return [
        Task(method, f"{belt}, {part}", seed, run_cost, (method, belt, part, seed))
        for seed in range(runs)
        for belt in BELTS
        for part in LIMITS
        for method in METHODS
        if containing in f"{belt}, {part}"
    ]


def _fields(cost: Cost) -> list[str]:
    return [number(value) if isinstance(value, float) else str(value) for value in cost]


def _row(fields: list[str]) -> Cost:
    method, case, seed, sources, *times, members = fields
    own, mean, other = map(float, times)
    return Cost(method, case, int(seed), sources, own, mean, other, int(members))


FORM = Format(Cost._fields, _fields, _row)
