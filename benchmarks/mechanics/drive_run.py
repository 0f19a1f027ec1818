"""The paper's drive at work: what is imposed on it, and how far a run is from equilibrium.

Both simulators get the same drive and history (Table 1 of the paper): driver speed and load torque
rise together and smoothly, then stay. What is judged is friction along both arcs, averaged over the
last moments in bins about an element long, against the EPP equilibrium at the run's own tensions.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.mechanics.arc import Role, solve_arc
from belt_ros.mechanics.drive import Belt, BeltDrive, Pulley
from benchmarks.mechanics.clock import Seconds

Floats = NDArray[np.float64]

RADIUS = 0.08125  # [m]
SPAN = 2.0 * math.pi * RADIUS  # [m]
FRICTION = 1.2
BELT = Belt(axial_stiffness=80_068.0, mass_per_length=0.1036)
INERTIA = 0.01  # of the driven pulley [kg m2]
INSTALLED = 434.0  # [N]
SPEED = 120.0  # of the driver [rad/s]
TORQUE = 45.0  # of the load [N m]
RISE = 0.2  # [s]
END = 0.5  # [s]
WINDOW = 0.05  # over which results are averaged [s]
_POINTS = 50  # of the closed form in a bin


class ArcProfile(NamedTuple):
    """Friction along one arc."""

    angle: Floats  # middle of each bin, from the inlet [rad]
    friction: Floats  # [N/m], positive where it raises tension along travel


class DriveRun(NamedTuple):
    """One run of the drive, averaged over the last `WINDOW`."""

    solver: str
    elements: int  # of the whole belt
    friction_stiffness: float  # [N/m2]
    seconds: Seconds
    slack_tension: float  # [N]
    tight_tension: float  # [N]
    driven_speed: float  # [rad/s]
    driven: ArcProfile
    driver: ArcProfile


class Misfit(NamedTuple):
    """Distance of a run's friction from the equilibrium's, rms over an arc, of its peak."""

    driven: float
    driver: float

    @property
    def both(self) -> float:
        """Over both arcs."""
        return math.sqrt(0.5 * (self.driven**2 + self.driver**2))


def pulley(friction_stiffness: float) -> Pulley:
    """Return either pulley."""
    return Pulley(RADIUS, math.pi, FRICTION, friction_stiffness, INERTIA)


def paper_drive(friction_stiffness: float) -> BeltDrive:
    """Return the paper's drive."""
    both = pulley(friction_stiffness)
    return BeltDrive(BELT, both, both, span_length=SPAN)


def rise(time: float | Floats) -> Floats:
    """Share of speed and load that is on at a time [s]."""
    share = np.clip(np.asarray(time) / RISE, 0.0, 1.0)
    return np.asarray(share * share * (3.0 - 2.0 * share))


def bin_middles(bins: int) -> Floats:
    """Middles [rad] of equal bins over an arc."""
    return np.asarray((np.arange(bins, dtype=np.float64) + 0.5) * (math.pi / bins))


def equilibrium_friction(run: DriveRun, role: Role, angle: Floats) -> Floats:
    """Friction [N/m] at angles from the inlet, by the closed form at the run's own tensions."""
    ends = (run.slack_tension, run.tight_tension)
    inlet, outlet = ends if role is Role.DRIVEN else ends[::-1]
    speed = RADIUS * SPEED
    lift = BELT.mass_per_length * speed**2
    net = BELT.axial_stiffness - lift
    solved = solve_arc(
        role,
        RADIUS,
        math.pi,
        FRICTION,
        run.friction_stiffness,
        BELT.axial_stiffness,
        BELT.mass_per_length,
        speed,
        inlet,
        outlet,
    )
    root = math.sqrt(run.friction_stiffness / net)
    transition = float(solved.transition_angle)
    gradient = float(solved.inlet_strain_gradient)
    creeping = (
        run.friction_stiffness
        * gradient
        / root
        * np.sinh(root * RADIUS * np.minimum(angle, transition))
    )
    at_limit = inlet - lift + net * gradient * (math.cosh(root * RADIUS * transition) - 1.0)
    past = np.maximum(angle - transition, 0.0)
    sliding = role * FRICTION / RADIUS * at_limit * np.exp(role * FRICTION * past)
    return np.where(angle <= transition, creeping, sliding)


def equilibrium_means(run: DriveRun, role: Role, bins: int) -> Floats:
    """Means of the equilibrium's friction [N/m] in equal bins over the arc."""
    friction = equilibrium_friction(run, role, bin_middles(bins * _POINTS))
    return np.asarray(friction.reshape(bins, _POINTS).mean(axis=1))


def misfit(run: DriveRun) -> Misfit:
    """Judge a run."""
    return Misfit(
        _arc_misfit(run, Role.DRIVEN, run.driven), _arc_misfit(run, Role.DRIVER, run.driver)
    )


def _arc_misfit(run: DriveRun, role: Role, profile: ArcProfile) -> float:
    peak = float(np.max(np.abs(equilibrium_friction(run, role, bin_middles(10_000)))))
    error = profile.friction - equilibrium_means(run, role, profile.angle.size)
    return float(np.sqrt(np.mean(error**2))) / peak
