"""The grid campaign: the estimator on drives of the rig that are as it was told."""

from belt_ros.rig import measured
from benchmarks.estimation.campaign import Job
from benchmarks.estimation.cells import Cell, all_cells, cell_settings
from benchmarks.estimation.draws import JUDGED_AT, drawn_scenario, speeds_and_torques
from benchmarks.estimation.judged import Own, Row, judge

METHOD = "belt_ros"


def run_cell(cell: Cell, seed: int) -> list[Row]:
    """Judge the estimator on one draw of a cell."""
    settings = cell_settings(cell)
    samples = speeds_and_torques(measured(settings, drawn_scenario(cell, settings, seed)))
    return judge(Own(settings), samples, JUDGED_AT, METHOD, cell.name, seed)


def jobs(runs: int, containing: str = "") -> list[Job]:
    """Return `runs` runs of every cell whose name contains a text, the first of all cells first."""
    chosen = [cell for cell in all_cells() if containing in cell.name]
    return [
        Job(METHOD, cell.name, seed, run_cell, (cell, seed))
        for seed in range(runs)
        for cell in chosen
    ]
