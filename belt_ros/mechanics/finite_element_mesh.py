"""The discretised drive: geometry of an open belt, elements, time step, the belt at its start."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from belt_ros.mechanics.drive import BeltDrive, DriveError, Pulley, require_positive
from belt_ros.mechanics.finite_element_kernel import Mesh, Rim, State

_FEWEST_ELEMENTS = 6
_MOST_ELEMENTS = 10_000
_SHORTEST_SPAN = 5
_LEAST_AXIAL_DAMPING = 0.05  # without any, Coulomb friction feeds the highest modes
_WRAP_TOLERANCE = 0.01
_TIME_STEP_SAFETY = 0.9


@dataclass(frozen=True)
class Discretisation:
    """How finely the belt is divided, and the numerical constants of its contact.

    Parameters
    ----------
    elements_per_half_pulley : int
        Elements on half the circumference of the smaller pulley.
    penalty_ratio : float
        Contact stiffness of a node over the stiffness EA/h of an element [-]. The belt then sinks
        in by strain (h/R)^2 / `penalty_ratio` of the radius.
    contact_damping : float
        Share of critical damping of a node's radial motion on the rim [-]. Contact never adheres.
    axial_damping : float
        Share of critical damping of the belt's highest axial mode [-] (Kelvin-Voigt).
    span_damping : float
        Share of critical damping of a span's first lateral mode [-], on lateral velocity only,
        which a transported straight span does not have.
    """

    elements_per_half_pulley: int = 100
    penalty_ratio: float = 1.0
    contact_damping: float = 1.0
    axial_damping: float = 0.5
    span_damping: float = 1.0

    def __post_init__(self) -> None:
        if self.elements_per_half_pulley < _FEWEST_ELEMENTS:
            raise DriveError(
                f"{self.elements_per_half_pulley} elements per half pulley are too coarse; "
                f"take at least {_FEWEST_ELEMENTS}"
            )
        require_positive(self.penalty_ratio, "penalty ratio")
        for name, least in (
            ("contact_damping", 0.0),
            ("axial_damping", _LEAST_AXIAL_DAMPING),
            ("span_damping", 0.0),
        ):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= least):
                raise DriveError(f"{name} is {value:g}; it must be finite and >= {least:g}")


class OpenBelt(NamedTuple):
    """Geometry of an open belt on two pulleys."""

    driven_wrap: float  # [rad]
    driver_wrap: float  # [rad]
    span_length: float  # of one span [m]


def open_belt(driven_radius: float, driver_radius: float, centre_distance: float) -> OpenBelt:
    """Return the wraps and the span length of an open belt.

    Parameters
    ----------
    driven_radius, driver_radius : float
        R1, R2 [m].
    centre_distance : float
        Between the axes [m].

    Raises
    ------
    DriveError
        Where the pulleys overlap, or for a length that is not positive.
    """
    require_positive(driven_radius, "driven radius", "m")
    require_positive(driver_radius, "driver radius", "m")
    if not centre_distance > driven_radius + driver_radius:
        raise DriveError(
            f"the pulleys overlap: centre distance {centre_distance:g} m is not above the sum of "
            f"the radii {driven_radius + driver_radius:g} m"
        )
    surplus = 2.0 * math.asin((driven_radius - driver_radius) / centre_distance)
    span = math.sqrt(centre_distance**2 - (driven_radius - driver_radius) ** 2)
    return OpenBelt(math.pi + surplus, math.pi - surplus, span)


def centre_distance(drive: BeltDrive) -> float:
    """Return the distance between the axes [m] that span length and radii mean.

    Raises
    ------
    DriveError
        Where the pulleys overlap or the wraps are not those of an open belt.
    """
    r1, r2 = drive.driven.radius, drive.driver.radius
    distance = math.hypot(drive.span_length, r1 - r2)
    geometry = open_belt(r1, r2, distance)
    wraps = (drive.driven.wrap_angle, drive.driver.wrap_angle)
    if max(abs(wraps[0] - geometry[0]), abs(wraps[1] - geometry[1])) > _WRAP_TOLERANCE:
        raise DriveError(
            f"wrap angles {wraps[0]:g} and {wraps[1]:g} rad (driven, driver) are not those of an "
            f"open belt with spans of {drive.span_length:g} m: {geometry[0]:.6g} and "
            f"{geometry[1]:.6g} rad"
        )
    return distance


def _rim(
    pulley: Pulley, centre: float, element: float, sinking: float, inlet: float, wrap: float
) -> Rim:
    """Return a pulley on which the belt, sunk in at rest, forms a polygon as long as the true arc.

    On the bare radius the belt's speed on a rim would be short by (h/R)^2/24 and by how far it
    sinks in, and slip is a small difference of such speeds.
    """
    polygon = 0.5 * element / math.sin(0.5 * element / pulley.radius)
    return Rim(
        centre,
        polygon + sinking / pulley.radius,
        pulley.friction_coefficient,
        pulley.friction_stiffness,
        inlet,
        wrap,
    )


def _stable_time_step(mesh: Mesh, tension: float, driven: Pulley) -> float:
    """Stability limit of central differences with lagged damping, times a safety [s].

    It is 2/omega (sqrt(1 + zeta^2) - zeta) of the highest mode, here bounded along the belt
    (elements, friction springs, the pulley they turn) and across it (contact, string stiffness).
    """
    h, m = mesh.rest_length, mesh.node_mass
    axial = mesh.axial_stiffness / h
    kf = max(mesh.driven.stiffness, mesh.driver.stiffness)
    turning = mesh.driven.stiffness * driven.radius**3 * mesh.driven.wrap / driven.inertia
    along = (4.0 * axial + kf * h) / m + turning
    across = (mesh.penalty + 4.0 * tension / h) / m
    limits = []
    for square, rate in (
        (along, 4.0 * axial * mesh.retardation / m),
        (across, mesh.contact_damping / m + mesh.span_damping),
    ):
        omega = math.sqrt(square)
        zeta = 0.5 * rate / omega
        limits.append(2.0 / omega * (math.sqrt(1.0 + zeta * zeta) - zeta))
    return _TIME_STEP_SAFETY * min(limits)


def _count_elements(drive: BeltDrive, path: float, per_half_pulley: int) -> int:
    """Elements of the whole belt of length `path` [m]."""
    n = round(path / (math.pi * min(drive.driven.radius, drive.driver.radius)) * per_half_pulley)
    if n > _MOST_ELEMENTS:
        raise DriveError(
            f"{n} elements exceed the limit of {_MOST_ELEMENTS}; take fewer per half pulley"
        )
    if drive.span_length < _SHORTEST_SPAN * path / n:
        raise DriveError(
            f"a span of {drive.span_length:g} m is shorter than {_SHORTEST_SPAN} elements of "
            f"{path / n:g} m; take more elements per half pulley"
        )
    return n


def build_mesh(drive: BeltDrive, tension: float, discretisation: Discretisation) -> Mesh:
    """Divide a drive, installed with `tension` [N], into elements; the time step is the limit.

    Raises
    ------
    DriveError
        For an impossible geometry, or a number of elements out of bounds.
    """
    distance = centre_distance(drive)
    r1, r2 = drive.driven.radius, drive.driver.radius
    tangent = math.acos((r1 - r2) / distance)  # polar angle where the upper span touches
    wraps = (2.0 * math.pi - 2.0 * tangent, 2.0 * tangent)
    path = 2.0 * drive.span_length + r1 * wraps[0] + r2 * wraps[1]
    n = _count_elements(drive, path, discretisation.elements_per_half_pulley)
    h = path / n
    rest = h / (1.0 + tension / drive.belt.axial_stiffness)
    mass = drive.belt.mass_per_length * rest
    axial = drive.belt.axial_stiffness / rest
    penalty = discretisation.penalty_ratio * axial
    sinking = tension * h / penalty  # times the radius [m2]
    wave_speed = math.sqrt(tension / drive.belt.mass_per_length)
    mesh = Mesh(
        elements=n,
        driven=_rim(drive.driven, 0.0, h, sinking, tangent, wraps[0]),
        driver=_rim(drive.driver, distance, h, sinking, -tangent, wraps[1]),
        inertia=drive.driven.inertia,
        time_step=math.nan,
        axial_stiffness=drive.belt.axial_stiffness,
        rest_length=rest,
        node_mass=mass,
        retardation=discretisation.axial_damping * math.sqrt(mass / axial),
        penalty=penalty,
        contact_damping=2.0 * discretisation.contact_damping * math.sqrt(penalty * mass),
        span_damping=2.0 * discretisation.span_damping * math.pi * wave_speed / drive.span_length,
        middle=0.5 * (distance + r1 - r2),
        span_start=r1 * math.cos(tangent),
        span_end=distance + r2 * math.cos(tangent),
        normal_x=math.cos(tangent),
        normal_y=math.sin(tangent),
    )
    return mesh._replace(time_step=_stable_time_step(mesh, tension, drive.driven))


def initial_state(drive: BeltDrive, mesh: Mesh, tension: float, driver_speed: float) -> State:
    """Belt on the rims under its installed tension [N], moving with the driver [rad/s].

    The driven pulley goes along without slip.
    """
    n = mesh.elements
    h = mesh.rest_length * (1.0 + tension / drive.belt.axial_stiffness)
    along = (np.arange(n) + 0.5) * h
    place, direction = np.empty((n + 1, 2)), np.empty((n + 1, 2))
    start = 0.0
    for rim, pulley in ((mesh.driven, drive.driven), (mesh.driver, drive.driver)):
        arc = pulley.radius * rim.wrap
        part = np.flatnonzero((along >= start) & (along < start + arc + drive.span_length))
        angle = rim.inlet + np.minimum(along[part] - start, arc) / pulley.radius
        on_span = np.maximum(along[part] - start - arc, 0.0)[:, np.newaxis]
        radius = rim.radius - tension * h / (pulley.radius * mesh.penalty)
        outward = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        direction[part] = np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
        place[part] = (rim.centre, 0.0) + radius * outward + on_span * direction[part]
        start += arc + drive.span_length
    place[n], direction[n] = place[0], direction[0]
    speed = drive.driver.radius * driver_speed
    return State(
        x=place[:, 0].copy(),
        y=place[:, 1].copy(),
        vx=speed * direction[:, 0],
        vy=speed * direction[:, 1],
        stretch=np.zeros(n),
        length=np.full(n, h),
        tension=np.full(n, tension),
        pull_x=np.zeros(n),
        pull_y=np.zeros(n),
        friction=np.zeros(n),
        normal=np.zeros(n),
        driven_speed=np.array([speed / drive.driven.radius]),
    )
