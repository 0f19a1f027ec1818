"""The members of the filter's Gaussian sum, side by side: moments, weights, and modes.

There are two modes, of each of which a bank holds members: traction is settled, or it is changing.
"""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.bank import UnscentedBank
from belt_ros.estimation.gaussian_sum import Component, mixture_moments, normalised
from belt_ros.estimation.load import Activity
from belt_ros.estimation.one_step import Foretold, take_in_and_weigh
from belt_ros.estimation.process import CreepChange, Process, Wander
from belt_ros.estimation.sensing import Sensed
from belt_ros.estimation.smoother import Members
from belt_ros.mechanics.constants import DriveConstants

_Floats = NDArray[np.float64]


class Population:
    """Members that are moved, updated, weighed and summed up together.

    Parameters
    ----------
    constants : DriveConstants
    prior_mean : ndarray
        State (12,) to which what the belt is returns.
    prior_stddev : ndarray
        (12,)

    Attributes
    ----------
    weights : ndarray
        Of the members (k,), summing to one.
    squared : ndarray
        Innovation squared of each member (k,) at the measurement last compared with, normalised by
        the covariance of the sum ...
    least, average : float
        ... the least of them, and their average.
    mean, covariance : ndarray
        Of the sum, (12,) and (12, 12), when it was last summed up.
    """

    def __init__(
        self, constants: DriveConstants, prior_mean: _Floats, prior_stddev: _Floats
    ) -> None:
        self._bank = UnscentedBank(constants, prior_mean)
        self._changing = np.zeros(0, dtype=np.int64)
        self._log_weights = np.zeros(0)
        self.weights = np.zeros(0)
        self.squared = np.zeros(0)
        self.least = self.average = 0.0
        self.mean = prior_mean
        self.covariance = np.diag(prior_stddev**2)

    def __len__(self) -> int:
        """Return the number of members."""
        return len(self._bank)

    @property
    def changing(self) -> float:
        """Weight of the members in which traction is changing."""
        return float(self.weights @ self._changing)

    @property
    def means(self) -> _Floats:
        """Of the members (k, 12)."""
        return self._bank.x

    @property
    def covariances(self) -> _Floats:
        """Of the members (k, 12, 12)."""
        return self._bank.P

    def adopt(self, components: list[Component]) -> None:
        """Make `components` the members."""
        self._bank.x = np.stack([component.mean for component in components])
        self._bank.P = np.stack([component.covariance for component in components])
        self._changing = np.array([component.changing for component in components], dtype=np.int64)
        self._log_weights = np.array([component.log_weight for component in components])

    def components(self) -> list[Component]:
        """Return the members as a Gaussian sum over the state."""
        return [
            Component(float(log_weight), x.copy(), covariance.copy(), bool(changing))
            for log_weight, x, covariance, changing in zip(
                self._log_weights, self._bank.x, self._bank.P, self._changing, strict=True
            )
        ]

    def members(self) -> Members:
        """Return the members as they are, to go back to."""
        return Members(self._log_weights, self._changing, self._bank.x, self._bank.P)

    def go_back(self, members: Members) -> None:
        """Be again what `members` returned."""
        self._log_weights, self._changing = members.log_weights, members.changing
        self._bank.x, self._bank.P = members.means, members.covariances
        self.weights = normalised(self._log_weights)

    def fade(self, processes: tuple[Process, Process]) -> None:
        """Fade every member by the process of its mode, without any motion."""
        self._bank.fade(processes, self._changing)

    def step(
        self,
        dt: float,
        added: tuple[Wander, Activity, CreepChange, float],
        sensed: Sensed,
        *,
        crosses: bool,
    ) -> Foretold:
        """Advance every member and compare it with what was sensed, see `UnscentedBank.step`."""
        foretold = self._bank.step(
            dt, added, self._changing, self.weights, sensed.states, crosses=crosses
        )
        self.squared, self.least, self.average = foretold[:3]
        return foretold

    def take_in(self, sensed: Sensed) -> None:
        """Take in what the last step has compared the members with, weigh and sum them up."""
        bank = self._bank
        bank.x, bank.P, self._log_weights, self.weights, self.mean, self.covariance, finite = (
            take_in_and_weigh(bank.x, bank.P, self._log_weights, self.squared, *sensed.states)
        )
        if not finite:
            self.summarise()

    def update(self, sensed: Sensed) -> None:
        """Take readings into every member, weights as they are."""
        self._bank.update(*sensed.states)

    def observe_load(self, load: int, z: float, variance: float) -> tuple[_Floats, _Floats]:
        """Take a load into every member, weights as they are, see `UnscentedBank.observe_load`."""
        return self._bank.observe_load(load, z, variance)

    def weigh(self, squared: _Floats) -> None:
        """Weigh members against each other, by what each has foretold worse than the others."""
        self._log_weights = self._log_weights - 0.5 * squared
        self._log_weights -= self._log_weights.max()
        self.weights = normalised(self._log_weights)

    def read(self, members: NDArray[np.int64], slowest: float) -> tuple[_Floats, _Floats]:
        """Read some members off, see `UnscentedBank.read`."""
        return self._bank.read(members, slowest)

    def summarise(self) -> None:
        """Set `mean` and `covariance` to those of the sum.

        Raises
        ------
        FloatingPointError
            If no member is finite any more.
        """
        if not math.isfinite(float(self._log_weights.sum() + self._bank.x.sum())):
            self._drop_broken()
        self.weights = normalised(self._log_weights)
        self.mean, self.covariance = mixture_moments(self.weights, self._bank.x, self._bank.P)

    def _drop_broken(self) -> None:
        """Drop members that are not finite: the last guard, against readings beyond all reason."""
        sound = np.isfinite(self._log_weights)
        sound &= np.all(np.isfinite(self._bank.x), axis=1)
        sound &= np.all(np.isfinite(self._bank.P), axis=(1, 2))
        if not np.any(sound):
            raise FloatingPointError("no member of the filter is finite any more")
        self._bank.x, self._bank.P = self._bank.x[sound], self._bank.P[sound]
        self._log_weights, self._changing = self._log_weights[sound], self._changing[sound]
