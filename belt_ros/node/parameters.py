"""The node's parameters: declared from one table, read and checked through `settings`."""

import difflib
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.exceptions import InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from belt_ros.settings import (
    PARAMETERS,
    DriveSettings,
    Parameter,
    SettingsError,
    settings_from_parameters,
)


class _Switch(Parameter):
    """A parameter that is either true or false."""

    def check(self, value: object) -> bool:
        """Return `value`; raise `SettingsError` if it is no truth value."""
        if not isinstance(value, bool):
            raise SettingsError(f"{self.name} is {value!r}; it must be true or false")
        return value


def _node_table() -> Iterator[Parameter]:
    yield _Switch("autostart", default=True, meaning="configure and activate without being asked")
    yield Parameter(
        "input_reliability",
        "best_effort",
        "how joint_states is subscribed to; reliable needs a reliable publisher",
        choices=("best_effort", "reliable"),
    )
    yield Parameter("input_depth", 200, "queue of joint_states", "messages", 1, 100_000)
    yield Parameter("diagnostics_period", 1.0, "between two /diagnostics", "s", 0.05, 60.0)
    yield Parameter(
        "memory_file",
        "",
        "file in which what was learned of the belt outlives the run, one for each drive; empty: "
        "none",
        fixed=False,
    )
    yield Parameter("memory_period", 10.0, "between two savings of memory_file", "s", 0.1, 86400.0)


NODE_PARAMETERS: dict[str, Parameter] = {parameter.name: parameter for parameter in _node_table()}
_ALL = NODE_PARAMETERS | PARAMETERS
_WHILE_UNCONFIGURED = ("memory_file",)
_OF_EVERY_NODE = ("use_sim_time", "qos_overrides.", "start_type_description_service")
_GROUPS = {name.partition(".")[0] for name in PARAMETERS if "." in name}


@dataclass(frozen=True)
class NodeSettings:
    """What concerns the node rather than the drive. `memory_file` is absolute; None: no memory."""

    autostart: bool
    input_reliability: str
    input_depth: int
    diagnostics_period: float
    memory_file: Path | None
    memory_period: float


def _descriptor(parameter: Parameter, *, with_range: bool = True) -> ParameterDescriptor:
    constraints = []
    if parameter.choices:
        constraints.append(f"one of {', '.join(parameter.choices)}")
    if parameter.fixed:
        constraints.append("fixed while the node lives")
    elif parameter.name in _WHILE_UNCONFIGURED:
        constraints.append("can be changed only while the node is unconfigured")
    elif parameter.name.startswith("prior."):
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


def declare_parameters(node: Node) -> None:
    """Declare all parameters on `node`, which has declared those it was given overrides for.

    An override outside its range is kept, without the range: it is refused, with the reason, when
    the node is configured. Refused here, it would end the process instead.
    """
    for parameter in _ALL.values():
        if not node.has_parameter(parameter.name):
            node.declare_parameter(parameter.name, parameter.default, _descriptor(parameter))
            continue
        try:
            node.set_descriptor(parameter.name, _descriptor(parameter))
        except InvalidParameterValueException:
            node.set_descriptor(parameter.name, _descriptor(parameter, with_range=False))


def foreign_parameters(node: Node) -> list[str]:
    """Return the names that `node` was given and that are not its own, nor every node's.

    Raises
    ------
    SettingsError
        If one of them looks like a misspelt name of its own.
    """
    foreign = []
    for name in node.get_parameters_by_prefix(""):
        if name in _ALL or name.startswith(_OF_EVERY_NODE):
            continue
        near = difflib.get_close_matches(name, _ALL, n=1, cutoff=0.8)
        if near or name.partition(".")[0] in _GROUPS:
            hint = f"; did you mean {near[0]}?" if near else ""
            raise SettingsError(f"unknown parameter {name}{hint}")
        foreign.append(name)
    return foreign


def _values(node: Node) -> dict[str, Any]:
    """Return the drive's parameters that have a value."""
    values = {name: node.get_parameter(name).value for name in PARAMETERS}
    return {name: value for name, value in values.items() if value is not None}


def read_drive_settings(node: Node) -> DriveSettings:
    """Read and check the drive's description.

    Raises
    ------
    SettingsError
        If it cannot be used; the message names the parameter.
    """
    return settings_from_parameters(_values(node))


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
    }
    values["input_depth"] = int(values["input_depth"])
    values["memory_file"] = _absolute_path("memory_file", values["memory_file"])
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

    Once `configured`, also whether the description stays usable as a whole.
    """
    try:
        values = {change.name: change.value for change in changes}
        for name, value in values.items():
            if name in _ALL:
                _ALL[name].check(value)
            if configured and name in _WHILE_UNCONFIGURED:
                _check_unchanged(node, name, value)
        ours = {name: value for name, value in values.items() if name in PARAMETERS}
        if configured and ours:
            settings_from_parameters(_values(node) | ours)
    except SettingsError as error:
        return SetParametersResult(successful=False, reason=str(error))
    return SetParametersResult(successful=True)
