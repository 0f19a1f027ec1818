"""The parameters of a drive that follow from the answers, each with a word on where it is from."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from belt_ros.mechanics import Belt, BeltDrive, crossed_drive, open_drive, torque_capacity
from belt_ros.mechanics.drive import Tensioning
from belt_ros.mechanics.materials import BeltMaterial, SurfaceState, belt_material
from belt_ros.node_tables import InputKind
from belt_ros.starter.answers import MOTOR_CURRENT, Answers, needs

_SIGMAS = 2.0  # of a tolerance
_UNCERTAIN_FRICTION = 0.1  # of a friction coefficient that is told
_UNCERTAIN = 0.2  # of a tension of which no tolerance is told
_CURRENT_NOISE = (0.02, 0.01)  # of the torque, of the capacity
_SENSOR_NOISE = (0.005, 0.002)
_SPEED_NOISE = 1e-4  # of the speed
_NO_ENCODER = 0.005  # [rad/s]


class Entry(NamedTuple):
    """One line: dotted name, value, comment; `guessed` where nobody has said it."""

    name: str
    value: float | str
    comment: str = ""
    guessed: bool = False


class _Contact(NamedTuple):
    """Friction of the belt on one pulley."""

    friction_coefficient: float  # [-]
    friction_coefficient_stddev: float
    friction_stiffness: float  # median [N/m2]
    friction_stiffness_decades: float


def _guess(name: str, value: float | str, comment: str = "") -> Entry:
    return Entry(name, value, comment, guessed=True)


def entries(answers: Answers) -> list[Entry]:
    """Return all entries, in the order in which they are written.

    Raises
    ------
    DriveError
        If the answers describe no drive that can be.
    """
    material = belt_material(answers.belt)
    prior = _contact(answers, material, answers.driven_surface)
    belt = _belt(answers, material)
    drive = _drive(answers, belt, prior)
    tension = answers.tension or _guessed_tension(belt, material)
    capacity = float(torque_capacity(drive, tension))
    return [
        Entry("name", answers.name),
        *_input(answers),
        *_belt_entries(answers, material, belt),
        *_pulley(answers, "driver", drive),
        *_ratios(answers, material, prior),
        *_pulley(answers, "driven", drive),
        Entry("span_length", drive.span_length, "m, between the pulleys, by their distance"),
        Entry("tensioning", answers.tensioning, "what stays constant as torque changes"),
        *_tension(answers, tension),
        *_friction(answers, prior),
        *_noise(answers, capacity),
    ]


def _input(answers: Answers) -> Iterator[Entry]:
    if answers.input != InputKind.JOINT_STATE.value:
        yield Entry("input", answers.input, "what speeds and torques come as")


def _contact(answers: Answers, material: BeltMaterial, surface: str) -> _Contact:
    """Return what is typical on a surface, or what is told."""
    stiffness = material.friction_stiffness(needs(answers.size), surface)
    if answers.friction_coefficient is not None:
        mu = answers.friction_coefficient
        return _Contact(mu, _UNCERTAIN_FRICTION * mu, stiffness.typical, stiffness.decades)
    smallest = 2.0 * min(needs(answers.driver_radius), needs(answers.driven_radius))
    friction = material.equivalent_friction(surface, SurfaceState(answers.surface_state), smallest)
    return _Contact(friction.typical, friction.stddev, stiffness.typical, stiffness.decades)


def _belt(answers: Answers, material: BeltMaterial) -> Belt:
    typical = material.belt(needs(answers.size))
    return Belt(
        answers.axial_stiffness or typical.axial_stiffness,
        answers.mass_per_length or typical.mass_per_length,
    )


def _guessed_tension(belt: Belt, material: BeltMaterial) -> float:
    return belt.axial_stiffness * material.installed_strain.typical


def _drive(answers: Answers, belt: Belt, prior: _Contact) -> BeltDrive:
    lay = crossed_drive if answers.crossed else open_drive
    return lay(
        belt,
        needs(answers.driven_radius),
        needs(answers.driver_radius),
        needs(answers.centre_distance),
        prior.friction_coefficient,
        prior.friction_stiffness,
        tensioning=Tensioning(answers.tensioning),
    )


def _belt_entries(answers: Answers, material: BeltMaterial, belt: Belt) -> Iterator[Entry]:
    what = f"typical of {material.name}, {needs(answers.size):g} {material.size.value}"
    told = answers.axial_stiffness is not None
    yield Entry(
        "belt.axial_stiffness",
        belt.axial_stiffness,
        "N, force per unit strain" + ("" if told else f"; {what}"),
        not told,
    )
    told = answers.mass_per_length is not None
    yield Entry(
        "belt.mass_per_length",
        belt.mass_per_length,
        "kg/m" + ("" if told else f"; {what}"),
        not told,
    )


def _pulley(answers: Answers, name: str, drive: BeltDrive) -> Iterator[Entry]:
    pulley = drive.driver if name == "driver" else drive.driven
    if answers.input == InputKind.JOINT_STATE.value:
        joint = getattr(answers, f"{name}_joint")
        yield Entry(f"{name}.joint", joint, "name in sensor_msgs/JointState")
    yield Entry(
        f"{name}.gear_ratio",
        getattr(answers, f"{name}_gear_ratio"),
        "turns of that joint per turn of the pulley",
    )
    yield Entry(
        f"{name}.sign", getattr(answers, f"{name}_sign"), "-1 if it counts against the belt"
    )
    if name == "driver":
        constant = answers.torque_constant or 1.0
        yield Entry(f"{name}.torque_scale", constant, "N m of that joint per unit of effort")
    yield Entry(f"{name}.radius", pulley.radius, "m, to the belt's neutral line")
    yield Entry(f"{name}.wrap_angle", pulley.wrap_angle, "rad, by radii and distance of centres")
    mass = getattr(answers, f"{name}_mass")
    if mass is None:
        inertia = getattr(answers, f"{name}_inertia")
        yield Entry(f"{name}.inertia", inertia, "kg m2, of all that turns with this pulley")
    else:
        inertia = 0.5 * mass * pulley.radius**2
        yield _guess(f"{name}.inertia", inertia, f"kg m2; a disc of {mass:g} kg and no more")


def _ratios(answers: Answers, material: BeltMaterial, driven: _Contact) -> Iterator[Entry]:
    """Compare the driver's surface with the driven pulley's, where it is another."""
    surface = answers.driver_surface or answers.driven_surface
    if surface == answers.driven_surface:
        return
    driver = _contact(answers, material, surface)
    where = f"{surface} against {answers.driven_surface}, typical"
    friction = driver.friction_coefficient / driven.friction_coefficient
    stiffness = driver.friction_stiffness / driven.friction_stiffness
    yield _guess("driver.friction_ratio", friction, where)
    yield _guess("driver.stiffness_ratio", stiffness, where)


def _tension(answers: Answers, tension: float) -> Iterator[Entry]:
    held = (
        "the slack span" if answers.tensioning == Tensioning.CONSTANT_SLACK.value else "one strand"
    )
    told = answers.tension is not None
    yield Entry(
        "prior.tension",
        tension,
        f"N, of {held} as installed" if told else "N, by the strain at which it is mostly fitted",
        not told,
    )
    if answers.tension_tolerance is not None:
        spread = answers.tension_tolerance / _SIGMAS
        text = f"N, half of the tolerance of +/- {answers.tension_tolerance:g} N"
        yield Entry("prior.tension_stddev", spread, text)
        return
    spread = _UNCERTAIN if told else _fitted_spread(answers)
    yield _guess("prior.tension_stddev", spread * tension, "N, how well that is known")


def _fitted_spread(answers: Answers) -> float:
    material = belt_material(answers.belt)
    spread = material.installed_strain.relative_stddev
    if answers.axial_stiffness is None:
        spread = math.hypot(spread, material.stiffness.relative_stddev)
    return spread


def _friction(answers: Answers, prior: _Contact) -> Iterator[Entry]:
    where = f"typical on {answers.driven_surface}, {answers.surface_state}"
    told = answers.friction_coefficient is not None
    yield Entry(
        "prior.friction_coefficient", prior.friction_coefficient, "" if told else where, not told
    )
    yield _guess(
        "prior.friction_coefficient_stddev", prior.friction_coefficient_stddev, "standard deviation"
    )
    yield _guess(
        "prior.friction_stiffness", prior.friction_stiffness, "N/m2; it is learned under load"
    )
    yield _guess(
        "prior.friction_stiffness_decades",
        prior.friction_stiffness_decades,
        "standard deviation of its log10",
    )
    yield _guess(
        "prior.ratio_bias_stddev", 1e-3, "of R1/R2; ~/calibrate and `belt identify` find it"
    )


def _noise(answers: Answers, capacity: float) -> Iterator[Entry]:
    yield _guess("noise.speed_relative", _SPEED_NOISE, "of the speed, one reading")
    steps = [
        2.0 * math.pi / (counts * gear)
        for counts, gear in (
            (answers.driver_counts, answers.driver_gear_ratio),
            (answers.driven_counts, answers.driven_gear_ratio),
        )
        if counts is not None
    ]
    if steps:
        speed = max(steps) * answers.sample_rate / math.sqrt(6.0)
        text = f"rad/s; counts at {answers.sample_rate:g} readings a second"
        yield _guess("noise.speed_absolute", speed, text)
        yield Entry("noise.position_quantum", max(steps), "rad, of the coarser encoder")
    else:
        yield _guess("noise.speed_absolute", _NO_ENCODER, "rad/s at the pulley")
    relative, of_capacity = _CURRENT_NOISE if answers.torque == MOTOR_CURRENT else _SENSOR_NOISE
    yield _guess("noise.torque_relative", relative, f"of a torque by {answers.torque}")
    absolute = of_capacity * capacity
    yield _guess("noise.torque_absolute", absolute, f"N m; {of_capacity:.1%} of the capacity")
