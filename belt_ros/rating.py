"""What the mechanics says of a drive as it is described, before it has run."""

import math
from dataclasses import dataclass, replace

from belt_ros.mechanics import BeltDrive, solve_equilibrium, torque_capacity
from belt_ros.settings import DriveSettings

_SIGMAS_95 = 1.96
_LOADS = (0.25, 0.5, 0.75)


@dataclass(frozen=True)
class LoadPoint:
    """Steady state at a share of the torque capacity; the creep's range is that of kf."""

    load: float  # [-] of the capacity
    torque: float  # [N m] on the driven pulley
    creep: float  # [-]
    creep_low: float  # [-] at the stiffest friction of its 95 % interval
    creep_high: float  # [-] at the softest
    tight_tension: float  # [N]
    slack_tension: float  # [N]


@dataclass(frozen=True)
class Rating:
    """Limits and expected creep of a drive at its prior, running slowly."""

    critical_speed: float  # [m/s] of the belt; infinite for a massless one
    capacity: float  # [N m] on the driven pulley
    capacity_low: float  # [N m] 95 % interval, from the priors of tension and friction
    capacity_high: float  # [N m]
    loads: tuple[LoadPoint, ...]


def rate(settings: DriveSettings) -> Rating:
    """Return the rating of a drive.

    Raises
    ------
    DriveError
        If the prior tension or friction allows no steady state.
    """
    drive, tension = settings.drive, settings.prior.tension
    capacity = float(torque_capacity(drive, tension))
    factor = math.exp(_SIGMAS_95 * _log_spread(settings))
    return Rating(
        critical_speed=drive.belt.critical_speed,
        capacity=capacity,
        capacity_low=capacity / factor,
        capacity_high=capacity * factor,
        loads=tuple(_load_point(settings, load, load * capacity) for load in _LOADS),
    )


def _log_spread(settings: DriveSettings) -> float:
    """Return the standard deviation of ln(capacity), tension and friction being log-normal."""
    prior = settings.prior
    tension = _log_normal_spread(prior.tension, prior.tension_stddev)
    friction = _log_normal_spread(prior.friction_coefficient, prior.friction_coefficient_stddev)

    def log_capacity(deviation: float) -> float:
        drive = _with_friction(settings.drive, math.exp(deviation), 1.0)
        return math.log(float(torque_capacity(drive, prior.tension)))

    slope = log_capacity(friction) - log_capacity(-friction)
    return math.hypot(tension, 0.5 * slope)  # capacity is proportional to tension


def _log_normal_spread(mean: float, stddev: float) -> float:
    return math.sqrt(math.log1p((stddev / mean) ** 2))


def _with_friction(drive: BeltDrive, coefficient: float, stiffness: float) -> BeltDrive:
    """Return the drive with friction coefficient and stiffness scaled on both pulleys."""
    driven, driver = (
        replace(
            pulley,
            friction_coefficient=pulley.friction_coefficient * coefficient,
            friction_stiffness=pulley.friction_stiffness * stiffness,
        )
        for pulley in (drive.driven, drive.driver)
    )
    return replace(drive, driven=driven, driver=driver)


def _load_point(settings: DriveSettings, load: float, torque: float) -> LoadPoint:
    def creep(stiffness: float) -> float:
        drive = _with_friction(settings.drive, 1.0, stiffness)
        return float(solve_equilibrium(drive, torque, settings.prior.tension, 0.0).slip)

    state = solve_equilibrium(settings.drive, torque, settings.prior.tension, 0.0)
    factor = 10.0 ** (_SIGMAS_95 * settings.prior.friction_stiffness_decades)
    return LoadPoint(
        load=load,
        torque=torque,
        creep=float(state.slip),
        creep_low=creep(factor),
        creep_high=creep(1.0 / factor),
        tight_tension=float(state.tight_tension),
        slack_tension=float(state.slack_tension),
    )
