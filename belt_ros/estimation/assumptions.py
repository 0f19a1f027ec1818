"""What is assumed before the first measurement: priors, noise, drift, sensors and their limits.

Each field carries its unit, range and meaning as metadata; settings, node parameters and the
README's table are all made from these.
"""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

_DRAG_ROUNDING = 0.05  # [rad/s] pulley speed below which Coulomb drag fades out
_ROUNDING_VARIANCE = 1.0 / 12.0  # of an error anywhere within half a step, per step squared
_OF_GAP = 0.5  # share of the greatest gap over which may be pooled


def setting(
    default: Any,
    meaning: str,
    unit: str = "",
    low: float = -math.inf,
    high: float = math.inf,
    *,
    fixed: bool = False,
) -> Any:
    """Return a dataclass field with its meaning, unit and range; `fixed`: not while running."""
    metadata = {"meaning": meaning, "unit": unit, "low": low, "high": high, "fixed": fixed}
    return field(default=default, metadata=metadata)


@dataclass(frozen=True)
class Joint:
    """How one pulley appears in the joint state."""

    name: str = setting("", "name of the joint in joint_states", fixed=True)
    gear_ratio: float = setting(
        1.0, "turns of the joint per turn of the pulley", "-", 1e-6, 1e6, fixed=True
    )
    sign: float = setting(
        1.0, "-1 if the joint counts against the belt", "-", -1.0, 1.0, fixed=True
    )
    torque_scale: float = setting(
        1.0, "joint torque per unit of effort, e.g. a motor's N m/A", "N m", -1e9, 1e9, fixed=True
    )
    torque_offset: float = setting(0.0, "effort reported at no torque", "-", -1e9, 1e9, fixed=True)
    drag_torque: float = setting(
        0.0,
        "of the bearings at the pulley, whatever its speed, against rotation",
        "N m",
        0.0,
        1e9,
        fixed=True,
    )
    drag_damping: float = setting(
        0.0, "of the bearings at the pulley, per pulley speed", "N m s/rad", 0.0, 1e9, fixed=True
    )

    @property
    def turn(self) -> float:
        """What one turn of the joint turns the pulley by [rad]."""
        return 2.0 * math.pi / self.gear_ratio

    def pulley_position(self, position: float) -> float:
        """Pulley angle [rad] from the joint's position."""
        return self.sign * position / self.gear_ratio

    def pulley_speed(self, velocity: float) -> float:
        """Pulley speed [rad/s] from the joint's velocity."""
        return self.sign * velocity / self.gear_ratio

    def drag(self, speed: float) -> float:
        """Torque of the bearings against rotation [N m] at a pulley speed [rad/s].

        ``drag_torque tanh(speed / 0.05 rad/s) + drag_damping speed``: Coulomb drag fades out about
        standstill, where its sign would flip with every noise of the speed. Bearings without drag
        have none at any speed, also at one that is not known (NaN).
        """
        if self.drag_torque == self.drag_damping == 0.0:
            return 0.0
        return self.drag_torque * math.tanh(speed / _DRAG_ROUNDING) + self.drag_damping * speed

    def pulley_torque(self, effort: float, speed: float) -> float:
        """Net torque on the pulley from outside [N m], which inertia and belt take.

        ``sign (effort - torque_offset) torque_scale gear_ratio - drag(speed)``: what the motor or
        load puts on the pulley, less what the bearings keep. A loss-free gear is assumed.

        Parameters
        ----------
        effort : float
            As the joint reports it, e.g. a motor current [A].
        speed : float
            Of the pulley [rad/s], in its positive direction.
        """
        put_on = self.sign * (effort - self.torque_offset) * self.torque_scale * self.gear_ratio
        return put_on - self.drag(speed)

    def effort(self, torque: float, speed: float) -> float:
        """Effort at which `pulley_torque` is `torque` [N m]."""
        per_effort = self.sign * self.torque_scale * self.gear_ratio
        return (torque + self.drag(speed)) / per_effort + self.torque_offset


@dataclass(frozen=True)
class Prior:
    """What is known of the belt before it runs, as a value and a standard deviation."""

    tension: float = setting(
        400.0, "tension held by the tensioning: mean, or slack, when installed", "N", 1e-3, 1e9
    )
    tension_stddev: float = setting(120.0, "its standard deviation", "N", 1e-6, 1e9)
    friction_stiffness: float = setting(1e8, "kf, median", "N/m2", 1.0, 1e15)
    friction_stiffness_decades: float = setting(
        1.0, "standard deviation of log10 kf", "decades", 1e-4, 4.0
    )
    friction_coefficient: float = setting(0.5, "mu, belt on pulley", "-", 1e-3, 10.0)
    friction_coefficient_stddev: float = setting(0.025, "its standard deviation", "-", 1e-6, 10.0)
    ratio_bias_stddev: float = setting(
        2e-4, "standard deviation of the error of R1/R2, relative", "-", 1e-9, 0.1
    )
    creep_error_stddev: float = setting(
        0.03, "standard deviation of the model's error in creep, relative", "-", 1e-9, 0.5
    )


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of one sample of each sensor, all as seen at the pulley."""

    speed_relative: float = setting(1e-4, "speed noise relative to speed", "-", 0.0, 1.0)
    speed_absolute: float = setting(1e-3, "speed noise, independent of speed", "rad/s", 1e-9, 1e6)
    torque_relative: float = setting(0.01, "torque noise relative to torque", "-", 0.0, 1.0)
    torque_absolute: float = setting(0.1, "torque noise, independent of torque", "N m", 1e-9, 1e9)
    speed_quantum: float = setting(
        0.0, "step in which speed is reported; 0: none", "rad/s", 0.0, 1e6
    )
    position_absolute: float = setting(1e-3, "position noise of a pulley", "rad", 1e-9, 1e3)
    position_quantum: float = setting(
        0.0, "step in which position is reported; 0: none", "rad", 0.0, 1e3
    )
    load_relative: float = setting(
        0.01, "noise of hub load and span tension relative to the load", "-", 0.0, 1.0
    )
    load_absolute: float = setting(
        1.0, "noise of hub load and span tension, independent of the load", "N", 1e-9, 1e9
    )

    def noise_rows(self) -> NDArray[np.float64]:
        """Return what `measurement.sensor_variances` needs, in the order of `Sensor`.

        Returns
        -------
        ndarray
            (2, 9): variance relative to the square of the value, and variance independent of it. A
            quantum q adds q^2/12 to the latter.
        """
        speed = self.speed_absolute**2 + self.speed_quantum**2 * _ROUNDING_VARIANCE
        position = self.position_absolute**2 + self.position_quantum**2 * _ROUNDING_VARIANCE
        relative = (self.speed_relative**2, self.torque_relative**2, 0.0, self.load_relative**2)
        absolute = (speed, self.torque_absolute**2, position, self.load_absolute**2)
        return np.array([np.repeat(row, (2, 2, 2, 3)) for row in (relative, absolute)])


@dataclass(frozen=True)
class Drift:
    """How what is estimated may change by itself: standard deviation after one second."""

    tension: float = setting(0.003, "tension, relative", "1/sqrt(s)", 1e-9, 10.0)
    tension_changes: float = setting(
        3e-3, "how often tension or friction begins to change quickly", "1/s", 1e-12, 0.5
    )
    friction_stiffness: float = setting(0.002, "kf, relative", "1/sqrt(s)", 1e-9, 10.0)
    friction_coefficient: float = setting(0.001, "mu, relative", "1/sqrt(s)", 1e-9, 10.0)
    torque: float = setting(
        1.0, "outside torques, relative to prior tension times radius", "1/sqrt(s)", 1e-6, 1e3
    )
    pull: float = setting(
        0.02,
        "effective pull beside its law of motion, relative to prior tension",
        "1/sqrt(s)",
        1e-9,
        10.0,
    )
    creep_error_time: float = setting(
        20.0, "correlation time of the model's error in creep", "s", 0.1, 1e9
    )
    creep_error_load: float = setting(
        5.0,
        "change of pull, in prior tensions, over which the model's error in creep becomes another",
        "-",
        1e-3,
        1e9,
    )


@dataclass(frozen=True)
class SensorLimits:
    """What a sensor can possibly say, and when silence is too long."""

    greatest_speed: float = setting(1e4, "greatest credible pulley speed", "rad/s", 1e-3, 1e9)
    greatest_torque: float = setting(1e6, "greatest credible torque", "N m", 1e-3, 1e12)
    greatest_load: float = setting(
        1e7, "greatest credible hub load or span tension", "N", 1e-3, 1e12
    )
    greatest_gap: float = setting(
        1.0, "longest gap between samples that is bridged rather than restarted", "s", 1e-3, 1e4
    )
    pool_period: float = setting(
        0.01,
        "measurements that come faster than this are averaged over it, to save work: so many "
        "estimates a second are enough for a belt; 0: each measurement makes an estimate",
        "s",
        0.0,
        1.0,
    )
    standstill_speed: float = setting(
        0.02, "rim speed below which the drive counts as standing", "m/s", 1e-9, 1e3
    )
    peak_load: float = setting(
        0.0,
        "greatest torque the driven pulley is to carry, for the probability that it slips; 0: none",
        "N m",
        0.0,
        1e12,
    )

    @property
    def pooled_over(self) -> float:
        """Over what fast measurements are averaged [s]; farther apart, means would be gaps."""
        return min(self.pool_period, _OF_GAP * self.greatest_gap)
