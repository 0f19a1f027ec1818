"""One YAML describes a drive: read once, checked, used by node, replay and rig alike.

The file is a ROS 2 parameter file, so the node takes it with ``--params-file`` and replay reads the
same one; a plain mapping without the ``ros__parameters`` wrapping is taken too.
"""

import dataclasses
import difflib
import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

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
from belt_ros.node_tables import ALL_PARAMETERS, NODE_PARAMETERS, OF_EVERY_NODE
from belt_ros.parameter_table import GROUPS, PARAMETERS, SettingsError
from belt_ros.several_drives import DriveNamesError, drive_names, values_of_drive
from belt_ros.yaml_text import YAMLError, yaml_content

_LARGEST_FILE = 1_000_000

# Thresholds that a worse condition passes one after the other.
_RISING = (
    ("alarm.margin_alarm", "alarm.margin_warning"),
    ("alarm.excess_slip_warning", "alarm.excess_slip_alarm", "alarm.excess_slip_trip"),
)


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


_RESERVED = frozenset(name.partition(".")[0] for name in (*ALL_PARAMETERS, *OF_EVERY_NODE))


def _flatten(mapping: Mapping[Any, Any], prefix: str = "") -> Iterator[tuple[str, object]]:
    for key, value in mapping.items():
        if isinstance(value, Mapping):
            yield from _flatten(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _flat(mapping: Mapping[Any, Any]) -> dict[str, object]:
    """Return values by flat names, of which none stands for two."""
    flat: dict[str, object] = {}
    for name, value in _flatten(mapping):
        if name in flat:
            raise SettingsError(f"{name} is given twice, in one word and in parts; leave one")
        flat[name] = value
    return flat


def _sections(document: Mapping[Any, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Names of nodes in a ROS parameter file, and the parameters of each."""
    for name, content in document.items():
        if isinstance(content, Mapping):
            if isinstance(content.get("ros__parameters"), Mapping):
                yield f"{prefix}{name}", content["ros__parameters"]
            else:
                yield from _sections(content, f"{prefix}{name}/")


def names_belt_node(section: str) -> bool:
    """Whether a section of a ROS parameter file is for this package's node, or for every node."""
    return section.rpartition("/")[2] in ("**", "*", "belt_node")


def _parameters(document: object) -> dict[str, object]:
    """Flat parameters of a drive description: of a plain mapping, or as a node would take them."""
    if not isinstance(document, Mapping):
        raise SettingsError("a drive description is a YAML mapping; see config/ for examples")
    sections = list(_sections(document))
    if not sections:
        return _flat(document)
    own = [section for section in sections if names_belt_node(section[0])]
    if not own and len(sections) > 1:
        names = ", ".join(name for name, _ in sections)
        raise SettingsError(f"it has parameters for {names}, but none for belt_node or /**")
    spaces = {name.strip("/").rpartition("/")[0] for name, _ in own} - {"", "*", "**"}
    if len(spaces) > 1:
        raise SettingsError(
            f"it has parameters for belt_node in {', '.join(sorted(spaces))}; give each of these "
            "nodes a file of its own"
        )
    return {name: value for _, content in own or sections for name, value in _flat(content).items()}


def settings_from_parameters(values: Mapping[str, object]) -> DriveSettings:
    """Build settings from flat parameter names.

    Raises
    ------
    SettingsError
        For an unknown name, a missing value, a wrong type, a value out of range or thresholds out
        of order.
    """
    for name in values:
        if name not in PARAMETERS:
            near = difflib.get_close_matches(name, ALL_PARAMETERS, n=1)
            hint = f"; did you mean {near[0]}?" if near else ""
            raise SettingsError(f"unknown parameter {name}{hint}")
    checked: dict[str, Any] = {}
    for name, parameter in PARAMETERS.items():
        value = values.get(name, parameter.default)
        if value is None:
            raise SettingsError(f"{name} is missing: {parameter.meaning} [{parameter.unit}]")
        checked[name] = parameter.check(value)
    _check_order(checked)
    if checked["driver.joint"] == checked["driven.joint"]:
        raise SettingsError(
            f"driver.joint and driven.joint are both {checked['driver.joint']!r}; "
            "a belt runs over two pulleys"
        )
    groups = {name: _group(name, kind, checked) for name, kind in GROUPS.items()}
    try:
        drive = _drive(checked)
    except DriveError as error:
        raise SettingsError(str(error)) from error
    return DriveSettings(name=checked["name"], drive=drive, **groups)


def _check_order(values: Mapping[str, Any]) -> None:
    """Refuse thresholds of which the worse is met before the better."""
    for names in _RISING:
        for below, above in itertools.pairwise(names):
            if values[below] > values[above]:
                raise SettingsError(
                    f"{below} is {values[below]:g} and {above} is {values[above]:g}; "
                    f"{below} must not be above {above}"
                )


def _group(name: str, kind: type, values: Mapping[str, Any]) -> Any:
    arguments: dict[str, Any] = {
        field.name: values.get(f"{name}.{field.name}") for field in dataclasses.fields(kind)
    }
    if kind is Joint:
        arguments["name"] = values[f"{name}.joint"]
        if arguments["torque_scale"] == 0.0:
            raise SettingsError(
                f"{name}.torque_scale is 0, by which no effort is a torque; where torque is not "
                "measured, leave it at 1 and send NaN, or no effort"
            )
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
        If the file cannot be read, is no YAML, gives anything twice, or is larger than a drive
        description can be.
    """
    path = Path(path)
    try:
        large = path.stat().st_size > _LARGEST_FILE
        document = None if large else yaml_content(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise SettingsError(f"cannot read {path}: {error.strerror or error}") from error
    except (YAMLError, ValueError, OverflowError, RecursionError) as error:  # odd dates, too
        raise SettingsError(f"{path} is no valid YAML: {error}") from error
    if large:
        raise SettingsError(f"{path} is larger than {_LARGEST_FILE} bytes")
    try:
        return _parameters(document)
    except (SettingsError, OverflowError) as error:
        raise SettingsError(f"{path}: {error}") from error


def names_of_drives(values: Mapping[str, object]) -> tuple[str, ...]:
    """Return the names of the drives that flat `values` describe; none if there is but one.

    Raises
    ------
    SettingsError
        If they cannot be used.
    """
    try:
        return drive_names(values.get("drives"), _RESERVED)
    except DriveNamesError as error:
        raise SettingsError(str(error)) from error


def without_nodes_own(values: Mapping[str, object]) -> dict[str, object]:
    """Return flat `values` without those of the node, which the same file may hold; check these.

    Raises
    ------
    SettingsError
        If one that is the node's cannot be used.
    """
    rest = {}
    for name, value in values.items():
        own = ALL_PARAMETERS.get(name)
        if own is not None and name not in PARAMETERS:
            own.check(value)
        elif not name.startswith(OF_EVERY_NODE):
            rest[name] = value
    return rest


def load_settings(
    path: str | Path, overrides: Mapping[str, object] | None = None, drive: str = ""
) -> DriveSettings:
    """Read and check a drive's YAML; `overrides` are flat names that take precedence.

    Parameters
    ----------
    path : str or Path
    overrides : mapping, optional
    drive : str
        Which drive, where the file describes several.

    Raises
    ------
    SettingsError
        As `read_parameters` and `settings_from_parameters`; the message begins with the path.
    """
    values = {**read_parameters(path), **(overrides or {})}
    try:
        return settings_from_parameters(without_nodes_own(_chosen(values, drive)))
    except SettingsError as error:
        raise SettingsError(f"{path}: {error}") from error


def _chosen(values: dict[str, object], drive: str) -> dict[str, object]:
    names = names_of_drives(values)
    if not names:
        values.pop("drives", None)
        only = values.get("name", PARAMETERS["name"].default)
        if drive not in ("", only):
            raise SettingsError(f"it describes no drive {drive!r}, but one called {only!r}")
        return values
    if not drive and len(names) == 1:
        drive = names[0]
    if drive not in names:
        asked = f"no drive {drive!r}" if drive else "several drives"
        raise SettingsError(f"it describes {asked}; name one of {', '.join(names)}")
    for own in NODE_PARAMETERS:
        if f"{drive}.{own}" in values:
            raise SettingsError(f"{drive}.{own} is of one drive; {own} is of the whole node")
    return values_of_drive(values, drive, names)
