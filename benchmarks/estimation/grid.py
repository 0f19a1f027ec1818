"""The grid campaign: the estimator on drives of the rig that are as it was told."""

from collections.abc import Callable
from functools import partial

from belt_ros.rig import measured
from benchmarks.estimation.campaign import Job
from benchmarks.estimation.cells import Cell, all_cells, cell_settings
from benchmarks.estimation.draws import JUDGED_AT, drawn_scenario, speeds_and_torques
from benchmarks.estimation.judged import Own, Row, judge

METHOD = "belt_ros"


def run_cell(cell: Cell, seed: int, *, of_true_capacity: bool = False) -> list[Row]:
    """Judge the estimator on one draw of a cell."""
    settings = cell_settings(cell)
    scenario = drawn_scenario(cell, settings, seed, of_true_capacity=of_true_capacity)
    samples = speeds_and_torques(measured(settings, scenario))
    return judge(Own(settings), samples, JUDGED_AT, METHOD, cell.name, seed)


def jobs(runs: int, containing: str = "") -> list[Job]:
    """Return `runs` runs of every cell whose name contains a text, the first of all cells first."""
    return _jobs(runs, containing, run_cell)


def near_jobs(runs: int, containing: str = "") -> list[Job]:
    """Return the same where levels of the load are shares of the true capacity."""
    return _jobs(runs, containing, partial(run_cell, of_true_capacity=True))


def _jobs(runs: int, containing: str, call: Callable[[Cell, int], list[Row]]) -> list[Job]:
    chosen = [cell for cell in all_cells() if containing in cell.name]
    return [
        Job(METHOD, cell.name, seed, call, (cell, seed)) for seed in range(runs) for cell in chosen
    ]
