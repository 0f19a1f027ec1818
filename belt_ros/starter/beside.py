"""Answers beside each other: what cannot be shows by what else is known of the drive."""

from collections.abc import Callable, Mapping
from typing import Any

from belt_ros.mechanics import DriveError
from belt_ros.mechanics.materials import SurfaceState, belt_material
from belt_ros.mechanics.units import meant_millimetres
from belt_ros.parameter_table import PARAMETERS, SettingsError

USUAL_SURFACE = "steel"
_FAR = 100.0  # times what is typical of the belt, or so much less; another unit is 1000 times off
# Pulleys do not overlap, so whatever distance is told in millimetres is farther than this.
_FARTHEST = 1000.0  # times the sum of the radii

_Said = Mapping[str, Any]


def check_beside(name: str, said: _Said) -> None:
    """Check one answer beside those that are known.

    Parameters
    ----------
    name : str
        Of the answer.
    said : mapping
        Answers by name, each checked by itself, this one included.

    Raises
    ------
    SettingsError
        If it cannot be; the message has value and limit.
    """
    check = _CHECKS.get(name)
    if check is not None:
        check(said)


def _centre_distance(said: _Said) -> None:
    if not {"driver_radius", "driven_radius"} <= said.keys():
        return
    distance, low = said["centre_distance"], said["driver_radius"] + said["driven_radius"]
    high = _FARTHEST * low
    if low < distance <= high:
        return
    hint = meant_millimetres(distance, low, high)
    farther = "; where it is so far, correct span_length in the YAML" if distance > high else ""
    raise SettingsError(
        f"--centre-distance is {distance:g} m; it must lie between {low:g} and {high:g} m, once "
        f"and {_FARTHEST:g} times the sum of the radii{hint}{farther}"
    )


def _belt(said: _Said) -> None:
    groove = belt_material(said["belt"]).groove
    if groove is None or not {"driver_radius", "driven_radius"} <= said.keys():
        return
    try:
        groove.groove_angle(2.0 * min(said["driver_radius"], said["driven_radius"]))
    except DriveError as error:
        raise SettingsError(f"--belt: {error}") from error


def _size(said: _Said) -> None:
    if "belt" not in said:
        return
    try:
        belt_material(said["belt"]).size.check(said["size"])
    except DriveError as error:
        raise SettingsError(f"--{error}") from error


def _axial_stiffness(said: _Said) -> None:
    if not {"belt", "size"} <= said.keys():
        return
    typical = belt_material(said["belt"]).axial_stiffness(said["size"]).typical
    _refuse_far("axial_stiffness", "N", typical, said)


def _mass_per_length(said: _Said) -> None:
    if not {"belt", "size"} <= said.keys():
        return
    typical = belt_material(said["belt"]).mass_per_length(said["size"]).typical
    _refuse_far("mass_per_length", "kg/m", typical, said)


def _tension(said: _Said) -> None:
    if not {"belt", "size"} <= said.keys():
        return
    material = belt_material(said["belt"])
    stiffness = said.get("axial_stiffness") or material.axial_stiffness(said["size"]).typical
    _refuse_far("tension", "N", stiffness * material.installed_strain.typical, said)


def _refuse_far(name: str, unit: str, typical: float, said: _Said) -> None:
    value = said[name]
    if typical / _FAR <= value <= typical * _FAR:
        return
    size = f"{said['size']:g} {belt_material(said['belt']).size.value}"
    raise SettingsError(
        f"{_flag(name)} is {value:g} {unit}; {typical:.3g} {unit} is typical of "
        f"{size} of {said['belt']}, and it must be within {_FAR:g} times of that; give it in {unit}"
    )


def _tension_tolerance(said: _Said) -> None:
    tension, tolerance = said.get("tension"), said["tension_tolerance"]
    if tension is not None and tolerance > tension:
        raise SettingsError(
            f"--tension-tolerance is {tolerance:g} N; it must be no more than the tension of "
            f"{tension:g} N"
        )


def _surface(name: str) -> Callable[[_Said], None]:
    def check(said: _Said) -> None:
        if "belt" not in said or "friction_coefficient" in said:
            return
        known = dict.fromkeys(surface for surface, _ in belt_material(said["belt"]).friction)
        if said[name] not in known:
            raise SettingsError(
                f"{_flag(name)}: no friction coefficient is known of {said['belt']} on "
                f"{said[name]}; there are {', '.join(known)}; or give --friction-coefficient"
            )

    return check


def _surface_state(said: _Said) -> None:
    if "belt" not in said or "friction_coefficient" in said:
        return
    material, state = belt_material(said["belt"]), SurfaceState(said["surface_state"])
    try:
        for surface in (said.get("driven_surface", USUAL_SURFACE), said.get("driver_surface")):
            if surface is not None:
                material.friction_coefficient(surface, state)
    except DriveError as error:
        raise SettingsError(f"--surface-state: {error}") from error


def _driven_joint(said: _Said) -> None:
    joint = said["driven_joint"]
    if joint == said.get("driver_joint", PARAMETERS["driver.joint"].default):
        raise SettingsError(
            f"--driven-joint is {joint!r}, as that of the driver; a belt runs over two pulleys"
        )


def _flag(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _one_of(inertia: str, mass: str) -> Callable[[_Said], None]:
    def check(said: _Said) -> None:
        if {inertia, mass} <= said.keys():
            raise SettingsError(f"give {_flag(inertia)} or {_flag(mass)}, not both")

    return check


_CHECKS: dict[str, Callable[[_Said], None]] = {
    "centre_distance": _centre_distance,
    "belt": _belt,
    "size": _size,
    "axial_stiffness": _axial_stiffness,
    "mass_per_length": _mass_per_length,
    "driven_surface": _surface("driven_surface"),
    "driver_surface": _surface("driver_surface"),
    "surface_state": _surface_state,
    "tension": _tension,
    "tension_tolerance": _tension_tolerance,
    "driven_joint": _driven_joint,
    "driver_mass": _one_of("driver_inertia", "driver_mass"),
    "driven_mass": _one_of("driven_inertia", "driven_mass"),
}
