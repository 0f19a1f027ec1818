"""The table of a drive's parameters: the only place of their names, units, ranges and defaults."""

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from belt_ros.estimation import AlarmSettings, Drift, Joint, Prior, SensorLimits, SensorNoise
from belt_ros.mechanics import Kinematics, Tensioning

Value = float | str


class SettingsError(ValueError):
    """A drive description that cannot be used; the message names parameter, value and limit."""


@dataclass(frozen=True)
class Parameter:
    """One entry of the parameter table. `default` None: it must be given."""

    name: str
    default: Value | None
    meaning: str
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    fixed: bool = True
    choices: tuple[str, ...] = ()

    @property
    def is_text(self) -> bool:
        """Whether its value is text rather than a number."""
        return isinstance(self.default, str) or bool(self.choices)

    def check(self, value: object) -> Value:
        """Return `value` in the parameter's type; raise `SettingsError` if it is not admissible."""
        if self.is_text:
            if not isinstance(value, str):
                raise SettingsError(f"{self.name} is {value!r}; it must be text")
            if self.choices and value not in self.choices:
                raise SettingsError(
                    f"{self.name} is {value!r}; it must be one of {', '.join(self.choices)}"
                )
            return value
        # YAML 1.1 takes 8.1e7, without a sign in its exponent, for text.
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            raise SettingsError(f"{self.name} is {value!r}; it must be a number")
        try:
            number = float(value)
        except ValueError:
            raise SettingsError(f"{self.name} is {value!r}; it must be a number") from None
        if not self.low <= number <= self.high:
            raise SettingsError(
                f"{self.name} is {number:g} {self.unit}; it must lie between {self.low:g} "
                f"and {self.high:g}"
            )
        return number


GROUPS: dict[str, type] = {
    "driver": Joint,
    "driven": Joint,
    "prior": Prior,
    "noise": SensorNoise,
    "drift": Drift,
    "limits": SensorLimits,
    "alarm": AlarmSettings,
}
_PULLEY = (
    ("radius", "radius to the belt's neutral line", "m", 1e-4, 100.0),
    ("wrap_angle", "angle over which the belt touches the pulley", "rad", 1e-3, 2.0 * math.pi),
    (
        "inertia",
        "of all that turns with the pulley, between the torque's point of measurement and the belt",
        "kg m2",
        1e-9,
        1e9,
    ),
)


def _geometry() -> Iterator[Parameter]:
    yield Parameter("name", "belt_drive", "name of the drive in messages and diagnostics")
    yield Parameter(
        "belt.axial_stiffness", None, "EA, force per unit strain of the belt", "N", 1.0, 1e12
    )
    yield Parameter(
        "belt.mass_per_length", 0.0, "m, belt inertia; 0 leaves it out", "kg/m", 0.0, 1e4
    )
    for pulley in ("driver", "driven"):
        for name, meaning, unit, low, high in _PULLEY:
            yield Parameter(f"{pulley}.{name}", None, meaning, unit, low, high)
    yield Parameter(
        "driver.friction_ratio",
        1.0,
        "mu of the driver over mu of the driven pulley",
        "-",
        1e-3,
        1e3,
    )
    yield Parameter(
        "driver.stiffness_ratio",
        1.0,
        "kf of the driver over kf of the driven pulley",
        "-",
        1e-6,
        1e6,
    )
    yield Parameter("span_length", None, "free length of one belt span", "m", 1e-4, 1e5)
    yield Parameter(
        "tensioning",
        Tensioning.CONSTANT_MEAN.value,
        "what stays constant as torque changes",
        choices=tuple(kind.value for kind in Tensioning),
    )
    yield Parameter(
        "kinematics",
        Kinematics.EXACT.value,
        "how span strain enters slip; linear reproduces the paper",
        choices=tuple(kind.value for kind in Kinematics),
    )


def _table() -> Iterator[Parameter]:
    yield from _geometry()
    for group, kind in GROUPS.items():
        for field in dataclasses.fields(kind):
            named = kind is Joint and field.name == "name"
            default: Any = f"{group}_pulley_joint" if named else field.default
            yield Parameter(
                name=f"{group}.joint" if named else f"{group}.{field.name}",
                default=default,
                meaning=field.metadata["meaning"],
                unit=field.metadata["unit"],
                low=field.metadata["low"],
                high=field.metadata["high"],
                fixed=field.metadata["fixed"],
            )


PARAMETERS: dict[str, Parameter] = {parameter.name: parameter for parameter in _table()}
