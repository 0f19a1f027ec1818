"""The estimator's own model, for filters of other kinds: its law of motion, process and sensors.

The process noise follows the load by the rules of `belt_ros.estimation.belt_filter`. The tension is
taken as settled; travel, which only positions tell, is left out.
"""

from abc import ABC, abstractmethod
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation import Measurement, Quantity
from belt_ros.estimation.load import Activity, LoadWander
from belt_ros.estimation.process import (
    CreepChange,
    Process,
    UndevelopedCreep,
    drift_processes,
    drift_wander,
    prior_state,
)
from belt_ros.estimation.state import STATES, Index, Reading, propagate, read, slip_per_pull
from belt_ros.mechanics.constants import drive_constants
from belt_ros.settings import DriveSettings
from benchmarks.estimation.judged import QUANTITIES, Quantities

_Floats = NDArray[np.float64]
_State = TypeVar("_State")
CARRIED = int(Index.TRAVEL)  # states, all before it
SENSED = np.array(
    [Index.DRIVER_SPEED, Index.DRIVEN_SPEED, Index.DRIVER_TORQUE, Index.DRIVEN_TORQUE],
    dtype=np.int64,
)
_READ = (Reading.SLIP, Reading.TIGHT_TENSION, Reading.SLACK_TENSION, Reading.MARGIN)
_SURPRISE = 9.0  # innovation squared per degree of freedom at which the load has jumped
_SLOW = 0.1  # rim speed [m/s] below which the slip's wander no longer shrinks with it


class DriveModel:
    """A drive as the estimator sees it."""

    def __init__(self, settings: DriveSettings) -> None:
        self.constants = drive_constants(settings.drive)
        mean, spread = prior_state(settings.prior, settings.drive)
        self.mean, self.stddev = mean[:CARRIED], spread[:CARRIED]
        self._settings = settings
        self._wander = drift_wander(settings.drift, spread, settings.prior.tension)
        self._load = LoadWander()

    def activity(self, z: _Floats, variance: _Floats, dt: float) -> Activity:
        """Follow the load by readings of `SENSED`."""
        c, load = self.constants, self._wander.load
        radii = np.array([c.driver_radius, -c.driven_radius])
        ahead = radii @ z[:2]
        speed = max(abs(c.driver_radius * z[0]), _SLOW)
        state = _whole(self.mean[np.newaxis])[0]
        state[[Index.DRIVER_SPEED, Index.DRIVEN_SPEED]] = z[:2]
        state[Index.PULL] = z[2] / c.driver_radius
        slip = speed * slip_per_pull(c, state) * load
        return self._load.follow(
            np.append(z[2:], ahead),
            np.append(variance[2:], radii**2 @ variance[:2]),
            np.array([load * c.driver_radius, load * c.driven_radius, slip]),
            np.array([0.0, 0.0, self._wander.creep * abs(ahead)]),
            dt,
            unforeseen=True,
        )

    def process(self, activity: Activity, undeveloped: CreepChange, dt: float) -> Process:
        """Return what `dt` [s] adds to the law of motion, under a load of this activity."""
        settled, _ = drift_processes(self._wander, self.constants, activity, undeveloped, dt, dt)
        return Process(
            settled.memory[:CARRIED],
            settled.covariance_before[:CARRIED, :CARRIED],
            settled.variance_after[:CARRIED],
        )

    def sensed(self, measurement: Measurement) -> tuple[_Floats, _Floats]:
        """Readings (4,) of the states `SENSED`, and their variances."""
        noise = self._settings.noise
        values = np.array(
            [
                measurement.driver_speed,
                measurement.driven_speed,
                measurement.driver_torque,
                measurement.driven_torque,
            ]
        )
        relative = np.array([noise.speed_relative] * 2 + [noise.torque_relative] * 2)
        absolute = np.array([noise.speed_absolute] * 2 + [noise.torque_absolute] * 2)
        return values, (relative * values) ** 2 + absolute**2

    def moved(self, states: _Floats, dt: float) -> _Floats:
        """Advance rows of states by `dt` [s]."""
        return propagate(self.constants, _whole(np.atleast_2d(states)), dt)[:, :CARRIED]

    def judged(self, states: _Floats) -> _Floats:
        """Rows of states to rows of `QUANTITIES`."""
        readings = read(self.constants, _whole(states), self._settings.limits.standstill_speed)
        tension = np.log(np.maximum(readings[:, Reading.MEAN_TENSION], 1e-9))
        parameters = (states[:, Index.LOG_STIFFNESS], tension, states[:, Index.LOG_FRICTION])
        return np.column_stack([readings[:, _READ], *parameters])


def _whole(states: _Floats) -> _Floats:
    """Rows of all states, no travel."""
    rows = np.zeros((len(states), STATES))
    rows[:, :CARRIED] = states
    return rows


class ModelFilter(ABC, Generic[_State]):
    """A filter on `DriveModel`, but for how it carries what it believes."""

    def __init__(self, settings: DriveSettings) -> None:
        self.model = DriveModel(settings)
        self._creep = UndevelopedCreep(self.model.constants)
        self._stamp_ns: int | None = None

    def step(self, measurement: Measurement) -> None:
        """Take in a measurement."""
        z, variance = self.model.sensed(measurement)
        if self._stamp_ns is None:
            self._start(z, variance)
            self._creep.start(float(self._mean()[Index.PULL]))
        else:
            self._advance(z, variance, (measurement.stamp_ns - self._stamp_ns) * 1e-9)
        self._stamp_ns = measurement.stamp_ns

    def _start(self, z: _Floats, variance: _Floats) -> None:
        mean, covariance = self.model.mean.copy(), np.diag(self.model.stddev**2)
        mean[SENSED[:2]] = z[:2]
        covariance[SENSED[:2], SENSED[:2]] = variance[:2]
        self._begin(mean, covariance)
        self._update(z, np.concatenate([np.full(2, 1e12), variance[2:]]))

    def _advance(self, z: _Floats, variance: _Floats, dt: float) -> None:
        mean = self._mean()
        speed = abs(float(mean[Index.DRIVER_SPEED])) * self.model.constants.driver_radius
        per_pull = slip_per_pull(self.model.constants, _whole(mean[np.newaxis])[0])
        undeveloped = self._creep.advance(float(mean[Index.PULL]), per_pull, speed, dt)
        activity = self.model.activity(z, variance, dt)
        before = self._state()
        self._predict(self.model.process(activity, undeveloped, dt), dt)
        innovation, covariance = self._foretold(z, variance)
        if innovation @ np.linalg.solve(covariance, innovation) > _SURPRISE * len(z):
            self._restore(before)
            self._predict(self.model.process(activity.jumping(), undeveloped, dt), dt)
        self._update(z, variance)

    @abstractmethod
    def quantities(self) -> Quantities:
        """Return what is known now, by name in `QUANTITIES`."""

    @abstractmethod
    def _begin(self, mean: _Floats, covariance: _Floats) -> None:
        """Believe this Gaussian."""

    @abstractmethod
    def _mean(self) -> _Floats:
        """Mean (CARRIED,)."""

    @abstractmethod
    def _state(self) -> _State:
        """Return what `_restore` takes."""

    @abstractmethod
    def _restore(self, state: _State) -> None:
        """Take back a prediction."""

    @abstractmethod
    def _predict(self, process: Process, dt: float) -> None:
        """Advance by `dt` [s]."""

    @abstractmethod
    def _foretold(self, z: _Floats, variance: _Floats) -> tuple[_Floats, _Floats]:
        """Innovation (4,) and its covariance (4, 4)."""

    @abstractmethod
    def _update(self, z: _Floats, variance: _Floats) -> None:
        """Take in readings of the states `SENSED`."""


def by_name(means: _Floats, stddevs: _Floats) -> Quantities:
    """Name rows of means and deviations, in the order of `QUANTITIES`."""
    pairs = zip(means.tolist(), stddevs.tolist(), strict=True)
    return {name: Quantity(*pair) for name, pair in zip(QUANTITIES, pairs, strict=True)}
