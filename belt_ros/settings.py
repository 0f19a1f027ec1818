"""One YAML describes a drive: read once, checked, used by node, replay and rig alike.

The file is a ROS 2 parameter file, so the node takes it with ``--params-file`` and replay reads the
same one; a plain mapping without the ``ros__parameters`` wrapping is taken too. The table of
parameters below is the only place where names, units, ranges and defaults are listed.
"""

import dataclasses
import difflib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from belt_ros.estimation import (
    AlarmSettings,
    BeltMonitor,
    Drift,
    Joint,
    Prior,
    SensorLimits,
    SensorNoise,
)
from belt_ros.mechanics import Belt, BeltDrive, DriveError, Kinematics, Pulley, Tensioning

Value = float | str
_LARGEST_FILE = 1_000_000

# Parameters of the node itself, which the same file may hold.
NODE_ONLY = (
    "use_sim_time",
    "autostart",
    "input_",
    "diagnostics_period",
    "memory_",
    "qos_overrides",
)


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


@dataclass(frozen=True)
class DriveSettings:
    """All that is to be known before the first measurement of one drive."""

    name: str
    drive: BeltDrive
    driver: Joint
    driven: Joint
    prior: Prior
    noise: SensorNoise
    drift: Drift
    limits: SensorLimits
    alarm: AlarmSettings

    def monitor(self) -> BeltMonitor:
        """Return a fresh monitor of this drive."""
        return BeltMonitor(
            self.name,
            self.drive,
            self.prior,
            self.noise,
            self.drift,
            self.limits,
            self.alarm,
            (self.driver.turn, self.driven.turn),
        )


_GROUPS: dict[str, type] = {
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
    for group, kind in _GROUPS.items():
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


def _flatten(mapping: Mapping[Any, Any], prefix: str = "") -> Iterator[tuple[str, object]]:
    for key, value in mapping.items():
        if isinstance(value, Mapping):
            yield from _flatten(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _unwrap(document: object) -> Mapping[Any, Any]:
    """Strip a ROS parameter file's node name and `ros__parameters`, if they are there."""
    if not isinstance(document, Mapping):
        raise SettingsError("a drive description is a YAML mapping; see config/ for examples")
    for content in document.values():
        if isinstance(content, Mapping) and "ros__parameters" in content:
            inner = content["ros__parameters"]
            if isinstance(inner, Mapping):
                return inner
    return document


def settings_from_parameters(values: Mapping[str, object]) -> DriveSettings:
    """Build settings from flat parameter names.

    Raises
    ------
    SettingsError
        For an unknown name, a missing value, a wrong type or a value out of range.
    """
    for name in values:
        if name not in PARAMETERS:
            near = difflib.get_close_matches(name, PARAMETERS, n=1)
            hint = f"; did you mean {near[0]}?" if near else ""
            raise SettingsError(f"unknown parameter {name}{hint}")
    checked: dict[str, Any] = {}
    for name, parameter in PARAMETERS.items():
        value = values.get(name, parameter.default)
        if value is None:
            raise SettingsError(f"{name} is missing: {parameter.meaning} [{parameter.unit}]")
        checked[name] = parameter.check(value)
    groups = {name: _group(name, kind, checked) for name, kind in _GROUPS.items()}
    try:
        drive = _drive(checked)
    except DriveError as error:
        raise SettingsError(str(error)) from error
    return DriveSettings(name=checked["name"], drive=drive, **groups)


def _group(name: str, kind: type, values: Mapping[str, Any]) -> Any:
    arguments: dict[str, Any] = {
        field.name: values.get(f"{name}.{field.name}") for field in dataclasses.fields(kind)
    }
    if kind is Joint:
        arguments["name"] = values[f"{name}.joint"]
        if abs(arguments["sign"]) != 1.0:
            raise SettingsError(f"{name}.sign is {arguments['sign']:g}; it must be 1 or -1")
    return kind(**arguments)


def _drive(values: Mapping[str, Any]) -> BeltDrive:
    def pulley(name: str, friction: float, stiffness: float) -> Pulley:
        return Pulley(
            radius=values[f"{name}.radius"],
            wrap_angle=values[f"{name}.wrap_angle"],
            friction_coefficient=values["prior.friction_coefficient"] * friction,
            friction_stiffness=values["prior.friction_stiffness"] * stiffness,
            inertia=values[f"{name}.inertia"],
        )

    return BeltDrive(
        belt=Belt(values["belt.axial_stiffness"], values["belt.mass_per_length"]),
        driven=pulley("driven", 1.0, 1.0),
        driver=pulley("driver", values["driver.friction_ratio"], values["driver.stiffness_ratio"]),
        span_length=values["span_length"],
        kinematics=Kinematics(values["kinematics"]),
        tensioning=Tensioning(values["tensioning"]),
    )


def read_parameters(path: str | Path) -> dict[str, object]:
    """Read a parameter file to flat names.

    Raises
    ------
    SettingsError
        If the file cannot be read, is no YAML, or is larger than a drive description can be.
    """
    path = Path(path)
    try:
        if path.stat().st_size > _LARGEST_FILE:
            raise SettingsError(f"{path} is larger than {_LARGEST_FILE} bytes")
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise SettingsError(f"cannot read {path}: {error.strerror or error}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise SettingsError(f"{path} is no valid YAML: {error}") from error
    return dict(_flatten(_unwrap(document)))


def load_settings(path: str | Path, overrides: Mapping[str, object] | None = None) -> DriveSettings:
    """Read and check a drive's YAML; `overrides` are flat names that take precedence.

    Raises
    ------
    SettingsError
        As `read_parameters` and `settings_from_parameters`; the message begins with the path.
    """
    values = {**read_parameters(path), **(overrides or {})}
    try:
        return settings_from_parameters(
            {name: value for name, value in values.items() if not name.startswith(NODE_ONLY)}
        )
    except SettingsError as error:
        raise SettingsError(f"{path}: {error}") from error
