"""What identifies a drive: what was learned of one is no good for another."""

import dataclasses
import math
from dataclasses import dataclass

from belt_ros.mechanics.drive import BeltDrive


@dataclass(frozen=True)
class Fingerprint:
    """What a memory is only good for: drive and theory, without what is estimated, SI units.

    Inertias are left out: correcting one makes no other belt of it.
    """

    axial_stiffness: float  # EA [N]
    mass_per_length: float  # [kg/m]
    driven_radius: float  # [m]
    driven_wrap_angle: float  # [rad]
    driver_radius: float  # [m]
    driver_wrap_angle: float  # [rad]
    span_length: float  # [m]
    friction_ratio: float  # mu of the driver over mu of the driven pulley
    stiffness_ratio: float  # kf of the driver over kf of the driven pulley
    tensioning: str
    kinematics: str

    def differences(self, other: "Fingerprint") -> list[str]:
        """Return what `other` has differently, one phrase for each."""
        phrases = []
        for field in dataclasses.fields(self):
            mine, its = getattr(self, field.name), getattr(other, field.name)
            text = isinstance(mine, str)
            if not (mine == its if text else math.isclose(mine, its, rel_tol=1e-9)):
                now = f"{its}" if text else f"{its:.9g}"
                phrases.append(f"{field.name} was {mine if text else f'{mine:.9g}'}, is {now}")
        return phrases


def fingerprint(drive: BeltDrive) -> Fingerprint:
    """Return what identifies `drive`."""
    driven, driver = drive.driven, drive.driver
    return Fingerprint(
        axial_stiffness=drive.belt.axial_stiffness,
        mass_per_length=drive.belt.mass_per_length,
        driven_radius=driven.radius,
        driven_wrap_angle=driven.wrap_angle,
        driver_radius=driver.radius,
        driver_wrap_angle=driver.wrap_angle,
        span_length=drive.span_length,
        friction_ratio=driver.friction_coefficient / driven.friction_coefficient,
        stiffness_ratio=driver.friction_stiffness / driven.friction_stiffness,
        tensioning=drive.tensioning.value,
        kinematics=drive.kinematics.value,
    )
