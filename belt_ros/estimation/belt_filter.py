"""The belt's filter: prior, noise, drift and measurements turned into mean and covariance.

A Gaussian sum of unscented filters over (ln tension, ln kf), see `gaussian_sum`. Time comes in as
the stamps of the measurements; there is no clock here.
"""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.assumptions import Drift, Prior, SensorNoise
from belt_ros.estimation.gaussian_sum import (
    Component,
    grid,
    mixture_moments,
    normalised,
    reduced,
)
from belt_ros.estimation.measurement import Measurement
from belt_ros.estimation.state import READINGS, STATES, Index, propagate, read
from belt_ros.estimation.unscented import BatchedUnscentedFilter, moments
from belt_ros.mechanics.creep import drive_constants
from belt_ros.mechanics.drive import BeltDrive

_Floats = NDArray[np.float64]
_SENSED = np.array(
    [Index.DRIVER_SPEED, Index.DRIVEN_SPEED, Index.DRIVER_TORQUE, Index.DRIVEN_TORQUE],
    dtype=np.int64,
)
_BELT = slice(Index.LOG_TENSION, STATES)
_AXES = (Index.LOG_TENSION, Index.LOG_STIFFNESS)
_NODES = (7, 5)
_WIDTH = 0.6  # of a member, in prior standard deviations
_REDUCE_EVERY = 10  # updates
_READ_ABOVE = 1e-4  # weight below which a member no longer shows in what is read off
_RECENT = 0.05  # [s] over which the rate of winding is taken
_COMPLIANCE_ERROR = 0.3  # of the spans' winding that the law of motion may miss
_SECONDS = 1e-9


def lognormal(mean: float, stddev: float) -> tuple[float, float]:
    """Mean and standard deviation of ln x for a log-normal x of given mean and deviation."""
    variance = math.log1p((stddev / mean) ** 2)
    return math.log(mean) - 0.5 * variance, math.sqrt(variance)


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
        self.prior = prior
        self.noise = noise
        self.drift = drift
        self.stamp_ns: int | None = None
        self._constants = drive_constants(drive)
        self._arc_length = 0.5 * (
            drive.driven.radius * drive.driven.wrap_angle
            + drive.driver.radius * drive.driver.wrap_angle
        )
        self._developed_pull = 0.0
        self._recent_pull = 0.0
        self._torque_scale = prior.tension * drive.driver.radius
        self._prior_mean, self.prior_stddev = self._initial()
        self._members: list[BatchedUnscentedFilter] = []
        self._log_weights = np.zeros(0)
        self._updates = 0
        self.x = self._prior_mean
        self.covariance = np.diag(self.prior_stddev**2)

    @property
    def members(self) -> int:
        """Number of Gaussians alive."""
        return len(self._members)

    def _initial(self) -> tuple[_Floats, _Floats]:
        prior = self.prior
        log_tension, log_tension_stddev = lognormal(prior.tension, prior.tension_stddev)
        log_friction, log_friction_stddev = lognormal(
            prior.friction_coefficient, prior.friction_coefficient_stddev
        )
        mean = np.zeros(STATES)
        mean[Index.LOG_TENSION] = log_tension
        mean[Index.LOG_STIFFNESS] = math.log(prior.friction_stiffness)
        mean[Index.LOG_FRICTION] = log_friction
        stddev = np.empty(STATES)
        stddev[Index.DRIVER_SPEED] = stddev[Index.DRIVEN_SPEED] = 1.0
        stddev[Index.PULL] = 0.5 * prior.tension
        stddev[Index.DRIVER_TORQUE] = stddev[Index.DRIVEN_TORQUE] = self._torque_scale
        stddev[Index.LOG_TENSION] = log_tension_stddev
        stddev[Index.LOG_STIFFNESS] = prior.friction_stiffness_decades * math.log(10.0)
        stddev[Index.LOG_FRICTION] = log_friction_stddev
        stddev[Index.RATIO_BIAS] = prior.ratio_bias_stddev
        stddev[Index.CREEP_ERROR] = prior.creep_error_stddev
        stddev[Index.UNDEVELOPED] = prior.tension / self._constants.axial_stiffness
        return mean, stddev

    def start(self, measurement: Measurement) -> None:
        """Begin at the prior, at the speeds and torques of `measurement`."""
        components = grid(self._prior_mean, self.prior_stddev, _AXES, _NODES, _WIDTH)
        self._begin_motion(measurement, components)

    def resume(self, measurement: Measurement) -> None:
        """Restart the motion at `measurement`, keeping what is known of the belt.

        For a gap in the data, or a motion that the filter can no longer follow.
        """
        components = self._components()
        fresh = np.diag(self.prior_stddev**2)
        for component in components:
            mean, covariance = self._prior_mean.copy(), fresh.copy()
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
        for member in self._members:
            member.update(z[2:], variance[2:], seen[2:])
        self.stamp_ns = measurement.stamp_ns
        self._developed_pull = 0.0
        self._recent_pull = float(self.x[Index.PULL])
        self._summarise()

    def predict(self, measurement: Measurement) -> float:
        """Advance to `measurement` without taking it in.

        Returns
        -------
        float
            Its normalised innovation squared per degree of freedom, for the member it suits best.
        """
        assert self.stamp_ns is not None, "start() comes before predict()"
        dt = (measurement.stamp_ns - self.stamp_ns) * _SECONDS
        pull = float(self.x[Index.PULL])
        self._developed_pull += self._renewed(dt) * (pull - self._developed_pull)
        self._recent_pull -= math.expm1(-dt / _RECENT) * (pull - self._recent_pull)
        added = self._process_variance(dt)
        z, variance, seen = self._reading(measurement)
        least = math.inf
        for member in self._members:
            member.Q = added
            member.predict(dt)
            least = min(least, member.innovation(z, variance, seen))
        self.stamp_ns = measurement.stamp_ns
        return least / len(seen)

    def update(self, measurement: Measurement) -> tuple[float, int]:
        """Take in `measurement`, after `predict`.

        Returns
        -------
        tuple of float and int
            Normalised innovation squared, averaged over the members, and its degrees of freedom.
        """
        z, variance, seen = self._reading(measurement)
        results = np.array([member.update(z, variance, seen) for member in self._members])
        self._log_weights = self._log_weights + results[:, 1]
        self._log_weights -= np.max(self._log_weights)
        squared = float(normalised(self._log_weights) @ results[:, 0])
        self._updates += 1
        if len(self._members) > 1 and self._updates % _REDUCE_EVERY == 0:
            self._adopt(reduced(self._components(), _AXES))
        self._summarise()
        return squared, len(seen)

    def widen(self, share: float) -> None:
        """Add `share` of the prior variance to what is known of tension, friction and creep error.

        Nothing is added beyond the prior itself.
        """
        for index in (Index.LOG_TENSION, Index.LOG_FRICTION, Index.CREEP_ERROR):
            widest = self.prior_stddev[index] ** 2
            for member in self._members:
                room = widest - member.P[index, index]
                member.P[index, index] += max(0.0, min(share * widest, room))

    def readings(self, slowest: float) -> tuple[_Floats, _Floats]:
        """Mean (11,) and covariance (11, 11) of `state.Reading`, by unscented transform.

        `slowest` is the rim speed [m/s] below which slip is referred to it.
        """
        weights = normalised(self._log_weights)
        shown = np.flatnonzero(weights >= _READ_ABOVE)
        added = np.zeros(READINGS)
        parts = [
            moments(
                read(self._constants, self._members[i].posterior_points(), slowest),
                self._members[i].Wm,
                added,
            )
            for i in shown
        ]
        return mixture_moments(
            weights[shown] / np.sum(weights[shown]),
            np.stack([mean for mean, _ in parts]),
            np.stack([covariance for _, covariance in parts]),
        )

    def _components(self) -> list[Component]:
        return [
            Component(float(log_weight), member.x, member.P)
            for log_weight, member in zip(self._log_weights, self._members, strict=True)
        ]

    def _adopt(self, components: list[Component]) -> None:
        """Make `components` the members."""
        while len(self._members) < len(components):
            self._members.append(BatchedUnscentedFilter(STATES, self._move))
        del self._members[len(components) :]
        for member, component in zip(self._members, components, strict=True):
            member.x, member.P = component.mean, component.covariance
        self._log_weights = np.array([component.log_weight for component in components])

    def _summarise(self) -> None:
        """Set `x` and `covariance` to those of the sum."""
        self.x, self.covariance = mixture_moments(
            normalised(self._log_weights),
            np.stack([member.x for member in self._members]),
            np.stack([member.P for member in self._members]),
        )

    def _move(self, states: _Floats, dt: float) -> _Floats:
        fading = math.exp(-dt / self.drift.creep_error_time)
        return propagate(self._constants, states, fading, 1.0 - self._renewed(dt), dt)

    def _process_variance(self, dt: float) -> _Floats:
        drift, prior = self.drift, self.prior
        rate = np.zeros(STATES)
        rate[Index.PULL] = drift.pull * prior.tension
        rate[Index.DRIVER_TORQUE] = rate[Index.DRIVEN_TORQUE] = drift.torque * self._torque_scale
        rate[Index.LOG_TENSION] = drift.tension
        rate[Index.LOG_STIFFNESS] = drift.friction_stiffness
        rate[Index.LOG_FRICTION] = drift.friction_coefficient
        variance = rate**2 * dt
        forgotten = -math.expm1(-2.0 * dt / drift.creep_error_time)
        variance[Index.CREEP_ERROR] = prior.creep_error_stddev**2 * forgotten
        variance[Index.UNDEVELOPED] = self._undeveloped_slip() ** 2 * self._renewed(2.0 * dt)
        return variance

    def _renewed(self, dt: float) -> float:
        """Share of the belt on the arcs that is replaced in `dt` [s] of travel."""
        return -math.expm1(-self._rim_speed() * dt / self._arc_length)

    def _rim_speed(self) -> float:
        return abs(float(self.x[Index.DRIVER_SPEED])) * self._constants.driver_radius

    def _undeveloped_slip(self) -> float:
        """Return the deviation [-] of slip beside equilibrium while creep develops on the arcs.

        Creep is that of equilibrium at the present pull only once the belt on the arcs has been
        replaced since the pull changed; until then it may be off by the strain of that change.
        """
        behind = float(self.x[Index.PULL]) - self._developed_pull
        winding = abs(float(self.x[Index.PULL]) - self._recent_pull) / _RECENT
        winding_speed = _COMPLIANCE_ERROR * self._constants.span_compliance * winding
        speed = max(self._rim_speed(), winding_speed)
        if speed == 0.0:
            return 0.0
        return abs(behind) / self._constants.axial_stiffness + winding_speed / speed

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
