"""Local stability of an arc in equilibrium: its natural frequencies and modes, Eqs. 61-72.

A small disturbance u = phi(s) e^(i omega t) of the running belt obeys, with sigma = +1 on a driven
and -1 on a driver arc,

    sprung:   m u_tt + 2 m v u_ts - (EA - m v^2) u_ss + kf u = 0                          Eq. 41
    sliding:  m u_tt + 2 m v u_ts - (EA - m v^2) u_ss
              + sigma (mu/R) ((EA - m v^2) u_s - m v u_t) = 0                             Eq. 42

held at the inlet, under constant tension at the outlet. It dies out if Im omega > 0.

Every such arc is stable at every speed below the critical one: `arc_spectrum` has the proof. It
holds for driven and driver arcs, whatever the zones. Travel is what damps; at standstill all omega
are real.

As in the paper, a disturbance does not move the zones' ends; friction is continuous there, so this
costs nothing to first order. Where a belt re-sticks (see `arc`), which the paper does not consider,
it is taken as sprung again with what it has slid so far as in equilibrium. Left out is that the
belt carries a disturbance of what it slid on through that zone. This does matter to first order:
it takes damping away, growing modes have been found with it, and the proof does not cover it.
Stability of a re-stuck arc is that of the simplified equations.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from belt_ros.mechanics.arc import Role
from belt_ros.mechanics.arc_spectrum import Zone, eigenvalues, shape
from belt_ros.mechanics.drive import Belt, BeltDrive, DriveError, Pulley
from belt_ros.mechanics.equilibrium import solve_equilibrium

LARGEST_COUNT = 20
_STABILITY_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class Modes:
    """Natural modes of one arc, by rising frequency of oscillation.

    Attributes
    ----------
    frequencies : ndarray of complex, shape (count,)
        omega [rad/s], Re omega >= 0; the real part oscillates, the imaginary part is the rate of
        decay [1/s]. One with Re omega > 0 stands for its pair omega and -conj(omega). Overdamped
        ones, Re omega = 0, have no partner and come first, each counted, the slowest ahead.
    wrap_angle : float
        phi [rad].
    zones : tuple of Zone
        Friction zones from inlet to outlet, scaled as in `arc_spectrum`.
    speed_ratio : float
        v/v_cr [-].
    eigenvalues : ndarray of complex, shape (count,)
        z of `arc_spectrum` [-].
    """

    frequencies: NDArray[np.complex128]
    wrap_angle: float
    zones: tuple[Zone, ...]
    speed_ratio: float
    eigenvalues: NDArray[np.complex128]

    @property
    def is_stable(self) -> bool:
        """Whether no mode found grows, up to 1e-9 of its frequency.

        Of a re-stuck arc, under what the module's docstring assumes of it.
        """
        growth = -self.frequencies.imag
        return bool(np.all(growth <= _STABILITY_TOLERANCE * np.abs(self.frequencies)))

    def shapes(self, angle: ArrayLike) -> NDArray[np.complex128]:
        """Eigenfunctions phi(s), Eq. 69.

        Parameters
        ----------
        angle : array_like
            From the inlet [rad], 0 to the wrap angle.

        Returns
        -------
        ndarray of complex, shape (count, *angle.shape)
            Normalised to a greatest magnitude of 1, the slope at the inlet real and positive.

        Raises
        ------
        DriveError
            For an angle off the arc.
        """
        angles = np.asarray(angle, dtype=np.float64)
        if np.any(bad := ~((angles >= 0.0) & (angles <= self.wrap_angle))):
            raise DriveError(
                f"angle {angles[bad].flat[0]:g} rad is not on the arc of {self.wrap_angle:g} rad"
            )
        at = angles.ravel() / self.wrap_angle
        found = [shape(complex(z), self.zones, self.speed_ratio, at) for z in self.eigenvalues]
        return np.stack(found).reshape(-1, *angles.shape)


class DriveModes(NamedTuple):
    """Natural modes of both pulleys' arcs."""

    driven: Modes
    driver: Modes


def _check_count(count: int) -> None:
    if not 1 <= count <= LARGEST_COUNT:
        raise DriveError(f"{count} modes asked for; from 1 to {LARGEST_COUNT} can be had")


def _check_motion(belt: Belt, speed: float) -> None:
    if belt.mass_per_length == 0.0:
        raise DriveError(
            "mass per length is 0 kg/m: without inertia an arc follows at once and has no "
            "frequencies; give the belt its mass"
        )
    if not speed >= 0.0:
        raise DriveError(
            f"belt speed {speed:g} m/s is against the arc's direction; it must be >= 0"
        )
    if not speed < belt.critical_speed:
        raise DriveError(
            f"belt speed {speed:g} m/s is not below the critical speed {belt.critical_speed:g} m/s"
        )


def _zones(
    role: Role, pulley: Pulley, transition: float, restick: float, stretch: float
) -> tuple[Zone, ...]:
    """Return the arc's zones, `stretch` being X = lambda R phi [-]."""
    wrap = pulley.wrap_angle
    if not 0.0 <= transition <= wrap:
        raise DriveError(
            f"transition angle {transition:g} rad is not within the wrap angle {wrap:g} rad"
        )
    end = wrap
    if not math.isnan(restick):
        if role is Role.DRIVER or stretch >= pulley.traction_limit:
            raise DriveError(
                f"re-stick angle {restick:g} rad: only driven arcs with mu > lambda R re-stick, "
                f"and this is a {role.name.lower()} arc with mu {pulley.friction_coefficient:g}, "
                f"lambda R {stretch / wrap:g}"
            )
        if not transition < restick <= wrap:
            raise DriveError(
                f"re-stick angle {restick:g} rad is not between the transition angle "
                f"{transition:g} rad and the wrap angle {wrap:g} rad"
            )
        end = restick
    spring = stretch * stretch
    drift = role * pulley.traction_limit
    zones = (
        Zone(transition / wrap, 0.0, spring),
        Zone((end - transition) / wrap, drift, 0.0),
        Zone((wrap - end) / wrap, 0.0, spring),
    )
    return tuple(zone for zone in zones if zone.length > 0.0)


def arc_modes(
    role: Role,
    radius: float,
    wrap_angle: float,
    transition_angle: float,
    friction_coefficient: float,
    friction_stiffness: float,
    axial_stiffness: float,
    mass_per_length: float,
    speed: float,
    count: int = 3,
    restick_angle: float = math.nan,
) -> Modes:
    """Lowest natural modes of an arc about its equilibrium, Eqs. 63-68.

    Parameters
    ----------
    role : Role
        Whether tension rises or falls along the arc.
    radius, wrap_angle : float
        R [m], phi [rad].
    transition_angle : float
        theta* [rad] from the inlet, where sliding begins; the wrap angle if it never does.
    friction_coefficient, friction_stiffness : float
        mu [-], kf [N/m2].
    axial_stiffness, mass_per_length : float
        EA [N], m [kg/m].
    speed : float
        Of the belt at the inlet [m/s].
    count : int
        How many modes, 1 to 20.
    restick_angle : float
        Where sliding ends again [rad]; NaN if it does not.

    Returns
    -------
    Modes

    Raises
    ------
    DriveError
        For a belt without mass, at or above its critical speed (Eq. 72) or running backwards, for
        angles off the arc, a re-stick that cannot be, a count out of range, a parameter that is not
        positive, or modes that did not converge.
    """
    _check_count(count)
    belt = Belt(axial_stiffness, mass_per_length)
    pulley = Pulley(radius, wrap_angle, friction_coefficient, friction_stiffness)
    _check_motion(belt, speed)
    beta = speed / belt.critical_speed
    gamma = (1.0 - beta) * (1.0 + beta)
    length = radius * wrap_angle
    stretch = length * math.sqrt(friction_stiffness / (axial_stiffness * gamma))
    zones = _zones(Role(role), pulley, transition_angle, restick_angle, stretch)
    z = eigenvalues(zones, beta, count)
    if z.size < count:
        raise DriveError(f"{z.size} of {count} modes converged at {beta:g} of the critical speed")
    omega = -1j * z * (gamma * belt.critical_speed / length)
    return Modes(omega, wrap_angle, zones, beta, z)


def drive_modes(
    drive: BeltDrive, torque: float, tension: float, driver_speed: float, count: int = 3
) -> DriveModes:
    """Lowest natural modes of both arcs of a drive in equilibrium.

    Parameters
    ----------
    drive : BeltDrive
    torque : float
        Torque that the belt puts on the driven pulley [N m].
    tension : float
        What the tensioning holds constant, as for `solve_equilibrium`.
    driver_speed : float
        omega2 [rad/s].
    count : int
        How many modes of each arc, 1 to 20.

    Returns
    -------
    DriveModes

    Raises
    ------
    DriveError
        As `solve_equilibrium` and `arc_modes`.
    """
    speed = abs(driver_speed) * drive.driver.radius
    _check_count(count)
    _check_motion(drive.belt, speed)
    state = solve_equilibrium(drive, torque, tension, driver_speed)

    def modes(pulley: Pulley, role: Role, transition: float, restick: float) -> Modes:
        return arc_modes(
            role,
            pulley.radius,
            pulley.wrap_angle,
            min(transition, pulley.wrap_angle),  # rounding may put it a digit beyond
            pulley.friction_coefficient,
            pulley.friction_stiffness,
            drive.belt.axial_stiffness,
            drive.belt.mass_per_length,
            speed,
            count,
            restick,
        )

    receives = torque >= 0.0 if driver_speed >= 0.0 else torque <= 0.0
    driven, driver = (Role.DRIVEN, Role.DRIVER) if receives else (Role.DRIVER, Role.DRIVEN)
    return DriveModes(
        modes(
            drive.driven,
            driven,
            float(state.driven_transition_angle),
            float(state.driven_restick_angle),
        ),
        modes(
            drive.driver,
            driver,
            float(state.driver_transition_angle),
            float(state.driver_restick_angle),
        ),
    )
