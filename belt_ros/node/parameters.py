"""The node's parameters: declared from one table, read and checked through `settings`.

A node of one drive has that drive's parameters under their own names. A node of several, which
`drives` lists, has them once for each, as ``<drive>.<parameter>``; what is given without a drive's
name is the default of all.
"""

import difflib
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.exceptions import InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from belt_ros.drive_inputs import refuse_confused
from belt_ros.node.descriptions import DriveDescription, NodeSettings, UnitSettings
from belt_ros.node_tables import (
    DRIVE_PARAMETERS,
    NODE_PARAMETERS,
    OF_EVERY_NODE,
    UNIT_PARAMETERS,
    WHILE_UNCONFIGURED,
    InputKind,
)
from belt_ros.parameter_table import PARAMETERS, Parameter, SettingsError
from belt_ros.settings import names_of_drives, settings_from_parameters

_PRIOR = "prior."
_GROUPS = {name.partition(".")[0] for name in PARAMETERS if "." in name}


def _descriptor(parameter: Parameter, *, with_range: bool = True) -> ParameterDescriptor:
    constraints = []
    if parameter.choices:
        constraints.append(f"one of {', '.join(parameter.choices)}")
    if parameter.fixed:
        constraints.append("fixed while the node lives")
    elif parameter.name in WHILE_UNCONFIGURED:
        constraints.append("can be changed only while the node is unconfigured")
    elif parameter.name.startswith(_PRIOR):
        constraints.append("a change takes effect when the node is configured anew")
    descriptor = ParameterDescriptor(
        name=parameter.name,
        description=parameter.meaning + (f" [{parameter.unit}]" if parameter.unit else ""),
        additional_constraints="; ".join(constraints),
        read_only=parameter.fixed,
        dynamic_typing=True,  # so that 1 is taken for 1.0
    )
    if with_range and math.isfinite(parameter.low) and math.isfinite(parameter.high):
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(parameter.low), to_value=float(parameter.high))
        ]
    return descriptor


def given_names(node: Node) -> tuple[str, ...]:
    """Return the drives' names, none in a node of one drive.

    Raises
    ------
    SettingsError
        If `drives` cannot be used.
    """
    return names_of_drives({"drives": node.get_parameter_or("drives").value})


def _prefixes(node: Node) -> tuple[str, ...]:
    """Return what the names of the drives' parameters begin with."""
    try:
        names = given_names(node)
    except SettingsError:
        names = ()  # which fails, with the reason, when the node is configured
    return tuple(f"{name}." for name in names) or ("",)


def declare_parameters(node: Node) -> None:
    """Declare all parameters on `node`, which has declared those it was given overrides for.

    An override outside its range is kept, without the range: it is refused, with the reason, when
    the node is configured. Refused here, it would end the process instead.
    """
    for parameter in NODE_PARAMETERS.values():
        _declare(node, parameter.name, parameter, parameter.default)
    for prefix in _prefixes(node):
        for parameter in DRIVE_PARAMETERS.values():
            default = parameter.default
            if prefix and node.has_parameter(parameter.name):
                default = node.get_parameter(parameter.name).value
            if prefix and parameter.name == "name":
                default = prefix.rstrip(".")
            _declare(node, prefix + parameter.name, parameter, default)


def _declare(node: Node, name: str, parameter: Parameter, default: object) -> None:
    if not node.has_parameter(name):
        try:
            node.declare_parameter(name, default, _descriptor(parameter))
        except InvalidParameterValueException:
            node.declare_parameter(name, default, _descriptor(parameter, with_range=False))
        return
    try:
        node.set_descriptor(name, _descriptor(parameter))
    except InvalidParameterValueException:
        node.set_descriptor(name, _descriptor(parameter, with_range=False))


def foreign_parameters(node: Node) -> list[str]:
    """Return the names that `node` was given and that are not its own, nor every node's.

    Raises
    ------
    SettingsError
        If one of them looks like a misspelt name of its own.
    """
    prefixes = _prefixes(node)
    foreign = []
    for name in node.get_parameters_by_prefix(""):
        prefix = next((p for p in prefixes if p and name.startswith(p)), "")
        local = name.removeprefix(prefix)
        if local in DRIVE_PARAMETERS or name in NODE_PARAMETERS or name.startswith(OF_EVERY_NODE):
            continue
        near = difflib.get_close_matches(local, NODE_PARAMETERS | DRIVE_PARAMETERS, n=1, cutoff=0.8)
        if near or prefix or local.partition(".")[0] in _GROUPS:
            hint = f"; did you mean {prefix}{near[0]}?" if near else ""
            raise SettingsError(f"unknown parameter {name}{hint}")
        foreign.append(name)
    return foreign


def _values(node: Node, prefix: str, table: Iterable[str]) -> dict[str, Any]:
    """Return one drive's parameters that have a value, by their names in `table`."""
    values = {name: node.get_parameter(prefix + name).value for name in table}
    return {name: value for name, value in values.items() if value is not None}


def read_descriptions(node: Node) -> tuple[DriveDescription, ...]:
    """Read and check the description of every drive.

    Raises
    ------
    SettingsError
        If one cannot be used; the message names the drive, if there are several, and parameter.
    """
    names = given_names(node)
    described = tuple(_described(node, name) for name in names or ("",))
    refuse_confused((each.drive, each.unit.input) for each in described)
    files = [each.unit.memory_file for each in described if each.unit.memory_file is not None]
    for file in files:
        if files.count(file) > 1:
            raise SettingsError(
                f"memory_file is {str(file)!r} for several drives; put {{drive}} into its name"
            )
    return described


def _described(node: Node, name: str) -> DriveDescription:
    prefix = f"{name}." if name else ""
    try:
        drive = settings_from_parameters(_values(node, prefix, PARAMETERS))
        return DriveDescription(drive, _unit_settings(node, prefix, drive.name))
    except SettingsError as error:
        raise SettingsError(prefix + str(error)) from error


def _unit_settings(node: Node, prefix: str, drive_name: str) -> UnitSettings:
    values: dict[str, Any] = {
        name: parameter.check(node.get_parameter(prefix + name).value)
        for name, parameter in UNIT_PARAMETERS.items()
    }
    values["input"] = InputKind(values["input"])
    path = values["memory_file"].replace("{drive}", drive_name)
    values["memory_file"] = _absolute_path("memory_file", path)
    return UnitSettings(**values)


def read_node_settings(node: Node) -> NodeSettings:
    """Read and check what concerns the node itself.

    Raises
    ------
    SettingsError
        If a value cannot be used; the message names the parameter.
    """
    values: dict[str, Any] = {
        name: parameter.check(node.get_parameter(name).value)
        for name, parameter in NODE_PARAMETERS.items()
        if name != "drives"
    }
    values["input_depth"] = int(values["input_depth"])
    return NodeSettings(**values)


def _absolute_path(name: str, text: str) -> Path | None:
    """Return the path that `text` means, with `~` expanded; None where it is empty."""
    if not text:
        return None
    try:
        return Path(text).expanduser().absolute()
    except (OSError, RuntimeError) as error:
        raise SettingsError(f"{name} is {text!r}, which is no usable path: {error}") from error


def _check_unchanged(node: Node, name: str, value: object) -> None:
    if value != node.get_parameter(name).value:
        raise SettingsError(f"{name} can be changed only while the node is unconfigured")


def check_changes(
    node: Node, changes: Iterable[RosParameter[Any]], *, configured: bool
) -> SetParametersResult:
    """Judge a change of parameters.

    Once `configured`, also whether every description stays usable as a whole.
    """
    try:
        values = {change.name: change.value for change in changes}
        for prefix in _prefixes(node):
            _check_drive(node, prefix, values, configured=configured)
        for name, value in values.items():
            _check_common(node, name, value)
    except SettingsError as error:
        return SetParametersResult(successful=False, reason=str(error))
    return SetParametersResult(successful=True)


def changed_priors(node: Node, changes: Iterable[RosParameter[Any]]) -> list[str]:
    """Return which of the `changes` are of priors, which count once the node is configured anew."""
    starts = tuple(prefix + _PRIOR for prefix in _prefixes(node))
    return [change.name for change in changes if change.name.startswith(starts)]


def _check_common(node: Node, name: str, value: object) -> None:
    """Judge the change of a parameter that is no single drive's."""
    if name in NODE_PARAMETERS:
        NODE_PARAMETERS[name].check(value)
    elif name in DRIVE_PARAMETERS and "" not in _prefixes(node):
        raise SettingsError(f"{name} is the default of several drives; set a drive's own")


def _check_drive(node: Node, prefix: str, values: dict[str, Any], *, configured: bool) -> None:
    """Judge the changes of one drive's parameters."""
    ours = {
        name.removeprefix(prefix): value
        for name, value in values.items()
        if name.startswith(prefix) and name.removeprefix(prefix) in DRIVE_PARAMETERS
    }
    for name, value in ours.items():
        DRIVE_PARAMETERS[name].check(value)
        if configured and name in WHILE_UNCONFIGURED:
            _check_unchanged(node, prefix + name, value)
    physical = {name: value for name, value in ours.items() if name in PARAMETERS}
    if configured and physical:
        settings_from_parameters(_values(node, prefix, PARAMETERS) | physical)
