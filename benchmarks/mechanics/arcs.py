"""Speed of one arc against `scipy.integrate.solve_bvp` at equal accuracy, and of many arcs."""

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from belt_ros.mechanics.arc import solve_arc
from belt_ros.mechanics.arc_state import arc_state
from belt_ros.mechanics.drive import BeltDrive
from belt_ros.mechanics.equilibrium import solve_equilibrium, torque_capacity
from benchmarks.mechanics.arc_cases import ArcCases, Floats, mixed_arcs
from benchmarks.mechanics.boundary_value import Guess, NotSolvedError, ScaledArc, inlet_gradient
from benchmarks.mechanics.clock import median_time

ACCURACIES = (1e-6, 1e-8, 1e-10, 5e-12)  # the last is about what the closed form reaches
TOLERANCES = tuple(10.0**-k for k in range(2, 13))
MESHES = (20, 40)
REPEATS = 5
COPIES = 2000  # of one arc, to time it
MANY = 1_000_000


class BoundaryValueRun(NamedTuple):
    """One attempt of `solve_bvp` at one arc."""

    error: float  # in u'(0), relative
    seconds: float  # processor time


class Comparison(NamedTuple):
    """`solve_bvp` against `solve_arc` where both are at least this accurate in u'(0)."""

    accuracy: float
    solved: int  # arcs on which solve_bvp reaches it
    error: float  # of solve_bvp, the largest
    milliseconds: float  # of solve_bvp, the mean arc
    ratio: float  # of total times
    median_ratio: float
    least_ratio: float


class ArcSpeed(NamedTuple):
    """What the closed form takes and reaches on the confirmed arcs."""

    error: float  # the largest, relative, in u'(0)
    vectorised: float  # [ns] an arc
    compiled: float  # [ns] an arc, called one at a time from Python
    single_call: float  # [ns] `solve_arc` with one arc a call


class Throughput(NamedTuple):
    """Solutions a second on one core."""

    arcs: float
    equilibria: float
    shares: dict[str, float]  # of the regimes among the arcs


def boundary_value_runs(arc: ScaledArc, exact: float, transition: float) -> list[BoundaryValueRun]:
    """Attempt one arc at all tolerances and meshes.

    It starts 5 % from the solution in friction at the transition and 2 % in the transition angle,
    which is more than a user would know.
    """
    begin = 0.98 * transition if transition < arc.wrap else arc.wrap
    guess = Guess(1.05 * exact * math.exp(arc.stretch * (transition - begin)), begin)
    runs = []
    for nodes in MESHES:
        for tolerance in TOLERANCES:
            attempt = partial(inlet_gradient, arc, guess, tolerance, nodes)
            try:
                found = attempt()
            except NotSolvedError:
                continue
            error = abs(found / exact - 1.0)
            runs.append(BoundaryValueRun(error, median_time(attempt, 3, warm=True).processor))
            if error < ACCURACIES[-1]:
                break
    return runs


def compare_arcs(cases: ArcCases) -> list[Comparison]:
    """Time both on the confirmed arcs of one and two zones.

    `solve_bvp` is given, for each arc and accuracy, the tolerance and mesh that get there soonest.
    """
    chosen = [int(index) for index in np.flatnonzero(~cases.resticks)]
    transitions = solve_arc(*cases.arguments).transition_angle
    runs, ours = [], []
    for index in chosen:
        arc, exact = cases.scaled(index)
        runs.append(boundary_value_runs(arc, exact, float(transitions[index])))
        copies = np.repeat(cases.arguments[:, index : index + 1], COPIES, axis=1)
        ours.append(median_time(partial(solve_arc, *copies), REPEATS).processor / COPIES)
    return [_comparison(accuracy, runs, ours) for accuracy in ACCURACIES]


def _comparison(
    accuracy: float, runs: list[list[BoundaryValueRun]], ours: list[float]
) -> Comparison:
    pairs = []
    for attempts, seconds in zip(runs, ours, strict=True):
        if reached := [run for run in attempts if run.error <= accuracy]:
            pairs.append((min(reached, key=lambda run: run.seconds), seconds))
    theirs = np.array([run.seconds for run, _ in pairs])
    own = np.array([seconds for _, seconds in pairs])
    return Comparison(
        accuracy=accuracy,
        solved=len(pairs),
        error=max(run.error for run, _ in pairs),
        milliseconds=1e3 * float(np.mean(theirs)),
        ratio=float(np.sum(theirs) / np.sum(own)),
        median_ratio=float(np.median(theirs / own)),
        least_ratio=float(np.min(theirs / own)),
    )


def arc_speed(cases: ArcCases) -> ArcSpeed:
    """Time the closed form on the confirmed arcs in three ways of calling it."""
    count = cases.gradient.size
    solved = solve_arc(*cases.arguments).inlet_strain_gradient
    tiled = np.tile(cases.arguments, COPIES)
    groups = [_groups(cases, index) for index in range(count)]
    singles = [tuple(column) for column in cases.arguments.T]
    return ArcSpeed(
        error=float(np.max(np.abs(solved / cases.gradient - 1.0))),
        vectorised=_nanoseconds(partial(solve_arc, *tiled), tiled.shape[1]),
        compiled=_nanoseconds(lambda: [arc_state(*group) for group in groups], count),
        single_call=_nanoseconds(lambda: [solve_arc(*single) for single in singles], count),
    )


def _groups(cases: ArcCases, index: int) -> tuple[float, float, float, int]:
    """Return an arc as the compiled `arc_state` takes it."""
    arc, _ = cases.scaled(index)
    traction = arc.sense * math.log(arc.ratio)
    return traction, arc.friction / arc.stretch, arc.stretch * arc.wrap, int(arc.sense)


def _nanoseconds(call: Callable[[], object], count: int) -> float:
    return 1e9 * median_time(call, REPEATS).processor / count


def throughput(drive: BeltDrive) -> Throughput:
    """Solve a mixture of arcs, and of steady states of a drive."""
    mixture = mixed_arcs(MANY)
    arcs = median_time(partial(solve_arc, *mixture), REPEATS).processor
    states = _mixed_states(drive)
    equilibria = median_time(partial(solve_equilibrium, drive, *states), REPEATS).processor
    solved = solve_arc(*mixture)
    resticks = ~np.isnan(solved.restick_angle)
    driven = mixture[0] > 0.0
    regimes = {
        "driven, elastic only": driven & solved.elastic_only,
        "driven, partial slip": driven & ~solved.elastic_only & ~resticks,
        "driven, re-stick": resticks,
        "driver, elastic only": ~driven & solved.elastic_only,
        "driver, partial slip": ~driven & ~solved.elastic_only,
    }
    shares = {name: float(np.mean(chosen)) for name, chosen in regimes.items()}
    return Throughput(MANY / arcs, MANY / equilibria, shares)


def _mixed_states(drive: BeltDrive) -> tuple[Floats, Floats, Floats]:
    """Draw torques up to 99.9 % of the capacity in either sense, tensions and speeds."""
    random = np.random.default_rng(2011)
    tension = random.uniform(200.0, 800.0, MANY)
    speed = random.uniform(-120.0, 120.0, MANY)
    share = random.uniform(-0.999, 0.999, MANY)
    return share * torque_capacity(drive, tension, speed), tension, speed
