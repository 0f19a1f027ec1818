"""The belt's filter: prior, noise, drift and measurements turned into mean and covariance.

A Gaussian sum of unscented filters over (ln tension, ln kf), see `gaussian_sum`, each in one of two
modes: the tension is settled, or it is changing. Time comes in as the stamps of the measurements;
there is no clock here.
"""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.assumptions import Drift, Prior, SensorNoise
from belt_ros.estimation.bank import UnscentedBank
from belt_ros.estimation.gaussian_sum import (
    Component,
    mixture_moments,
    normalised,
    reduced,
    split,
)
from belt_ros.estimation.measurement import Measurement
from belt_ros.estimation.process import Process, UndevelopedCreep, drift_process, prior_state
from belt_ros.estimation.readings import Readings
from belt_ros.estimation.state import STATES, Index
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.drive import BeltDrive

_Floats = NDArray[np.float64]
_SENSED = np.array(
    [Index.DRIVER_SPEED, Index.DRIVEN_SPEED, Index.DRIVER_TORQUE, Index.DRIVEN_TORQUE],
    dtype=np.int64,
)
_BELT = slice(Index.LOG_TENSION, STATES)
_AXES = (Index.LOG_TENSION, Index.LOG_STIFFNESS)
_WIDTHS = (0.45, 0.6)  # of a member to begin with, in prior standard deviations
_WORTH_SPLITTING = 1.1  # how much wider a member must be
_SPLIT_ABOVE = 1e-3  # weight of the heaviest
_MOST_MEMBERS = 96
_REDUCE_EVERY = 10  # updates
_BRANCH_EVERY = 1.0  # [s]
_CHANGE_END_RATE = 0.5  # at which a change of tension ends [1/s]
_READ_ABOVE = 1e-4  # weight below which a member no longer shows in what is read off
_SURPRISE = 9.0  # innovation squared per degree of freedom at which the load must have jumped
_LOAD_MEMORY = 0.3  # [s]
_LEAST_ACTIVITY = 0.001
_SECONDS = 1e-9


class BeltFilter:
    """Bayesian filter of one belt drive.

    Parameters
    ----------
    drive : BeltDrive
        Geometry, belt and inertias; its kf and mu are used only as ratios between the pulleys.
    prior : Prior
    noise : SensorNoise
    drift : Drift

    Attributes
    ----------
    x, covariance : ndarray
        State (11,) in the order of `state.Index`, and its covariance (11, 11).
    prior_stddev : ndarray
        Standard deviations (11,) before the first measurement.
    stamp_ns : int or None
        Stamp of the last measurement moved to [ns].
    """

    def __init__(self, drive: BeltDrive, prior: Prior, noise: SensorNoise, drift: Drift) -> None:
        self.noise = noise
        self.drift = drift
        self.stamp_ns: int | None = None
        self._constants = drive_constants(drive)
        self._tension_scale = prior.tension
        self._prior_mean, self.prior_stddev = prior_state(prior, drive)
        self._undeveloped = UndevelopedCreep(self._constants)
        self._bank = UnscentedBank(self._constants, self._prior_mean)
        self._changing = np.zeros(0, dtype=np.int64)
        self._log_weights = np.zeros(0)
        self._squared = np.zeros(0)
        self._surprise = np.zeros(0)
        self._load_activity = 1.0
        self._updates = 0
        self._since_branch = 0.0
        self._last_dt = 0.0
        self.x = self._prior_mean
        self.covariance = np.diag(self.prior_stddev**2)

    @property
    def members(self) -> int:
        """Number of Gaussians alive."""
        return len(self._bank)

    @property
    def prior_mean(self) -> _Floats:
        """State (11,) before the first measurement."""
        return self._prior_mean

    def start(self, measurement: Measurement, belief: list[Component] | None = None) -> None:
        """Begin at the speeds and torques of `measurement`.

        What the belt is begins as `belief` has it, a Gaussian sum over the state, or at the prior.
        """
        whole = Component(0.0, self._prior_mean.copy(), np.diag(self.prior_stddev**2))
        self._begin_motion(measurement, self._narrowed(belief or [whole]))

    def adopt_belief(self, belief: list[Component]) -> None:
        """Go on from another belief over the state, such as after maintenance."""
        self._adopt(self._narrowed(belief))
        self._summarise()

    def _narrowed(self, components: list[Component]) -> list[Component]:
        """Split members that are too wide for the model to be nearly straight within them."""
        for axis, width in zip(_AXES, _WIDTHS, strict=True):
            narrow = width * float(self.prior_stddev[axis])
            best = max(component.log_weight for component in components)
            parts: list[Component] = []
            for component in sorted(components, key=lambda c: -c.log_weight):
                ratio = narrow / math.sqrt(component.covariance[axis, axis])
                light = component.log_weight < best + math.log(_SPLIT_ABOVE)
                if light or ratio * _WORTH_SPLITTING > 1.0 or len(parts) > _MOST_MEMBERS:
                    parts.append(component)
                else:
                    parts += split(component, axis, ratio)
            components = parts
        return components

    def resume(self, measurement: Measurement) -> None:
        """Restart the motion at `measurement`, keeping what is known of the belt, aged by the gap.

        For a gap in the data, or a motion that the filter can no longer follow.
        """
        assert self.stamp_ns is not None, "start() comes before resume()"
        gap = max(measurement.stamp_ns - self.stamp_ns, 0) * _SECONDS
        settled, changing = self._processes(gap, (1.0, self.prior_stddev[Index.UNDEVELOPED]))
        self._bank.fade((settled, changing), self._changing)
        components = self.belief()
        for component in components:
            mean, covariance = self._prior_mean.copy(), np.diag(self.prior_stddev**2)
            mean[_BELT] = component.mean[_BELT]
            covariance[_BELT, _BELT] = component.covariance[_BELT, _BELT]
            component.mean, component.covariance = mean, covariance
        self._begin_motion(measurement, components)

    def _begin_motion(self, measurement: Measurement, components: list[Component]) -> None:
        z, variance, seen = self._reading(measurement)
        for component in components:
            for place, value, spread in zip(seen[:2], z[:2], variance[:2], strict=True):
                component.mean[place] = value
                component.covariance[place, place] = spread
        self._adopt(components)
        self._bank.update(z[2:], variance[2:], seen[2:])
        self.stamp_ns = measurement.stamp_ns
        self._load_activity = 1.0
        self._summarise()
        self._undeveloped.start(float(self.x[Index.PULL]))

    def predict(self, measurement: Measurement) -> float:
        """Advance to `measurement` without taking it in.

        Returns
        -------
        float
            Its normalised innovation squared per degree of freedom, for the member it suits best.
        """
        assert self.stamp_ns is not None, "start() comes before predict()"
        dt = (measurement.stamp_ns - self.stamp_ns) * _SECONDS
        z, variance, seen = self._reading(measurement)
        before = self._bank.x, self._bank.P
        undeveloped = self._follow_creep(dt)
        self._advance(dt, undeveloped)
        self._squared = self._innovations_squared(z, variance, seen)
        if np.min(self._squared) > _SURPRISE * len(seen):
            # The load has jumped. Taken in as if it had not, it would be blamed on the belt.
            self._bank.x, self._bank.P = before
            self._load_activity = 1.0
            self._advance(dt, undeveloped)
            self._squared = self._innovations_squared(z, variance, seen)
        self.stamp_ns = measurement.stamp_ns
        self._since_branch += dt
        self._last_dt = dt
        return float(np.min(self._squared)) / len(seen)

    def _innovations_squared(
        self, z: _Floats, variance: _Floats, seen: NDArray[np.int64]
    ) -> _Floats:
        """Each member's innovation squared, normalised by the covariance of the sum.

        Members are compared by what they predict. How uncertain each is of loads and noise says
        nothing of the belt, and where that is misjudged, it would favour the most certain for ever.
        """
        weights = normalised(self._log_weights)
        innovations = z - self._bank.x[:, seen]
        spread = self._bank.P[:, seen[:, None], seen]
        covariance = np.tensordot(weights, spread, 1) + np.diag(variance)
        whitened = np.linalg.solve(covariance, innovations.T)
        self._surprise = np.square(weights @ innovations) / np.diag(covariance)
        return np.asarray(np.sum(innovations.T * whitened, axis=0))

    def update(self, measurement: Measurement) -> tuple[float, int]:
        """Take in `measurement`, after `predict`.

        Returns
        -------
        tuple of float and int
            Normalised innovation squared, averaged over the members, and its degrees of freedom.
        """
        z, variance, seen = self._reading(measurement)
        self._bank.update(z, variance, seen)
        squared = float(normalised(self._log_weights) @ self._squared)
        self._log_weights = self._log_weights - 0.5 * self._squared
        self._log_weights -= np.max(self._log_weights)
        self._follow_load(seen, self._last_dt)
        self._updates += 1
        if self._updates % _REDUCE_EVERY == 0:
            self._reduce()
        self._summarise()
        return squared, len(seen)

    def readings(self, slowest: float) -> Readings:
        """Read off what `state.Reading` lists, by unscented transform of every member that counts.

        `slowest` is the rim speed [m/s] below which slip is referred to it.
        """
        weights = normalised(self._log_weights)
        shown = np.flatnonzero(weights >= _READ_ABOVE)
        return Readings(weights[shown] / np.sum(weights[shown]), *self._bank.read(shown, slowest))

    def _follow_creep(self, dt: float) -> tuple[float, float]:
        speed = abs(float(self.x[Index.DRIVER_SPEED])) * self._constants.driver_radius
        return self._undeveloped.advance(float(self.x[Index.PULL]), speed, dt)

    def _advance(self, dt: float, undeveloped: tuple[float, float]) -> None:
        """Move every member by `dt`, as its mode has it."""
        self._bank.predict(dt, self._processes(dt, undeveloped), self._changing)

    def _processes(self, dt: float, undeveloped: tuple[float, float]) -> tuple[Process, Process]:
        """Process of a settled and of a changing tension over `dt`."""
        settled, changing = (
            drift_process(
                self.drift,
                self.prior_stddev,
                self._tension_scale,
                self._constants,
                self._load_activity,
                undeveloped,
                dt,
                changing=changing,
            )
            for changing in (False, True)
        )
        return settled, changing

    def _follow_load(self, seen: NDArray[np.int64], dt: float) -> None:
        """Fit how fast the load is taken to wander to how well its torque was foretold."""
        surprise = self._surprise[seen >= Index.DRIVER_TORQUE]
        if len(surprise) == 0:
            self._load_activity = 1.0
            return
        excess = min(float(np.mean(surprise)), _SURPRISE) - 1.0
        activity = self._load_activity * math.exp(excess * dt / _LOAD_MEMORY)
        self._load_activity = min(max(activity, _LEAST_ACTIVITY), 1.0)

    def _reduce(self) -> None:
        """Drop and merge members; now and then let the best begin, or end, a change of tension.

        A member in which the tension is changing gives every loss of traction a hypothesis to be
        explained by, before slower quantities are bent to explain it.
        """
        components = reduced(self.belief(), _AXES)
        best = max(components, key=lambda component: component.log_weight)
        alone = all(component.changing is best.changing for component in components)
        if alone or self._since_branch >= _BRANCH_EVERY:
            begun = -math.expm1(-self.drift.tension_changes * self._since_branch)
            ended = -math.expm1(-_CHANGE_END_RATE * self._since_branch)
            log_weight = best.log_weight + math.log(ended if best.changing else begun)
            branch = Component(log_weight, best.mean, best.covariance, not best.changing)
            for component in components:
                component.log_weight += math.log1p(-(ended if component.changing else begun))
            components.append(branch)
            self._since_branch = 0.0
        self._adopt(components)

    def belief(self) -> list[Component]:
        """Return what is known, as a Gaussian sum over the state."""
        return [
            Component(float(log_weight), x, covariance, bool(changing))
            for log_weight, x, covariance, changing in zip(
                self._log_weights, self._bank.x, self._bank.P, self._changing, strict=True
            )
        ]

    def _adopt(self, components: list[Component]) -> None:
        """Make `components` the members."""
        self._bank.x = np.stack([component.mean for component in components])
        self._bank.P = np.stack([component.covariance for component in components])
        self._changing = np.array([component.changing for component in components], dtype=np.int64)
        self._log_weights = np.array([component.log_weight for component in components])

    def _summarise(self) -> None:
        """Set `x` and `covariance` to those of the sum."""
        self.x, self.covariance = mixture_moments(
            normalised(self._log_weights), self._bank.x, self._bank.P
        )

    def _reading(self, measurement: Measurement) -> tuple[_Floats, _Floats, NDArray[np.int64]]:
        """Sensed values that are there, their variances and the states they read."""
        values = np.array(
            [
                measurement.driver_speed,
                measurement.driven_speed,
                measurement.driver_torque,
                measurement.driven_torque,
            ]
        )
        noise = self.noise
        relative = np.array([noise.speed_relative] * 2 + [noise.torque_relative] * 2)
        absolute = np.array([noise.speed_absolute] * 2 + [noise.torque_absolute] * 2)
        there = ~np.isnan(values)
        variance = (relative * values) ** 2 + absolute**2
        return values[there], variance[there], _SENSED[there]
