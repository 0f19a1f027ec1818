"""What is asked of a drive, and the answers, checked one by one."""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from belt_ros.mechanics import DriveError, Tensioning
from belt_ros.mechanics.materials import BELTS, LAGGINGS, SurfaceState, belt_material
from belt_ros.node_tables import InputKind
from belt_ros.parameter_table import SettingsError

Answer = float | str | bool | None
TORQUE_SENSOR, MOTOR_CURRENT = "sensor", "current"
_GREATEST = 1e12


def _question(
    text: str, unit: str = "", default: Any = None, choices: tuple[str, ...] = (), **kind: bool
) -> Any:
    """Return a field with its question. `needed`, `detail`, `signed`, `zero`: see `Question`."""
    about = {"text": text, "unit": unit, "choices": choices, **kind}
    return field(default=default, metadata=about)


@dataclass(frozen=True)
class Answers:
    """What a user says of a drive; None: not known. SI units.

    Each field is a flag of `belt init`, with dashes for underscores.
    """

    name: str = _question("name of the drive in messages", default="belt_drive")
    driver_radius: float | None = _question(
        "radius of the driver, to the belt's neutral line", "m", needed=True
    )
    driven_radius: float | None = _question(
        "radius of the driven pulley, to the belt's neutral line", "m", needed=True
    )
    centre_distance: float | None = _question("distance of the shafts", "m", needed=True)
    crossed: bool = _question(
        "whether the belt crosses itself, and turns the pulleys opposite ways",
        default=False,
        detail=True,
    )
    belt: str = _question("belt, as `belt materials` names it", choices=tuple(BELTS), needed=True)
    size: float | None = _question(
        "size of the belt: width or diameter [m], or number of ribs or belts", needed=True
    )
    axial_stiffness: float | None = _question(
        "EA of the belt, force per unit strain, if known", "N", detail=True
    )
    mass_per_length: float | None = _question(
        "mass of the belt per length, if known", "kg/m", detail=True
    )
    driven_surface: str = _question(
        "what the belt runs on at the driven pulley", default="steel", choices=tuple(LAGGINGS)
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
        "mu of the belt on both pulleys, if known; of the equivalent flat belt", "-", detail=True
    )
    tensioning: str = _question(
        "what stays constant as torque changes",
        default=Tensioning.FIXED_CENTRES.value,
        choices=tuple(kind.value for kind in Tensioning),
    )
    tension: float | None = _question(
        "tension of one strand as installed; guessed from the belt if not known", "N"
    )
    tension_tolerance: float | None = _question(
        "how far that may be off, +/-; in 19 cases of 20", "N"
    )
    driver_inertia: float | None = _question(
        "inertia of all that turns with the driver, as seen there (or give --driver-mass)",
        "kg m2",
        needed=True,
    )
    driver_mass: float | None = _question(
        "or mass of the driver, taken as a disc", "kg", detail=True
    )
    driven_inertia: float | None = _question(
        "inertia of all that turns with the driven pulley (or give --driven-mass)",
        "kg m2",
        needed=True,
    )
    driven_mass: float | None = _question(
        "or mass of the driven pulley, taken as a disc", "kg", detail=True
    )
    input: str = _question(
        "what speeds and torques come as",
        default=InputKind.JOINT_STATE.value,
        choices=tuple(kind.value for kind in InputKind),
    )
    driver_joint: str = _question("joint of the driver", default="driver_pulley_joint")
    driven_joint: str = _question("joint of the driven pulley", default="driven_pulley_joint")
    driver_gear_ratio: float = _question(
        "turns of the driver's joint per turn of its pulley", "-", 1.0
    )
    driven_gear_ratio: float = _question(
        "turns of the driven joint per turn of its pulley", "-", 1.0, detail=True
    )
    driver_sign: float = _question(
        "-1 if the driver's joint counts against the belt, else 1", "-", 1.0, signed=True
    )
    driven_sign: float = _question(
        "-1 if the driven joint counts against the belt, else 1", "-", 1.0, signed=True
    )
    driver_counts: float | None = _question("counts of the driver's encoder per turn of its joint")
    driven_counts: float | None = _question("counts of the driven encoder per turn of its joint")
    sample_rate: float = _question("readings per second", "Hz", 100.0, detail=True)
    torque: str = _question(
        "how the driver's torque is known",
        default=TORQUE_SENSOR,
        choices=(TORQUE_SENSOR, MOTOR_CURRENT),
    )
    torque_constant: float | None = _question(
        "N m of the driver's joint per unit of effort, e.g. per A; needed of a motor current",
        "N m",
    )
    driven_torque: bool = _question(
        "whether the driven pulley's torque is measured too", default=False
    )


class Question(NamedTuple):
    """One question, and what an answer must be."""

    name: str
    text: str
    unit: str
    default: Answer
    choices: tuple[str, ...]
    needed: bool  # there is no default to go by
    detail: bool  # not asked on a terminal, a flag only
    number: bool
    signed: bool  # 1 or -1

    @property
    def flag(self) -> str:
        """The flag of `belt init`."""
        return f"--{self.name.replace('_', '-')}"

    def check(self, value: object) -> Answer:
        """Return an answer in its type.

        Raises
        ------
        SettingsError
            If it is none.
        """
        if isinstance(self.default, bool):
            if not isinstance(value, bool):
                raise SettingsError(f"{self.flag} is {value!r}; it must be yes or no")
            return value
        if self.number:
            return self._number(value)
        return self._text(value)

    def _number(self, value: object) -> float:
        try:
            number = float(str(value))
        except ValueError:
            raise SettingsError(f"{self.flag} is {value!r}; it must be a number") from None
        if self.signed:
            if abs(number) != 1.0:
                raise SettingsError(f"{self.flag} is {number:g}; it must be 1 or -1")
        elif not 0.0 < number <= _GREATEST:
            raise SettingsError(
                f"{self.flag} is {number:g} {self.unit}".rstrip()
                + f"; it must be > 0 and no more than {_GREATEST:g}"
            )
        return number

    def _text(self, value: object) -> str:
        text = str(value).strip()
        if self.name == "belt":
            try:
                return belt_material(text).name
            except DriveError as error:
                raise SettingsError(f"{self.flag}: {error}") from error
        if not text or not text.isprintable():
            raise SettingsError(f"{self.flag} is {value!r}; it must be a name")
        if self.choices and text not in self.choices:
            raise SettingsError(
                f"{self.flag} is {text!r}; it must be one of {', '.join(self.choices)}"
            )
        return text


def _questions() -> dict[str, Question]:
    found = {}
    for one in dataclasses.fields(Answers):
        about = one.metadata
        default: Any = one.default
        found[one.name] = Question(
            one.name,
            about["text"],
            about["unit"],
            default,
            about["choices"],
            about.get("needed", False),
            about.get("detail", False),
            "float" in str(one.type),
            about.get("signed", False),
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
        For an answer that cannot be; for those that are needed and missing, naming all.
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
    answers = Answers(**checked)
    for name in ("driver", "driven"):
        if None not in (getattr(answers, f"{name}_inertia"), getattr(answers, f"{name}_mass")):
            raise SettingsError(f"give --{name}-inertia or --{name}-mass, not both")
    return answers


def _flags(question: Question) -> str:
    other = _INSTEAD.get(question.name)
    return f"{question.flag} or {QUESTIONS[other].flag}" if other else question.flag


def needs(value: float | None) -> float:
    """Return an answer that `answers_from` has made sure of."""
    if value is None or not math.isfinite(value):
        raise SettingsError("an answer that is needed is missing")
    return value
