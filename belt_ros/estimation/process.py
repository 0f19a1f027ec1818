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
from belt_ros.estimation.state import STATES, Index
from belt_ros.mechanics.constants import DriveConstants
from belt_ros.mechanics.drive import BeltDrive

_Floats = NDArray[np.float64]
_CHANGE_RATE = 0.5  # of ln tension while the tension is changing [1/sqrt(s)] ...
_CHANGE_SPREAD = 0.4  # ... and how far from the prior that may lead, standard deviation
_RECENT = 0.05  # [s] over which the rate of winding is taken
_COMPLIANCE_ERROR = 0.3  # of the spans' winding that the law of motion may miss


class Process(NamedTuple):
    """What a step adds to the law of motion, per state."""

    memory: _Floats  # share of the distance from the prior that is kept (11,)
    belt_variance: _Floats  # added to what the belt is, before the motion (11,)
    motion_variance: _Floats  # added to what moves, after it (11,)


def lognormal(mean: float, stddev: float) -> tuple[float, float]:
    """Mean and standard deviation of ln x for a log-normal x of given mean and deviation."""
    variance = math.log1p((stddev / mean) ** 2)
    return math.log(mean) - 0.5 * variance, math.sqrt(variance)


def prior_state(prior: Prior, drive: BeltDrive) -> tuple[_Floats, _Floats]:
    """Mean and standard deviation (11,) of the state before the first measurement."""
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
    stddev[Index.DRIVER_TORQUE] = stddev[Index.DRIVEN_TORQUE] = prior.tension * drive.driver.radius
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
    replaced since the pull changed; until then slip may be off by the strain of that change. While
    the spans wind up, the compliance that the law of motion gives them may be off as well.
    """

    def __init__(self, constants: DriveConstants) -> None:
        self._constants = constants
        self._arc_length = 0.5 * (
            constants.driven_radius * constants.driven_wrap
            + constants.driver_radius * constants.driver_wrap
        )
        self.start(0.0)

    def start(self, pull: float) -> None:
        """Begin with the belt on the arcs as if it had come from rest, at `pull` [N]."""
        self._developed_pull = 0.0
        self._recent_pull = pull
        self._pull = pull

    def advance(self, pull: float, speed: float, dt: float) -> tuple[float, float]:
        """Follow the pull [N] at rim speed [m/s] over `dt` [s].

        Returns
        -------
        renewed : float
            Share of the belt on the arcs that is replaced in `dt`.
        deviation : float
            Standard deviation of slip beside equilibrium [-].
        """
        renewed = -math.expm1(-speed * dt / self._arc_length)
        self._developed_pull += renewed * (pull - self._developed_pull)
        self._recent_pull -= math.expm1(-dt / _RECENT) * (pull - self._recent_pull)
        behind = abs(pull - self._developed_pull) / self._constants.axial_stiffness
        winding = abs(pull - self._recent_pull) / _RECENT * self._constants.span_compliance
        missed = _COMPLIANCE_ERROR * winding
        return renewed, behind + (missed / max(speed, missed) if missed > 0.0 else 0.0)


def drift_process(
    drift: Drift,
    spread: _Floats,
    tension_scale: float,
    constants: DriveConstants,
    load_activity: float,
    undeveloped: tuple[float, float],
    dt: float,
    *,
    changing: bool,
) -> Process:
    """Return what `dt` [s] adds to the law of motion.

    Parameters
    ----------
    drift : Drift
    spread : ndarray
        Prior standard deviations (11,).
    tension_scale : float
        Tension [N] to which the wander of pull and torques is relative.
    constants : DriveConstants
    load_activity : float
        How fast torques and pull wander, relative to `drift.torque` and `drift.pull`.
    undeveloped : tuple of float
        From `UndevelopedCreep.advance`.
    dt : float
    changing : bool
        Whether the tension is changing now.
    """
    spread = spread.copy()
    rate = np.zeros(STATES)  # of forgetting [1/s]
    if changing:
        spread[Index.LOG_TENSION] = _CHANGE_SPREAD
    wander = {
        Index.LOG_TENSION: _CHANGE_RATE if changing else drift.tension,
        Index.LOG_STIFFNESS: drift.friction_stiffness,
        Index.LOG_FRICTION: drift.friction_coefficient,
    }
    for index, per_second in wander.items():
        rate[index] = 0.5 * (per_second / spread[index]) ** 2
    rate[Index.CREEP_ERROR] = 1.0 / drift.creep_error_time
    renewed, spread[Index.UNDEVELOPED] = undeveloped
    memory = np.exp(-rate * dt)
    memory[Index.UNDEVELOPED] = 1.0 - renewed
    forgotten = -np.expm1(-2.0 * rate * dt)
    forgotten[Index.UNDEVELOPED] = renewed * (2.0 - renewed)
    belt_variance = spread**2 * forgotten
    variance = np.zeros(STATES)
    # A torque that wanders within dt also moves its pulley, and with it the pull.
    torque = (load_activity * drift.torque * tension_scale * constants.driver_radius) ** 2 * dt
    variance[Index.DRIVER_TORQUE] = variance[Index.DRIVEN_TORQUE] = torque
    variance[Index.DRIVER_SPEED] = torque * (dt / constants.driver_inertia) ** 2 / 3.0
    variance[Index.DRIVEN_SPEED] = torque * (dt / constants.driven_inertia) ** 2 / 3.0
    variance[Index.PULL] = (load_activity * drift.pull * tension_scale) ** 2 * dt
    return Process(memory, belt_variance, variance)
