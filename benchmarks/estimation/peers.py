"""Other estimators on the same draws: today's practice, one Gaussian, many particles."""

from collections.abc import Callable
from functools import partial

from belt_ros.rig import measured
from belt_ros.settings import DriveSettings
from benchmarks.estimation.campaign import Job
from benchmarks.estimation.cells import Cell, cell_settings, some_cells
from benchmarks.estimation.draws import JUDGED_AT, drawn_scenario, speeds_and_torques
from benchmarks.estimation.judged import Estimator, Own, Row, judge
from benchmarks.estimation.kalman import Empty, Extended, Stock
from benchmarks.estimation.particle import Particles
from benchmarks.estimation.today import Today

OWN, EMPTY = "belt_ros", "filterpy UKF, empty"
PARTICLES = (2000, 4000, 8000)

Maker = Callable[[DriveSettings, int], Estimator]


def _particles(count: int, settings: DriveSettings, seed: int) -> Estimator:
    return Particles(settings, count, seed)


METHODS: dict[str, Maker] = {
    "speed ratio, Euler-Eytelwein": lambda settings, _seed: Today(settings),
    "EKF": lambda settings, _seed: Extended(settings),
    "filterpy UKF": lambda settings, _seed: Stock(settings),
    OWN: lambda settings, _seed: Own(settings),
    **{f"{count} particles": partial(_particles, count) for count in PARTICLES},
    EMPTY: lambda _settings, _seed: Empty(),
}


def run_method(method: str, cell: Cell, seed: int) -> list[Row]:
    """Judge one method on one draw of a cell."""
    settings = cell_settings(cell)
    samples = speeds_and_torques(measured(settings, drawn_scenario(cell, settings, seed)))
    return judge(METHODS[method](settings, seed), samples, JUDGED_AT, method, cell.name, seed)


def jobs(runs: int, containing: str = "") -> list[Job]:
    """Return `runs` runs of every method on every compared cell whose name contains a text."""
    return [
        Job(method, cell.name, seed, run_method, (method, cell, seed))
        for seed in range(runs)
        for cell in some_cells()
        if containing in cell.name
        for method in METHODS
    ]
