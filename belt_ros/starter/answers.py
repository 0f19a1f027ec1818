"""What is asked of a drive, and the answers, checked."""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from belt_ros.mechanics import Tensioning
from belt_ros.mechanics.materials import BELTS, LAGGINGS, SurfaceState
from belt_ros.node_tables import InputKind
from belt_ros.parameter_table import SettingsError
from belt_ros.starter.beside import USUAL_SURFACE, check_beside
from belt_ros.starter.question import Question, Range

TORQUE_SENSOR, MOTOR_CURRENT = "sensor", "current"

_RADIUS = Range("m", 1e-3, 5.0)
_INERTIA = Range("kg m2", 1e-9, 1e6)
_MASS = Range("kg", 1e-4, 1e5)
_GEAR_RATIO = Range("-", 1e-6, 1e6)
_COUNTS = Range("", 1.0, 1e10)


def _question(
    text: str,
    number: Range | None = None,
    default: Any = None,
    choices: tuple[str, ...] = (),
    **kind: bool,
) -> Any:
    """Return a field with its question. `needed`, `detail`, `signed`: see `Question`."""
    about = {"text": text, "number": number, "choices": choices, **kind}
    return field(default=default, metadata=about)


@dataclass(frozen=True)
class Answers:
    """What a user says of a drive; None: not known. SI units.

    Each field is a flag of `belt init`, with dashes for underscores.
    """

    name: str = _question("name of the drive in messages", default="belt_drive")
    driver_radius: float | None = _question(
        "radius of the driver, to the belt's neutral line", _RADIUS, needed=True
    )
    driven_radius: float | None = _question(
        "radius of the driven pulley, to the belt's neutral line", _RADIUS, needed=True
    )
    centre_distance: float | None = _question(
        "distance of the shafts", Range("m", 1e-3, 1e5), needed=True
    )
    crossed: bool = _question(
        "whether the belt crosses itself, and turns the pulleys opposite ways",
        default=False,
        detail=True,
    )
    belt: str = _question("belt, as `belt materials` names it", choices=tuple(BELTS), needed=True)
    size: float | None = _question(
        "size of the belt: width or diameter [m], or number of ribs or belts",
        Range("", 1e-9, 1e9),  # by the belt, see `beside`
        needed=True,
    )
    axial_stiffness: float | None = _question(
        "EA of the belt, force per unit strain, if known", Range("N", 1.0, 1e12), detail=True
    )
    mass_per_length: float | None = _question(
        "mass of the belt per length, if known", Range("kg/m", 1e-6, 1e4), detail=True
    )
    driven_surface: str = _question(
        "what the belt runs on at the driven pulley",
        default=USUAL_SURFACE,
        choices=tuple(LAGGINGS),
    )
    driver_surface: str = _question(
        "what it runs on at the driver; as the driven pulley if not given",
        default="",
        choices=tuple(LAGGINGS),
        detail=True,
    )
    surface_state: str = _question(
        "state of these surfaces",
        default=SurfaceState.DRY.value,
        choices=tuple(state.value for state in SurfaceState),
    )
    friction_coefficient: float | None = _question(
        "mu of the belt on both pulleys, if known; of the equivalent flat belt",
        Range("-", 0.01, 10.0),
        detail=True,
    )
    tensioning: str = _question(
        "what stays constant as torque changes",
        default=Tensioning.FIXED_CENTRES.value,
        choices=tuple(kind.value for kind in Tensioning),
    )
    tension: float | None = _question(
        "tension of one strand as installed; guessed from the belt if not known",
        Range("N", 1e-3, 1e9),
    )
    tension_tolerance: float | None = _question(
        "how far that may be off, +/-; in 19 cases of 20", Range("N", 1e-5, 1e9)
    )
    driver_inertia: float | None = _question(
        "inertia of all that turns with the driver, as seen there (or give --driver-mass)",
        _INERTIA,
        needed=True,
    )
    driver_mass: float | None = _question(
        "or mass of the driver, taken as a disc", _MASS, detail=True
    )
    driven_inertia: float | None = _question(
        "inertia of all that turns with the driven pulley (or give --driven-mass)",
        _INERTIA,
        needed=True,
    )
    driven_mass: float | None = _question(
        "or mass of the driven pulley, taken as a disc", _MASS, detail=True
    )
    input: str = _question(
        "what speeds and torques come as",
        default=InputKind.JOINT_STATE.value,
        choices=tuple(kind.value for kind in InputKind),
    )
    driver_joint: str = _question("joint of the driver", default="driver_pulley_joint")
    driven_joint: str = _question("joint of the driven pulley", default="driven_pulley_joint")
    driver_gear_ratio: float = _question(
        "turns of the driver's joint per turn of its pulley", _GEAR_RATIO, 1.0
    )
    driven_gear_ratio: float = _question(
        "turns of the driven joint per turn of its pulley", _GEAR_RATIO, 1.0, detail=True
    )
    driver_sign: float = _question(
        "-1 if the driver's joint counts against the belt, else 1", default=1.0, signed=True
    )
    driven_sign: float = _question(
        "-1 if the driven joint counts against the belt, else 1", default=1.0, signed=True
    )
    driver_counts: float | None = _question(
        "counts of the driver's encoder per turn of its joint", _COUNTS
    )
    driven_counts: float | None = _question(
        "counts of the driven encoder per turn of its joint", _COUNTS
    )
    sample_rate: float = _question("readings per second", Range("Hz", 0.1, 1e5), 100.0, detail=True)
    torque: str = _question(
        "how the driver's torque is known",
        default=TORQUE_SENSOR,
        choices=(TORQUE_SENSOR, MOTOR_CURRENT),
    )
    torque_constant: float | None = _question(
        "N m of the driver's joint per unit of effort, e.g. per A; needed of a motor current",
        Range("N m", 1e-9, 1e9),
    )
    driven_torque: bool = _question(
        "whether the driven pulley's torque is measured too", default=False
    )


def _questions() -> dict[str, Question]:
    found = {}
    for one in dataclasses.fields(Answers):
        about = one.metadata
        default: Any = one.default
        number = about["number"] or Range("", -math.inf, math.inf)
        found[one.name] = Question(
            one.name,
            about["text"],
            number.unit,
            default,
            about["choices"],
            about.get("needed", False),
            about.get("detail", False),
            "float" in str(one.type),
            about.get("signed", False),
            (number.low, number.high),
        )
    return found


QUESTIONS: dict[str, Question] = _questions()
_INSTEAD = {"driver_inertia": "driver_mass", "driven_inertia": "driven_mass"}


def missing(given: Mapping[str, object]) -> list[Question]:
    """Return the questions that need an answer and have none in `given`."""
    lacking = []
    for name, question in QUESTIONS.items():
        needed = question.needed
        needed |= name == "torque_constant" and given.get("torque") == MOTOR_CURRENT
        there = any(given.get(one) is not None for one in (name, _INSTEAD.get(name, name)))
        if needed and not there:
            lacking.append(question)
    return lacking


def answers_from(given: Mapping[str, object]) -> Answers:
    """Return checked answers from `given`; what is None there was not answered.

    Raises
    ------
    SettingsError
        For an answer that cannot be, by itself or beside the others; for those that are needed and
        missing, naming all.
    """
    unknown = sorted(set(given) - set(QUESTIONS))
    if unknown:
        raise SettingsError(f"{unknown[0]} is none of what is asked of a drive")
    lacking = missing(given)
    if lacking:
        needed = "; ".join(
            f"{_flags(one)} ({one.text}{f' [{one.unit}]' if one.unit else ''})" for one in lacking
        )
        raise SettingsError(f"missing: {needed}")
    checked: dict[str, Any] = {
        name: QUESTIONS[name].check(value) for name, value in given.items() if value is not None
    }
    for name in QUESTIONS:
        if name in checked:
            check_beside(name, checked)
    return Answers(**checked)


def _flags(question: Question) -> str:
    other = _INSTEAD.get(question.name)
    return f"{question.flag} or {QUESTIONS[other].flag}" if other else question.flag


def needs(value: float | None) -> float:
    """Return an answer that `answers_from` has made sure of."""
    if value is None or not math.isfinite(value):
        raise SettingsError("an answer that is needed is missing")
    return value
