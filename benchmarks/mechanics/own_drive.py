"""The paper's drive in the project's own finite element simulator."""

import numpy as np

from belt_ros.mechanics.finite_element import ArcDistribution, FiniteElementRun, History, simulate
from belt_ros.mechanics.finite_element_mesh import Discretisation
from benchmarks.mechanics.clock import timed
from benchmarks.mechanics.drive_run import (
    END,
    INSTALLED,
    SPEED,
    TORQUE,
    WINDOW,
    ArcProfile,
    DriveRun,
    paper_drive,
    rise,
)

ELEMENTS_OF_LOOP = 6  # half pulleys' lengths in the whole belt: two arcs, two spans of two


def run_own(friction_stiffness: float, elements: int) -> DriveRun:
    """Run the drive with about so many elements in the whole belt."""
    drive = paper_drive(friction_stiffness)
    time = np.linspace(0.0, END, 1001)
    history = History(time, SPEED * rise(time), TORQUE * rise(time))
    mesh = Discretisation(elements_per_half_pulley=elements // ELEMENTS_OF_LOOP)
    runs: list[FiniteElementRun] = []
    seconds = timed(
        lambda: runs.append(simulate(drive, history, INSTALLED, mesh, average_over=WINDOW))
    )
    run = runs[0]
    last = run.time > END - WINDOW
    return DriveRun(
        solver="belt_ros",
        elements=run.elements,
        friction_stiffness=friction_stiffness,
        seconds=seconds,
        slack_tension=float(np.mean(run.slack_tension[last])),
        tight_tension=float(np.mean(run.tight_tension[last])),
        driven_speed=float(np.mean(run.driven_speed[last])),
        driven=_profile(run.driven_arc),
        driver=_profile(run.driver_arc),
    )


def _profile(arc: ArcDistribution) -> ArcProfile:
    return ArcProfile(arc.angle, arc.friction)
