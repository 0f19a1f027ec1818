"""The belt's unscented filter: prior, noise, drift and measurements turned into mean and covariance.

Time comes in as the stamps of the measurements; there is no clock here.
"""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.assumptions import Drift, Prior, SensorNoise
from belt_ros.estimation.measurement import Measurement
from belt_ros.estimation.sigma_points import BatchedUnscentedFilter
from belt_ros.estimation.state import READINGS, STATES, Index, propagate, read
from belt_ros.mechanics.creep import drive_constants
from belt_ros.mechanics.drive import BeltDrive

_Floats = NDArray[np.float64]
_SENSED = np.array(
    [Index.DRIVER_SPEED, Index.DRIVEN_SPEED, Index.DRIVER_TORQUE, Index.DRIVEN_TORQUE]
)
_MOTION = slice(Index.DRIVER_SPEED, Index.LOG_TENSION)
_SECONDS = 1e-9


def lognormal(mean: float, stddev: float) -> tuple[float, float]:
    """Mean and standard deviation of ln x for a log-normal x of given mean and deviation."""
    variance = math.log1p((stddev / mean) ** 2)
    return math.log(mean) - 0.5 * variance, math.sqrt(variance)


class BeltFilter:
    """Unscented filter of one belt drive.

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
        State (10,) in the order of `state.Index`, and its covariance (10, 10).
    prior_stddev : ndarray
        Standard deviations (10,) before the first measurement.
    """

    def __init__(self, drive: BeltDrive, prior: Prior, noise: SensorNoise, drift: Drift) -> None:
        self.prior = prior
        self.noise = noise
        self.drift = drift
        self._constants = drive_constants(drive)
        self._arc_length = 0.5 * (
            drive.driven.radius * drive.driven.wrap_angle
            + drive.driver.radius * drive.driver.wrap_angle
        )
        self._span_length = drive.span_length
        self._developed_pull = 0.0
        self._torque_scale = prior.tension * drive.driver.radius
        self._filter = BatchedUnscentedFilter(STATES, self._move)
        self._stamp_ns: int | None = None
        self._prior_mean, self.prior_stddev = self._initial()

    @property
    def x(self) -> _Floats:
        """State vector (10,)."""
        return np.asarray(self._filter.x)

    @property
    def covariance(self) -> _Floats:
        """Covariance of the state vector (10, 10)."""
        return np.asarray(self._filter.P)

    @property
    def stamp_ns(self) -> int | None:
        """Stamp of the last measurement taken in [ns], or None."""
        return self._stamp_ns

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
        return mean, stddev

    def start(self, measurement: Measurement) -> None:
        """Begin at the prior, at the speeds and torques of `measurement`."""
        z, variance, _ = self._reading(measurement)
        self._filter.x = self._prior_mean.copy()
        stddev = self.prior_stddev.copy()
        self._filter.x[Index.DRIVER_SPEED], self._filter.x[Index.DRIVEN_SPEED] = z[0], z[1]
        stddev[Index.DRIVER_SPEED], stddev[Index.DRIVEN_SPEED] = np.sqrt(variance[:2])
        self._filter.P = np.diag(stddev**2)
        self._stamp_ns = measurement.stamp_ns
        self._developed_pull = 0.0
        self._take_in_torques(measurement)

    def resume(self, measurement: Measurement) -> None:
        """Restart the motion at `measurement`, keeping what is known of the belt.

        For a gap in the data, or a motion that the filter can no longer follow.
        """
        x, covariance = self._filter.x.copy(), self._filter.P.copy()
        self.start(measurement)
        kept = slice(Index.LOG_TENSION, STATES)
        self._filter.x[kept] = x[kept]
        self._filter.P[kept, kept] = covariance[kept, kept]

    def predict(self, measurement: Measurement) -> float:
        """Advance to `measurement` without taking it in.

        Returns
        -------
        float
            Its normalised innovation squared, per degree of freedom.
        """
        assert self._stamp_ns is not None, "start() comes before predict()"
        dt = (measurement.stamp_ns - self._stamp_ns) * _SECONDS
        self._filter.Q = np.diag(self._process_variance(dt))
        self._develop(dt)
        self._filter.predict(dt)
        self._stamp_ns = measurement.stamp_ns
        z, variance, seen = self._reading(measurement)
        return self._filter.innovation(z, variance, seen) / len(seen)

    def update(self, measurement: Measurement) -> tuple[float, int]:
        """Take in `measurement`, after `predict`.

        Returns
        -------
        tuple of float and int
            Normalised innovation squared and its degrees of freedom.
        """
        z, variance, seen = self._reading(measurement)
        return self._filter.update(z, variance, seen), len(seen)

    def widen(self, share: float) -> None:
        """Add `share` of the prior variance to what is known of tension, friction and creep error.

        Nothing is added beyond the prior itself.
        """
        for index in (Index.LOG_TENSION, Index.LOG_FRICTION, Index.CREEP_ERROR):
            widest = self.prior_stddev[index] ** 2
            room = widest - self._filter.P[index, index]
            self._filter.P[index, index] += max(0.0, min(share * widest, room))

    def readings(self, slowest: float) -> tuple[_Floats, _Floats]:
        """Mean (11,) and covariance (11, 11) of `state.Reading`, by unscented transform.

        `slowest` is the rim speed [m/s] below which slip is referred to it.
        """
        rows = read(self._constants, self._filter.posterior_points(), slowest)
        mean = self._filter.Wm @ rows
        spread = rows - mean
        covariance = (spread.T * self._filter.Wc) @ spread
        assert mean.shape == (READINGS,)
        return mean, covariance

    def _move(self, states: _Floats, dt: float) -> _Floats:
        return propagate(
            self._constants, states, math.exp(-dt / self.drift.creep_error_time), dt
        )

    def _process_variance(self, dt: float) -> _Floats:
        drift, prior = self.drift, self.prior
        rate = np.zeros(STATES)
        rate[Index.PULL] = drift.pull * prior.tension
        rate[Index.DRIVER_TORQUE] = rate[Index.DRIVEN_TORQUE] = drift.torque * self._torque_scale
        rate[Index.LOG_TENSION] = drift.tension
        rate[Index.LOG_STIFFNESS] = drift.friction_stiffness
        rate[Index.LOG_FRICTION] = drift.friction_coefficient
        variance = rate**2 * dt
        variance[Index.PULL] += self._developing_variance() * dt
        forgotten = -math.expm1(-2.0 * dt / drift.creep_error_time)
        variance[Index.CREEP_ERROR] = prior.creep_error_stddev**2 * forgotten
        return variance

    def _rim_speed(self) -> float:
        return abs(float(self._filter.x[Index.DRIVER_SPEED])) * self._constants.driver_radius

    def _develop(self, dt: float) -> None:
        """Let the creep on the arcs follow the pull, over one arc length of belt travel."""
        travelled = -math.expm1(-self._rim_speed() * dt / self._arc_length)
        self._developed_pull += travelled * (self.x[Index.PULL] - self._developed_pull)

    def _developing_variance(self) -> float:
        """Variance rate of the pull [N^2/s] while the creep on the arcs has not caught up with it.

        The law of motion takes creep as that of equilibrium at the present pull. After a change by
        dF it is wrong by up to dF/EA, for as long as the belt needs to travel an arc.
        """
        behind = float(self.x[Index.PULL]) - self._developed_pull
        return 8.0 * behind**2 * self._rim_speed() * self._arc_length / self._span_length**2

    def _take_in_torques(self, measurement: Measurement) -> None:
        z, variance, seen = self._reading(measurement)
        if len(seen) > 2:
            self._filter.update(z[2:], variance[2:], seen[2:])

    def _reading(self, measurement: Measurement) -> tuple[_Floats, _Floats, NDArray[np.intp]]:
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
