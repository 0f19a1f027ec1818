"""What a belt drive is: belt, pulleys and how they are tensioned, in SI units, checked once."""

import math
from dataclasses import dataclass, replace
from enum import Enum
from numbers import Real

_GREATEST_TRACTION = 500.0


class DriveError(ValueError):
    """A drive, or a state asked of it, that cannot exist; the message names the broken limit."""


class Kinematics(Enum):
    """How the strain of the two spans enters slip."""

    EXACT = "exact"  # mass conservation, (1 + T_L/EA)/(1 + T_H/EA)
    LINEAR = "linear"  # the paper's 1/(1 + (T_H - T_L)/EA)


class Tensioning(Enum):
    """What the installation holds constant while torque and speed change.

    A drive's tension is given as what is held: mean or slack tension; for a hub load and for fixed
    centres the belt's tension when installed, at standstill and without torque. w = T - m v^2 is
    the effective tension.
    """

    CONSTANT_MEAN = "constant_mean"  # (T_H + T_L)/2, at any speed
    CONSTANT_SLACK = "constant_slack"  # T_L: spring or gravity take-up on the slack span
    CONSTANT_HUB_LOAD = "constant_hub_load"  # (w_H + w_L)/2: a shaft pulled by weight or spring
    FIXED_CENTRES = "fixed_centres"  # the belt's length: shafts bolted down


def require_positive(value: object, name: str, unit: str = "") -> None:
    """Raise `DriveError` unless `value` is a finite positive number."""
    if not isinstance(value, Real):
        raise DriveError(f"{name} is {value!r}; it must be a number")
    number = float(value)
    if not (math.isfinite(number) and number > 0.0):
        raise DriveError(f"{name} is {number:g} {unit}".rstrip() + "; it must be finite and > 0")


@dataclass(frozen=True)
class Belt:
    """A flat belt.

    Parameters
    ----------
    axial_stiffness : float
        EA [N].
    mass_per_length : float
        m [kg/m]; 0 leaves inertia out, as the paper's worked example does.
    """

    axial_stiffness: float
    mass_per_length: float = 0.0

    def __post_init__(self) -> None:
        require_positive(self.axial_stiffness, "belt axial stiffness EA", "N")
        if not (math.isfinite(self.mass_per_length) and self.mass_per_length >= 0.0):
            raise DriveError(
                f"belt mass per length is {self.mass_per_length:g} kg/m; it must be finite and >= 0"
            )

    @property
    def critical_speed(self) -> float:
        """Speed [m/s] at which a travelling belt loses its stiffness, Eq. 72."""
        if self.mass_per_length == 0.0:
            return math.inf
        return math.sqrt(self.axial_stiffness / self.mass_per_length)


@dataclass(frozen=True)
class Pulley:
    """One pulley and the belt's friction on it.

    Parameters
    ----------
    radius : float
        R [m], to the belt's neutral line.
    wrap_angle : float
        phi [rad], less than a full turn.
    friction_coefficient : float
        mu [-].
    friction_stiffness : float
        kf [N/m2], the tangential stiffness of the contact per unit length of belt, Eq. 1.
    inertia : float
        J [kg m2] of the pulley and of all that turns rigidly with it.
    """

    radius: float
    wrap_angle: float
    friction_coefficient: float
    friction_stiffness: float
    inertia: float = 0.01

    def __post_init__(self) -> None:
        require_positive(self.radius, "pulley radius", "m")
        require_positive(self.wrap_angle, "wrap angle", "rad")
        if self.wrap_angle >= 2.0 * math.pi:
            raise DriveError(
                f"wrap angle is {self.wrap_angle:g} rad; a belt wraps less than a turn (2 pi rad)"
            )
        require_positive(self.friction_coefficient, "friction coefficient mu")
        require_positive(self.friction_stiffness, "friction stiffness kf", "N/m2")
        require_positive(self.inertia, "pulley inertia", "kg m2")
        if self.traction_limit > _GREATEST_TRACTION:
            raise DriveError(
                f"mu phi is {self.traction_limit:g}; above {_GREATEST_TRACTION:g} tensions would "
                "overflow, reduce the friction coefficient or the wrap angle"
            )

    @property
    def traction_limit(self) -> float:
        """Natural logarithm of the greatest ratio of effective tensions, mu phi [-]."""
        return self.friction_coefficient * self.wrap_angle


@dataclass(frozen=True)
class BeltDrive:
    """A belt on two pulleys.

    Parameters
    ----------
    belt : Belt
    driven, driver : Pulley
        Pulley 1 and pulley 2 of the paper.
    span_length : float
        Free length of one span [m].
    kinematics : Kinematics
        Exact by default; linear reproduces the paper.
    tensioning : Tensioning
        What stays constant as torque changes.
    """

    belt: Belt
    driven: Pulley
    driver: Pulley
    span_length: float = 0.5
    kinematics: Kinematics = Kinematics.EXACT
    tensioning: Tensioning = Tensioning.CONSTANT_MEAN

    def __post_init__(self) -> None:
        require_positive(self.span_length, "span length", "m")
        self._check_pulleys_apart()

    def _check_pulleys_apart(self) -> None:
        """Raise if an open belt with these spans would have its pulleys overlap."""
        open_belt = abs(self.driven.wrap_angle + self.driver.wrap_angle - 2.0 * math.pi) < 1e-3
        shortest = 2.0 * math.sqrt(self.driven.radius * self.driver.radius)
        if open_belt and self.span_length < shortest * (1.0 - 1e-9):
            raise DriveError(
                f"the pulleys overlap: the span length is {self.span_length:g} m; pulleys of "
                f"{self.driven.radius:g} m and {self.driver.radius:g} m that just touch have one "
                f"of {shortest:g} m"
            )

    def without_inertia(self) -> "BeltDrive":
        """Return the same drive with a massless belt."""
        return replace(self, belt=replace(self.belt, mass_per_length=0.0))
