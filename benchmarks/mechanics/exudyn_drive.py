"""The paper's drive in Exudyn, an optional peer: load it, run it, read it.

The belt is put on by a static solution without friction; then friction is set and time runs.
"""

import importlib
import importlib.util
import math
import sys
import types
from typing import Any

import numpy as np

from benchmarks.mechanics.clock import Seconds, timed
from benchmarks.mechanics.drive_run import (
    END,
    FRICTION,
    RADIUS,
    SPAN,
    WINDOW,
    ArcProfile,
    DriveRun,
    Floats,
    bin_middles,
)
from benchmarks.mechanics.exudyn_model import SEGMENTS, Choices, Model, build_model


class ExudynMissingError(RuntimeError):
    """Exudyn cannot be imported."""


def load_exudyn() -> types.ModuleType:
    """Import Exudyn's fast build, the one without range checks.

    Raises
    ------
    ExudynMissingError
        If it is not installed.
    """
    if importlib.util.find_spec("exudyn") is None:
        raise ExudynMissingError("Exudyn is not installed; `pip install exudyn` (1.13), then again")
    vars(sys)["exudynFast"] = True
    return importlib.import_module("exudyn")


def run_exudyn(friction_stiffness: float, elements: int, choices: Choices) -> DriveRun:
    """Run the drive; the time is that of Exudyn's static and dynamic solutions alone.

    Raises
    ------
    ExudynMissingError
        If Exudyn is not installed.
    """
    model = build_model(load_exudyn(), friction_stiffness, elements, choices)
    seconds = timed(lambda: _solve(model, friction_stiffness, choices))
    return _read(model, friction_stiffness, elements, seconds)


def _settings(exu: Any, choices: Choices) -> Any:
    """Return Exudyn's settings for its own belt drives: sparse, modified Newton, one thread."""
    settings = exu.SimulationSettings()
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.parallel.numberOfThreads = 1
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 1e-3
    static = settings.staticSolver
    static.verboseMode = 0
    static.numberOfLoadSteps = 10
    static.adaptiveStep = False
    static.loadStepGeometric = True
    static.loadStepGeometricRange = 1e4
    static.stabilizerODE2term = 1e5
    static.newton.relativeTolerance = 1e-6
    static.newton.absoluteTolerance = 1e-6
    dynamic = settings.timeIntegration
    dynamic.verboseMode = 0
    dynamic.endTime = END
    dynamic.numberOfSteps = round(END / choices.step)
    dynamic.newton.useModifiedNewton = True
    dynamic.newton.relativeTolerance = 1e-6
    dynamic.discontinuous.iterationTolerance = 1e-3
    dynamic.discontinuous.maxIterations = 3
    return settings


def _solve(model: Model, friction_stiffness: float, choices: Choices) -> None:
    """Put the belt on, then run."""
    exu, system = model.exu, model.system
    settings = _settings(exu, choices)
    _activate(system, [model.drive], active=False)
    system.SolveStatic(settings, updateInitialValues=True)
    for contact in (contact for row in model.contacts for contact in row):
        system.SetObjectParameter(contact, "frictionCoefficient", FRICTION)
        system.SetObjectParameter(contact, "frictionStiffness", friction_stiffness * model.segment)
    _activate(system, model.holds, active=False)
    _activate(system, [model.drive], active=True)
    system.SolveDynamic(settings, solverType=exu.DynamicSolverType.TrapezoidalIndex2)


def _activate(system: Any, connectors: list[int], *, active: bool) -> None:
    for connector in connectors:
        system.SetObjectParameter(connector, parameterName="activeConnector", value=active)


def _read(model: Model, stiffness: float, elements: int, seconds: Seconds) -> DriveRun:
    sensors = model.sensors

    def stored(sensor: int) -> Floats:
        return np.asarray(model.system.GetSensorStoredData(sensor))

    last = stored(sensors.speeds[0])[:, 0] > END - WINDOW
    points = np.array([stored(sensor)[last, 1:3] for sensor in sensors.points])
    middles = np.repeat([stored(sensor)[last, 1] for sensor in sensors.tensions], SEGMENTS, axis=0)
    x, y = points[..., 0], points[..., 1]
    between = (x > 0.1 * SPAN) & (x < 0.9 * SPAN)
    profiles = []
    for index, row in enumerate(sensors.forces):
        friction = np.concatenate(
            [stored(sensor)[last, 1:].reshape(-1, SEGMENTS, 2).swapaxes(0, 1) for sensor in row]
        )
        angle = np.arctan2(y, x - index * SPAN)
        from_inlet = np.mod((-0.5, 0.5)[index] * math.pi - angle, 2.0 * math.pi)
        profiles.append(_profile(from_inlet, friction / model.segment, elements))
    driver, driven = profiles
    return DriveRun(
        solver="Exudyn",
        elements=elements,
        friction_stiffness=stiffness,
        seconds=seconds,
        slack_tension=float(np.mean(middles[between & (y > 0.0)])),
        tight_tension=float(np.mean(middles[between & (y < 0.0)])),
        driven_speed=-float(np.mean(stored(sensors.speeds[1])[last, 1])),
        driven=driven,
        driver=driver,
    )


def _profile(from_inlet: Floats, stress: Floats, elements: int) -> ArcProfile:
    """Average friction over time in bins an element long, as the own simulator does."""
    bins = round(math.pi * RADIUS / (2.0 * (SPAN + math.pi * RADIUS) / elements))
    touching = (stress[..., 1] != 0.0) & (from_inlet < math.pi)
    bin_of = (from_inlet[touching] / math.pi * bins).astype(np.int64)
    total = np.bincount(bin_of, weights=stress[..., 0][touching], minlength=bins)
    count = np.bincount(bin_of, minlength=bins)
    return ArcProfile(bin_middles(bins), -total / count)
