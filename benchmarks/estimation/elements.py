"""Finite element plants: drives that are not the estimator's model, between fixed centres.

A trajectory is simulated once for a process; the estimator then meets it with priors drawn about
the truth and with noise drawn anew.

Steady slip is that of equilibrium to 0.3 %, at the compliant belt's full load to 1.5 %, by its
damping and its mesh. Without more damping than the simulator's default, sliding friction feeds
axial waves at soft contacts, and slip is no longer creep. Speeds and loads change smoothly:
between the pulleys belt and inertia swing for a second and more, because creep follows the pull
only after the belt has travelled an arc, and that takes most of the damping away.

Truth is the same in all runs of a trajectory; what is drawn is where the prior lies about it. Few
independent draws are uneven: of 20, a quantity that nothing tells is held in no more than 17 once
in 13 trajectories, however right its prior is. So priors are drawn evenly, by a scrambled Sobol
sequence: of each error, its first 32 points lie one in each 32nd of the prior, and so do 64.
"""

import dataclasses
import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from scipy.stats import norm
from scipy.stats.qmc import Sobol

from belt_ros.estimation import Measurement, Prior, measurement_from_joints
from belt_ros.estimation.process import lognormal
from belt_ros.mechanics import Tensioning, torque_capacity
from belt_ros.mechanics.finite_element_mesh import Discretisation
from belt_ros.rig import Truth, simulate_finite_elements
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.rig.sensors import SensorErrors, Sensors
from belt_ros.settings import DriveSettings
from benchmarks.estimation.campaign import Job
from benchmarks.estimation.cells import BELTS, STIFFNESSES, Cell, cell_settings
from benchmarks.estimation.judged import Own, Row, judge

METHOD = "belt_ros"
JUDGED_AT = (2.1, 3.9, 5.9)  # [s], late in each level of the load
_DURATION = 6.0  # [s]
_RATE = 200.0  # [Hz]
_SPEED_UP = 0.8  # [s]
_LOADS = ((1.0, 0.2), (2.2, 1.0), (4.0, 0.5))  # begin [s] and share of the peak
_LOAD_CHANGE = 0.4  # [s], several periods of the pulleys against the belt
_POINTS = 40  # of a change
_MOST_RUNS_LOG2 = 10
# 4 % of critical damping, the compliant belt 9 %, in axial waves as long as a span: as of rubber
_STIFF_MESH = Discretisation(50, penalty_ratio=4.0, axial_damping=1.4)
_MESHES = {
    "paper": _STIFF_MESH,
    "conveyor": _STIFF_MESH,
    "compliant": Discretisation(42, penalty_ratio=4.0, axial_damping=2.4),
}

Sample = tuple[int, Truth]


def trajectories() -> list[Cell]:
    """Return the drives and loads that are simulated."""
    paper = [Cell("paper", kf, peak, "fine") for kf in STIFFNESSES for peak in (0.35, 0.6, 0.9)]
    conveyor = [Cell("conveyor", kf, peak, "fine") for kf in (1e7, 8.1e7) for peak in (0.5, 0.9)]
    return [*paper, *conveyor, *(Cell("compliant", 1e7, peak, "fine") for peak in (0.5, 0.9))]


@lru_cache(maxsize=1)
def trajectory(cell: Cell) -> list[Sample]:
    """Simulate a drive whose condition is the cell's own."""
    settings = _settings(cell)
    speed, tension = BELTS[cell.belt].speed, BELTS[cell.belt].tension
    capacity = float(torque_capacity(settings.drive, tension, speed))
    values: dict[str, object] = {
        "duration": _DURATION,
        "sample_rate": _RATE,
        "speed": smooth_change(0.0, _SPEED_UP, 0.0, speed),
        "load": _load(cell.peak * capacity),
    }
    scenario = scenario_from_mapping(values, settings)
    run = simulate_finite_elements(settings, scenario, _MESHES[cell.belt])
    return [(sample.stamp_ns, sample.truth) for sample in run]


def smooth_change(begin: float, duration: float, before: float, after: float) -> list[list[float]]:
    """Return points [time, value] of a change without a step in its first two derivatives."""
    share = np.linspace(0.0, 1.0, _POINTS + 1)
    done = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    points = np.stack([begin + duration * share, before + (after - before) * done], axis=-1)
    return [[float(time), float(value)] for time, value in points]


def _load(peak: float) -> list[list[float]]:
    """Return the load [N m] over time: three levels, judged late in each."""
    points: list[list[float]] = []
    level = 0.0
    for begin, share in _LOADS:
        points += smooth_change(begin, _LOAD_CHANGE, level, share * peak)
        level = share * peak
    return points


def run_trajectory(cell: Cell, seed: int) -> list[Row]:
    """Judge the estimator on a trajectory, with priors and noise of this seed."""
    random = np.random.default_rng([cell.seed, seed])
    settings = _settings(cell)
    prior = _prior_about(settings.prior, prior_errors(cell, seed))
    told = dataclasses.replace(settings, prior=prior)
    samples = _measured(told, trajectory(cell), random)
    return judge(Own(told), samples, JUDGED_AT, METHOD, cell.name, seed)


def jobs(runs: int, containing: str = "") -> list[Job]:
    """Return `runs` draws of priors and noise on every trajectory whose name contains a text."""
    return [
        Job(METHOD, cell.name, seed, run_trajectory, (cell, seed))
        for cell in trajectories()
        if containing in cell.name
        for seed in range(runs)
    ]


def _settings(cell: Cell) -> DriveSettings:
    return cell_settings(cell, tensioning=Tensioning.FIXED_CENTRES.value)


def prior_errors(cell: Cell, seed: int) -> tuple[float, float, float]:
    """By how many deviations the prior of a run errs in ln T, ln mu and ln kf."""
    points = Sobol(3, scramble=True, rng=cell.seed).random_base2(_MOST_RUNS_LOG2)
    tension, friction, stiffness = norm.ppf(points[seed]).tolist()
    return tension, friction, stiffness


def _prior_about(truth: Prior, errors: tuple[float, float, float]) -> Prior:
    """Return what someone who errs so may believe of a drive of this condition."""
    spread = lognormal(truth.tension, truth.tension_stddev)[1]
    tension = _shifted(truth.tension, spread, errors[0])
    friction = _shifted(
        truth.friction_coefficient,
        lognormal(truth.friction_coefficient, truth.friction_coefficient_stddev)[1],
        errors[1],
    )
    decades = truth.friction_stiffness_decades
    median = truth.friction_stiffness * 10.0 ** (decades * errors[2])
    return dataclasses.replace(
        truth,
        tension=tension,
        tension_stddev=truth.tension_stddev * tension / truth.tension,
        friction_coefficient=friction,
        friction_coefficient_stddev=truth.friction_coefficient_stddev
        * friction
        / truth.friction_coefficient,
        friction_stiffness=median,
    )


def _shifted(value: float, log_stddev: float, error: float) -> float:
    """Mean of a log-normal whose median is so many deviations from `value`."""
    return value * math.exp(log_stddev * error + 0.5 * log_stddev**2)


def _measured(
    settings: DriveSettings, samples: list[Sample], random: np.random.Generator
) -> Iterator[tuple[Measurement, Truth]]:
    errors = SensorErrors(**dataclasses.asdict(settings.noise))
    sensors = Sensors(settings.driver, settings.driven, errors, random)
    for stamp_ns, truth in samples:
        joints = sensors.measure(truth, 0.0, 0.0)
        measurement = measurement_from_joints(
            settings.driver,
            settings.driven,
            stamp_ns,
            joints.names,
            joints.velocities,
            joints.efforts,
        )
        assert isinstance(measurement, Measurement), "the rig's joint states are complete"
        yield measurement, truth
