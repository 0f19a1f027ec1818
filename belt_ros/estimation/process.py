"""How the state changes between measurements beside its law of motion: what fades, what is added.

What the belt is (tension, kf, mu) and how far the model is off wander about their priors: over `dt`
each keeps a share of its distance from the prior, its memory, and gains the variance that makes the
prior the stationary spread. Left without data an estimate returns to its prior, and no further.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.assumptions import Drift, Prior
from belt_ros.estimation.load import Activity
from belt_ros.estimation.load_in_step import set_walk
from belt_ros.estimation.state import STATES, Index
from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants
from belt_ros.mechanics.drive import BeltDrive

_Floats = NDArray[np.float64]
_CHANGE_RATE = 0.5  # of ln tension and ln mu while traction is changing [1/sqrt(s)] ...
# ... and how far from the prior that may lead, standard deviation: oil can halve mu, and more
_CHANGE_SPREAD = {Index.LOG_TENSION: 0.4, Index.LOG_FRICTION: 0.6}
_RECENT = 0.05  # [s] over which the rate of winding is taken
_COMPLIANCE_ERROR = 0.3  # of the spans' winding that the law of motion may miss
_LEAST_PULL_ACTIVITY = 0.001
_ONSET = 1.0 / math.sqrt(3.0)  # of a step's change of pull: what an onset at any time in it does
_KNEE = 3.0  # how much more than the tension creep changes, near the knee
# Compiled code wants plain integers.
PULL, UNDEVELOPED = int(Index.PULL), int(Index.UNDEVELOPED)
CREEP_ERROR = int(Index.CREEP_ERROR)
LOG_TENSION, LOG_FRICTION = int(Index.LOG_TENSION), int(Index.LOG_FRICTION)
STANDING = 1e-3  # wear of a belt that stands, relative to one that runs
_RUNNING_ON = 10.0  # [s] of a pause for which the drive is taken to have run on
_WORN = [Index.LOG_TENSION, Index.LOG_STIFFNESS, Index.LOG_FRICTION]
_BELT = slice(Index.LOG_TENSION, Index.TRAVEL)
CreepChange = tuple[float, float, float]  # what `UndevelopedCreep.advance` returns


class Process(NamedTuple):
    """What a step adds to the law of motion."""

    memory: _Floats  # share of the distance from the prior that is kept (12,)
    covariance_before: _Floats  # added before the motion (12, 12): belt, torques, speeds
    variance_after: _Floats  # added after it (12,): pull


def lognormal(mean: float, stddev: float) -> tuple[float, float]:
    """Mean and standard deviation of ln x for a log-normal x of given mean and deviation."""
    variance = math.log1p((stddev / mean) ** 2)
    return math.log(mean) - 0.5 * variance, math.sqrt(variance)


def prior_state(prior: Prior, drive: BeltDrive) -> tuple[_Floats, _Floats]:
    """Mean and standard deviation (12,) of the state before the first measurement."""
    log_tension, log_tension_stddev = lognormal(prior.tension, prior.tension_stddev)
    log_friction, log_friction_stddev = lognormal(
        prior.friction_coefficient, prior.friction_coefficient_stddev
    )
    mean = np.zeros(STATES)
    mean[Index.LOG_TENSION] = log_tension
    mean[Index.LOG_STIFFNESS] = math.log(prior.friction_stiffness)
    mean[Index.LOG_FRICTION] = log_friction
    stddev = np.ones(STATES)
    stddev[Index.PULL] = 0.5 * prior.tension
    stddev[Index.DRIVER_TORQUE] = prior.tension * drive.driver.radius
    stddev[Index.DRIVEN_TORQUE] = prior.tension * drive.driven.radius
    stddev[Index.LOG_TENSION] = log_tension_stddev
    stddev[Index.LOG_STIFFNESS] = prior.friction_stiffness_decades * math.log(10.0)
    stddev[Index.LOG_FRICTION] = log_friction_stddev
    stddev[Index.RATIO_BIAS] = prior.ratio_bias_stddev
    stddev[Index.CREEP_ERROR] = prior.creep_error_stddev
    stddev[Index.UNDEVELOPED] = prior.tension / drive.belt.axial_stiffness
    return mean, stddev


class UndevelopedCreep:
    """How much slip may differ from equilibrium while creep develops on the arcs.

    Creep is that of equilibrium at the present pull only once the belt on the arcs has been
    replaced since the pull changed; until then slip may be off by the creep of that change: the
    belt's strain, and what the contact gives way. While the spans wind up, the compliance that the
    law of motion gives them may be off as well.
    """

    def __init__(self, constants: DriveConstants) -> None:
        self._constants = constants
        self._arc_length = 0.5 * (
            constants.driven_radius * constants.driven_wrap
            + constants.driver_radius * constants.driver_wrap
        )
        self.start(0.0)

    def start(self, pull: float, developed: float = 0.0) -> None:
        """Begin at `pull` [N], the belt on the arcs as if it had come there at `developed` [N].

        That is from rest, if nothing else is said.
        """
        self._developed_pull = developed
        self._recent_pull = pull
        self._pull = pull

    def advance(self, pull: float, slip_per_pull: float, speed: float, dt: float) -> CreepChange:
        """Follow the pull [N] at rim speed [m/s] over `dt` [s].

        `slip_per_pull` [1/N] is that of steady creep.

        Returns
        -------
        renewed : float
            Share of the belt on the arcs that is replaced in `dt`.
        deviation : float
            Standard deviation of slip beside equilibrium [-].
        changed : float
            By how much the pull has changed in the last step [N].
        """
        changed = abs(pull - self._pull)
        self._pull = pull
        renewed = -math.expm1(-speed * dt / self._arc_length)
        self._developed_pull += renewed * (pull - self._developed_pull)
        self._recent_pull -= math.expm1(-dt / _RECENT) * (pull - self._recent_pull)
        behind = slip_per_pull * abs(pull - self._developed_pull)
        winding = abs(pull - self._recent_pull) / _RECENT * self._constants.span_compliance
        missed = _COMPLIANCE_ERROR * winding
        beside = behind + (missed / max(speed, missed) if missed > 0.0 else 0.0)
        return renewed, beside, changed


class Wander(NamedTuple):
    """What every step takes of `Drift` and priors; rows: traction is settled, it is changing."""

    forgetting: _Floats  # (2, 12) [1/s]
    spread: _Floats  # of the prior (2, 12)
    load: float  # greatest wander of a torque, at the rim [N/sqrt(s)]
    pull: float  # greatest wander of the pull beside its law of motion [N/sqrt(s)]
    creep_error_load: float  # change of pull after which the error of creep is another [N]
    creep: float  # wander of creep at a steady load, relative [1/sqrt(s)]


def drift_wander(drift: Drift, spread: _Floats, tension_scale: float) -> Wander:
    """Return what steps take of a drift.

    Parameters
    ----------
    drift : Drift
    spread : ndarray
        Prior standard deviations (12,).
    tension_scale : float
        Tension [N] to which the wander of pull and torques is relative.
    """
    spreads = np.stack([spread, spread])
    rates = np.zeros_like(spreads)
    rates[:, Index.LOG_TENSION] = drift.tension
    rates[:, Index.LOG_STIFFNESS] = drift.friction_stiffness
    rates[:, Index.LOG_FRICTION] = drift.friction_coefficient
    # A tensioner that slips and oil on a pulley look alike: blame neither beforehand.
    for index, farthest in _CHANGE_SPREAD.items():
        spreads[1, index] = max(spread[index], farthest)
        rates[1, index] = _CHANGE_RATE
    forgetting = np.zeros_like(spreads)
    np.divide(0.5 * rates**2, spreads**2, out=forgetting, where=rates > 0.0)
    forgetting[:, Index.CREEP_ERROR] = 1.0 / drift.creep_error_time
    return Wander(
        forgetting,
        spreads,
        drift.torque * tension_scale,
        drift.pull * tension_scale,
        drift.creep_error_load * tension_scale,
        math.hypot(
            math.sqrt(2.0 / drift.creep_error_time) * float(spread[Index.CREEP_ERROR]),
            _KNEE * drift.tension,
            drift.friction_stiffness,
        ),
    )


@compiled
def drift_processes(
    wander: Wander,
    c: DriveConstants,
    activity: Activity,
    undeveloped: CreepChange,
    dt: float,
    change: float,
) -> tuple[Process, Process]:
    """Return what `dt` [s] adds to the law of motion: traction is settled, it is changing.

    Parameters
    ----------
    wander : Wander
    c : DriveConstants
    activity : Activity
        Of the load.
    undeveloped : CreepChange
        From `UndevelopedCreep.advance`.
    dt : float
    change : float
        For how long traction changes, where it is changing [s]: `dt`, or as `lull` has it.
    """
    renewed, deviation, changed = undeveloped
    forgotten = wander.forgetting * dt
    if change != dt:
        for state in (LOG_TENSION, LOG_FRICTION):
            forgotten[1, state] *= change / dt
    forgotten[:, CREEP_ERROR] += changed / wander.creep_error_load
    memory = np.exp(-forgotten)
    gained = -np.expm1(-2.0 * forgotten) * wander.spread**2
    memory[:, UNDEVELOPED] = 1.0 - renewed
    gained[:, UNDEVELOPED] = renewed * (2.0 - renewed) * deviation**2
    most = max(activity.taken[0], activity.taken[1])
    # A load that sets in within a step winds the spans at its end as if it had all along.
    onset = _ONSET * most * min(most, 1.0) * wander.load
    gained[:, PULL] = onset**2 * dt
    before = np.zeros((2, STATES, STATES))
    for mode in range(2):
        for state in range(STATES):
            before[mode, state, state] = gained[mode, state]
        set_walk(before[mode], wander.load, c, activity, dt)
    motion = np.zeros(STATES)
    motion[PULL] = (min(max(most, _LEAST_PULL_ACTIVITY), 1.0) * wander.pull) ** 2 * dt
    return Process(memory[0], before[0], motion), Process(memory[1], before[1], motion)


def wear(pause: float) -> float:
    """Return after how long a run [s] a belt is what it is after a pause of the data [s].

    Data pause because messages are lost, for seconds, or because the drive has been switched off; a
    belt that stands is not worn, heated or shaken, and ages as its memory in a file does.
    """
    return min(pause, _RUNNING_ON) + STANDING * max(pause - _RUNNING_ON, 0.0)


def gap_processes(
    wander: Wander, c: DriveConstants, prior_stddev: _Floats, gap: float, worn: float
) -> tuple[Process, Process]:
    """Return what a gap of `gap` [s] in the data does: traction is settled, it is changing.

    What the belt is ages as in a run of `worn` [s]; the model's error is another one with time. All
    that moves begins anew at its prior, (12,) `prior_stddev` wide.
    """
    moving = np.ones(STATES, dtype=np.bool_)
    moving[_BELT] = False
    undeveloped = 1.0, float(prior_stddev[UNDEVELOPED]), 0.0
    if worn != gap:
        forgetting = wander.forgetting.copy()
        forgetting[:, _WORN] *= worn / gap
        wander = wander._replace(forgetting=forgetting)
    processes = drift_processes(wander, c, Activity((1.0, 1.0), (1.0, 1.0)), undeveloped, gap, gap)
    for process in processes:
        process.memory[moving] = 0.0
        process.covariance_before[moving, :] = process.covariance_before[:, moving] = 0.0
        process.covariance_before[moving, moving] = prior_stddev[moving] ** 2
    return processes
