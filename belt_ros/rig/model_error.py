"""In what a drive of the rig differs from the model, beside tension and friction.

Both errors of its creep are drawn as the estimator takes them to be: one relative to creep, which
becomes another with time and load, and one beside it, while creep develops on the arcs. But no draw
lets a belt slip against the power, which the estimator takes for a sensor's fault.
"""

import math
from dataclasses import dataclass

import numpy as np

from belt_ros.estimation.assumptions import setting
from belt_ros.estimation.process import UndevelopedCreep
from belt_ros.mechanics.constants import DriveConstants

_BOUND = 0.8  # of the relative error ...
_BOUND_BESIDE = 0.5  # ... and of the slip beside creep


@dataclass(frozen=True)
class ModelError:
    """In what the drive differs from the model, beside tension and friction."""

    ratio_bias: float = setting(0.0, "relative error of R1/R2", "-", -0.1, 0.1)
    creep_error: float = setting(0.0, "relative error of the creep, mean", "-", -0.5, 0.5)
    creep_error_stddev: float = setting(0.0, "its wander about the mean", "-", 0.0, 0.2)
    creep_error_time: float = setting(20.0, "correlation time of the wander", "s", 0.1, 1e6)
    creep_error_pull: float = setting(
        1e12, "change of the pull over which it becomes another", "N", 1.0, 1e15
    )
    undeveloped_creep: float = setting(
        0.0,
        "slip beside creep while that develops, standard deviation over what is allowed for it",
        "-",
        0.0,
        10.0,
    )


class CreepErrors:
    """Both errors of a drive's creep, as they wander.

    Parameters
    ----------
    error : ModelError
    constants : DriveConstants
    random : numpy.random.Generator

    Attributes
    ----------
    relative : float
        Error of the creep that belongs to the pull, relative to it [-].
    beside : float
        Slip beside that creep [-].
    """

    def __init__(
        self, error: ModelError, constants: DriveConstants, random: np.random.Generator
    ) -> None:
        self._error = error
        self._random = random
        self._developing = UndevelopedCreep(constants)
        self._pull = 0.0
        self.relative = _bounded(error.creep_error + self._drawn(error.creep_error_stddev))
        self.beside = 0.0

    def start(self, pull: float) -> None:
        """Begin with creep developed, at `pull` [N]."""
        self._pull = pull
        self._developing.start(pull, developed=pull)

    def advance(self, pull: float, slip_per_pull: float, speed: float, dt: float) -> None:
        """Let both wander over `dt` [s], from a pull [N] at a rim speed [m/s] on.

        `slip_per_pull` [1/N] is that of steady creep.
        """
        error = self._error
        changed = abs(pull - self._pull) / error.creep_error_pull
        self._pull = pull
        memory = math.exp(-dt / error.creep_error_time - changed)
        self.relative = _bounded(
            error.creep_error
            + memory * (self.relative - error.creep_error)
            + math.sqrt(1.0 - memory * memory) * self._drawn(error.creep_error_stddev)
        )
        if error.undeveloped_creep > 0.0:
            renewed, deviation, _ = self._developing.advance(pull, slip_per_pull, speed, dt)
            gained = math.sqrt(renewed * (2.0 - renewed)) * error.undeveloped_creep * deviation
            beside = (1.0 - renewed) * self.beside + self._drawn(gained)
            # In all, no belt slips against the power.
            least = -slip_per_pull * pull * (1.0 + self.relative)
            beside = max(beside, least) if pull >= 0.0 else min(beside, least)
            self.beside = _bounded(beside, _BOUND_BESIDE)

    def _drawn(self, stddev: float) -> float:
        return stddev * float(self._random.standard_normal())


def _bounded(error: float, bound: float = _BOUND) -> float:
    return min(max(error, -bound), bound)
