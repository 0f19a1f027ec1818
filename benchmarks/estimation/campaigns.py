"""What there is to run: for each campaign its jobs, its rows, and what is made of them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from benchmarks.estimation import (
    cost,
    cost_report,
    elements,
    grid,
    grid_report,
    life,
    life_report,
    life_scripts,
    peers,
    peers_report,
    report,
)
from benchmarks.estimation.campaign import Task
from benchmarks.estimation.draws import DURATION, JUDGED_AT, RATE
from benchmarks.estimation.store import ROWS, Format

Files = dict[str, Figure | str]


def _no_files(_: list[Any]) -> Files:
    return {}


@dataclass(frozen=True)
class Campaign:
    """What one sub-command does; the kind of its rows is that of its format."""

    name: str
    title: str
    about: str
    runs: int  # of each cell, unless asked otherwise
    jobs: Callable[[int, str], list[Task[Any]]]
    form: Format[Any]
    sections: Callable[[list[Any]], list[str]]
    files: Callable[[list[Any]], Files] = _no_files
    alone: bool = False  # one process, since time is what is measured


_INSTANTS = ", ".join(f"{instant:g}" for instant in JUDGED_AT)
_A_RUN = (
    f"A run is {DURATION:g} s at {RATE:g} Hz of a drive drawn from the priors (ln T 0.3, ln kf "
    "0.7, ln mu 0.05, creep error 3 %, ratio bias 2e-4) that wanders as the drift parameters say, "
    "its slip beside creep while that develops as far as is allowed for, "
    f"judged at {_INSTANTS} s, late in each of three levels of the load, by speeds and torques. "
    "The estimator's model is the rig's."
)
CAMPAIGNS = (
    Campaign(
        "grid",
        "The estimator on a grid of kf and load",
        "Three belts, five kf, four peak loads (shares of the capacity that the estimator is told, "
        "the peak first; drives that would slip through it are drawn again), two levels of noise. "
        f"{_A_RUN} z: error over stated deviation; +/-: 95 %, taking all instants of a run as one; "
        "NEES: from the whole covariance of ln T, ln kf and ln mu.",
        200,
        grid.jobs,
        ROWS,
        grid_report.grid_sections,
        grid_report.grid_files,
    ),
    Campaign(
        "near",
        "The grid, near the true capacity",
        "The same cells, but levels are shares of the drive's true capacity, in any order. No "
        f"estimator is told of that, and exact inference need not hold 95 % here. {_A_RUN}",
        7,
        grid.near_jobs,
        ROWS,
        grid_report.near_sections,
        grid_report.near_files,
    ),
    Campaign(
        "life",
        "The estimator through the life of a drive",
        f"{life_scripts.DURATION:g} s at {life.RATE:g} Hz: run up, loaded to 50, 80 and 50 % of "
        "their true capacity, then one phase, then running on. Drives are drawn from the priors of "
        "the grid, belts, kf and noise levels in turn, but for the loss of tension.",
        20,
        life.jobs,
        life.FORM,
        life_report.life_sections,
        life_report.life_files,
    ),
    Campaign(
        "elements",
        "The estimator on finite element plants",
        "The belt is simulated node by node between fixed centres. Judged at "
        f"{', '.join(f'{instant:g}' for instant in elements.JUDGED_AT)} s; a run is one draw of "
        "the priors about the truth, evenly spread over them, and of the noise. NEES: as if ln T, "
        "ln kf and ln mu were independent.",
        32,
        elements.jobs,
        ROWS,
        report.elements_sections,
    ),
    Campaign(
        "peers",
        "The estimator beside others",
        "The same draws for all, some cells of the grid. Processor time of one core; a step "
        "includes reading quantities and deviations off the filter, but for the particles. "
        "Extended, unscented and particle filter have the estimator's state, process and rules for "
        "the load's noise; the tension is settled for them.",
        4,
        peers.jobs,
        ROWS,
        peers_report.sections,
    ),
    Campaign(
        "cost",
        "The cost of a step",
        "Steps of the estimator and of stock filterpy's UnscentedKalmanFilter (Merwe's points, as "
        "many states, four measurements, an identity for a model) timed by turns in one process. "
        "Settled: after 40 s with nine steps of the load; most steps then only wait, and the mean "
        "has in it what one in ten takes in. Whole bank alive: just started, idle.",
        5,
        cost.jobs,
        cost.FORM,
        cost_report.cost_sections,
        alone=True,
    ),
)
