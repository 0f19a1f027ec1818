"""The belt as it was installed: what a loss of traction is told against.

It is what was told, until the belt is re-tensioned or replaced. Nothing else moves it: neither a
measurement of the tension, nor a calibration, nor the end of a run. A loss would vanish with it.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from belt_ros.estimation.gaussian_sum import Component, normalised
from belt_ros.estimation.state import Index

_GREATEST = 100.0  # of a logarithm


class Installed(NamedTuple):
    """A belt as it was installed."""

    tension: float  # as told, or set at maintenance [N]; for people
    log_tension: float  # mean of ln T, and ...
    log_friction: float  # ... of ln mu of the driven pulley

    @property
    def possible(self) -> bool:
        """Whether a belt can be so."""
        logarithms = self.log_tension, self.log_friction
        return 0.0 < self.tension < math.inf and all(abs(each) <= _GREATEST for each in logarithms)


def installed_as(belief: Sequence[Component], tension: float) -> Installed:
    """Return a belt that was installed as a belief over the state has it, told as `tension` [N]."""
    weights = normalised(np.array([member.log_weight for member in belief]))
    mean = weights @ np.stack([member.mean for member in belief])
    return Installed(tension, float(mean[Index.LOG_TENSION]), float(mean[Index.LOG_FRICTION]))
