"""One Gaussian on the estimator's model: an extended Kalman filter and filterpy's unscented."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter
from numpy.typing import NDArray

from belt_ros.estimation import Measurement
from belt_ros.estimation.process import Process
from belt_ros.estimation.state import STATES
from belt_ros.settings import DriveSettings
from benchmarks.estimation.judged import QUANTITIES, Quantities
from benchmarks.estimation.model import CARRIED, SENSED, ModelFilter, by_name

_Floats = NDArray[np.float64]
_Function = Callable[[_Floats], _Floats]
_Motion = Callable[[_Floats, float], _Floats]
_DIFFERENCE = 0.01  # of numerical Jacobians, in standard deviations


class Gaussian(NamedTuple):
    """Mean (CARRIED,) and covariance (CARRIED, CARRIED)."""

    mean: _Floats
    covariance: _Floats


def faded(belief: Gaussian, process: Process, anchor: _Floats) -> Gaussian:
    """Let what the belt is fade towards its prior."""
    memory = process.memory
    covariance = belief.covariance * np.outer(memory, memory) + process.covariance_before
    return Gaussian(anchor + memory * (belief.mean - anchor), covariance)


class Extended(ModelFilter[Gaussian]):
    """Extended Kalman filter with numerical Jacobians."""

    _belief: Gaussian

    def step(self, measurement: Measurement) -> None:
        """Take in a measurement, and read it off as a live estimator does."""
        super().step(measurement)
        self._quantities = self._read()

    def quantities(self) -> Quantities:
        """Return what is known now."""
        return self._quantities

    def _read(self) -> Quantities:
        mean, jacobian = self._linearised(self.model.judged)
        variance = np.einsum("ij,jk,ik->i", jacobian, self._belief.covariance, jacobian)
        return by_name(mean, np.sqrt(np.maximum(variance, 0.0)))

    def _linearised(self, function: _Function) -> tuple[_Floats, _Floats]:
        """Value at the mean, and central differences, of a function of rows of states."""
        mean, covariance = self._belief
        steps = _DIFFERENCE * np.sqrt(np.diag(covariance))
        offsets = np.diag(steps)
        values = function(np.vstack([mean, mean + offsets, mean - offsets]))
        differences = values[1 : 1 + CARRIED] - values[1 + CARRIED :]
        return values[0], (differences / (2.0 * steps[:, None])).T

    def _begin(self, mean: _Floats, covariance: _Floats) -> None:
        self._belief = Gaussian(mean, covariance)

    def _mean(self) -> _Floats:
        return self._belief.mean

    def _state(self) -> Gaussian:
        return self._belief

    def _restore(self, state: Gaussian) -> None:
        self._belief = state

    def _predict(self, process: Process, dt: float) -> None:
        self._belief = faded(self._belief, process, self.model.mean)
        mean, jacobian = self._linearised(lambda states: self.model.moved(states, dt))
        covariance = jacobian @ self._belief.covariance @ jacobian.T
        self._belief = Gaussian(mean, covariance + np.diag(process.variance_after))

    def _foretold(self, z: _Floats, variance: _Floats) -> tuple[_Floats, _Floats]:
        mean, covariance = self._belief
        return z - mean[SENSED], covariance[np.ix_(SENSED, SENSED)] + np.diag(variance)

    def _update(self, z: _Floats, variance: _Floats) -> None:
        mean, covariance = self._belief
        innovation, expected = self._foretold(z, variance)
        gain = np.linalg.solve(expected, covariance[SENSED]).T
        kept = np.eye(CARRIED)
        kept[:, SENSED] -= gain
        covariance = kept @ covariance @ kept.T + (gain * variance) @ gain.T
        self._belief = Gaussian(mean + gain @ innovation, 0.5 * (covariance + covariance.T))


class Stock(ModelFilter[Gaussian]):
    """filterpy's unscented filter as it comes, with Merwe's points at alpha = 1.

    Where its covariance loses positive definiteness it says nothing more.
    """

    def __init__(self, settings: DriveSettings) -> None:
        super().__init__(settings)
        self._filter = stock(lambda x, dt: self.model.moved(x, dt)[0], CARRIED)
        self._broken = False
        self._quantities: Quantities = {}

    def step(self, measurement: Measurement) -> None:
        """Take in a measurement, and read it off as a live estimator does."""
        if self._broken:
            return
        try:
            super().step(measurement)
            self._quantities = self._read()
        except np.linalg.LinAlgError:
            self._broken = True
            self._quantities = nothing()

    def quantities(self) -> Quantities:
        """Return what is known now."""
        return self._quantities

    def _read(self) -> Quantities:
        f = self._filter
        rows = self.model.judged(f.points_fn.sigma_points(f.x, f.P))
        mean = f.Wm @ rows
        return by_name(mean, np.sqrt(np.maximum(f.Wc @ (rows - mean) ** 2, 0.0)))

    def _begin(self, mean: _Floats, covariance: _Floats) -> None:
        self._restore(Gaussian(mean, covariance))

    def _mean(self) -> _Floats:
        return np.asarray(self._filter.x)

    def _state(self) -> Gaussian:
        return Gaussian(self._filter.x.copy(), self._filter.P.copy())

    def _restore(self, state: Gaussian) -> None:
        self._filter.x, self._filter.P = state
        self._filter.sigmas_f = self._filter.points_fn.sigma_points(*state)

    def _predict(self, process: Process, dt: float) -> None:
        f = self._filter
        f.x, f.P = faded(Gaussian(f.x, f.P), process, self.model.mean)
        f.Q = np.diag(process.variance_after)
        f.predict(dt=dt)

    def _foretold(self, z: _Floats, variance: _Floats) -> tuple[_Floats, _Floats]:
        f = self._filter
        return z - f.x[SENSED], f.P[np.ix_(SENSED, SENSED)] + np.diag(variance)

    def _update(self, z: _Floats, variance: _Floats) -> None:
        self._filter.update(z, R=np.diag(variance))


class Empty:
    """filterpy's unscented filter of the same size with nothing in its model: the unit of time."""

    def __init__(self) -> None:
        self._filter = stock(lambda x, _dt: x, STATES)
        self._filter.R = np.eye(len(SENSED))

    def step(self, measurement: Measurement) -> None:
        """Predict and update."""
        self._filter.predict()
        self._filter.update(
            np.array(
                [
                    measurement.driver_speed,
                    measurement.driven_speed,
                    measurement.driver_torque,
                    measurement.driven_torque,
                ]
            )
        )

    def quantities(self) -> Quantities:
        """Return nothing."""
        return nothing()


def nothing() -> Quantities:
    """Return quantities of which nothing is known."""
    blank = np.full(len(QUANTITIES), np.nan)
    return by_name(blank, blank)


def stock(motion: _Motion, states: int) -> UnscentedKalmanFilter:
    """Return filterpy's unscented filter of this many states, with this law of motion."""
    points = MerweScaledSigmaPoints(states, alpha=1.0, beta=2.0, kappa=0.0)
    return UnscentedKalmanFilter(states, len(SENSED), 0.01, lambda x: x[SENSED], motion, points)
