"""A `BeltDrive` as plain numbers, in the form that compiled code takes."""

from typing import NamedTuple

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.arc_profile import PulleyArc, pulley_arc
from belt_ros.mechanics.drive import BeltDrive, Kinematics, Tensioning

HELD_MEAN, HELD_SLACK, HELD_HUB_LOAD, FIXED_CENTRES = range(4)

_TENSIONING = {
    Tensioning.CONSTANT_MEAN: HELD_MEAN,
    Tensioning.CONSTANT_SLACK: HELD_SLACK,
    Tensioning.CONSTANT_HUB_LOAD: HELD_HUB_LOAD,
    Tensioning.FIXED_CENTRES: FIXED_CENTRES,
}


class DriveConstants(NamedTuple):
    """A drive's fixed numbers, SI units; those of the belt's condition come with each call."""

    axial_stiffness: float
    mass_per_length: float
    driven_radius: float
    driven_wrap: float
    driven_inertia: float
    driver_radius: float
    driver_wrap: float
    driver_inertia: float
    friction_ratio: float  # mu of the driver over mu of the driven pulley
    stiffness_ratio: float  # kf of the driver over kf of the driven pulley
    span_length: float  # of one free span [m]
    span_compliance: float  # change of winding per change of pull, L/(2 EA) [m/N]
    tensioning: int
    exact_strain: bool


def drive_constants(drive: BeltDrive) -> DriveConstants:
    """Return `drive` in the form that compiled code takes."""
    # Plain floats throughout: compiled code is compiled anew for every other type.
    return DriveConstants(
        axial_stiffness=float(drive.belt.axial_stiffness),
        mass_per_length=float(drive.belt.mass_per_length),
        driven_radius=float(drive.driven.radius),
        driven_wrap=float(drive.driven.wrap_angle),
        driven_inertia=float(drive.driven.inertia),
        driver_radius=float(drive.driver.radius),
        driver_wrap=float(drive.driver.wrap_angle),
        driver_inertia=float(drive.driver.inertia),
        friction_ratio=drive.driver.friction_coefficient / drive.driven.friction_coefficient,
        stiffness_ratio=drive.driver.friction_stiffness / drive.driven.friction_stiffness,
        span_length=float(drive.span_length),
        span_compliance=drive.span_length / (2.0 * drive.belt.axial_stiffness),
        tensioning=_TENSIONING[drive.tensioning],
        exact_strain=drive.kinematics is Kinematics.EXACT,
    )


@compiled
def traction_limit(c: DriveConstants, mu: float) -> float:
    """Traction ln(w_H/w_L) [-] at which the first pulley slips; `mu` is the driven pulley's."""
    return mu * min(c.driven_wrap, c.friction_ratio * c.driver_wrap)


@compiled
def both_arcs(
    c: DriveConstants, mu: float, kf: float, net: float, driven_receives: bool
) -> tuple[PulleyArc, PulleyArc]:
    """Arcs of the pulley that receives the power and of the one that gives it, not yet loaded.

    `mu` and `kf` are the driven pulley's, `net` is K = EA - m v^2 [N].
    """
    mu2, kf2 = mu * c.friction_ratio, kf * c.stiffness_ratio
    driven_role = 1 if driven_receives else -1
    driven = pulley_arc(c.driven_radius, c.driven_wrap, mu, kf, net, driven_role)
    driver = pulley_arc(c.driver_radius, c.driver_wrap, mu2, kf2, net, -driven_role)
    return (driven, driver) if driven_receives else (driver, driven)
