"""What a node has of parameters beside those of a drive, and what is made of them. No ROS."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from belt_ros.drive_inputs import INPUT_PARAMETERS, InputKind
from belt_ros.parameter_table import PARAMETERS, Parameter, SettingsError
from belt_ros.settings import DriveSettings


class _Switch(Parameter):
    """A parameter that is either true or false."""

    def check(self, value: object) -> bool:
        """Return `value`; raise `SettingsError` if it is no truth value."""
        if not isinstance(value, bool):
            raise SettingsError(f"{self.name} is {value!r}; it must be true or false")
        return value


class _Names(Parameter):
    """A parameter that lists names; who reads it checks them together."""

    def check(self, value: object) -> Any:
        """Return `value`."""
        return value


def _node_table() -> Iterator[Parameter]:
    yield _Names(
        "drives",
        "",
        "names of several drives, whose parameters are then `<drive>.<parameter>` and whose "
        "topics and services have that name before theirs; none: one drive",
    )
    yield _Switch("autostart", default=True, meaning="configure and activate without being asked")
    yield Parameter(
        "input_reliability",
        "best_effort",
        "how inputs are subscribed to; reliable needs a reliable publisher",
        choices=("best_effort", "reliable"),
    )
    yield Parameter("input_depth", 200, "queue of each input", "messages", 1, 100_000)
    yield Parameter(
        "longest_pool",
        0.2,
        "over which measurements are averaged at most while the node cannot follow its input for "
        "want of processor; 0: never, then it falls behind",
        "s",
        0.0,
        1.0,
    )
    yield Parameter("diagnostics_period", 1.0, "between two /diagnostics", "s", 0.05, 60.0)
    yield _Switch(
        "use_memory",
        default=True,
        meaning="whether memory_file is read and written; false for old data and for tests",
    )
    yield Parameter("memory_period", 10.0, "between two savings of memory_file", "s", 0.1, 86400.0)


def _unit_table() -> Iterator[Parameter]:
    yield from INPUT_PARAMETERS.values()
    yield Parameter(
        "input_skew",
        0.02,
        "difference of two senders' clocks, or of one and ROS time, that diagnostics warn of",
        "s",
        0.001,
        1e6,
    )
    yield _Switch(
        "input_loads",
        default=False,
        meaning="whether hub loads and span tension come on driver/hub_load, driven/hub_load and "
        "driven/span_tension (std_msgs/Float64); a PulleyState carries them itself",
    )
    yield Parameter(
        "state_period",
        0.0,
        "shortest time between two ~/state; 0: every estimate",
        "s",
        0.0,
        60.0,
    )
    yield Parameter(
        "memory_file",
        "",
        "file in which what was learned of the belt outlives the run, one for each drive ({drive} "
        "in it stands for the drive's name); empty: none",
        fixed=False,
    )


NODE_PARAMETERS: dict[str, Parameter] = {parameter.name: parameter for parameter in _node_table()}
UNIT_PARAMETERS: dict[str, Parameter] = {parameter.name: parameter for parameter in _unit_table()}
DRIVE_PARAMETERS = PARAMETERS | UNIT_PARAMETERS
WHILE_UNCONFIGURED = ("memory_file",)
ALL_PARAMETERS = DRIVE_PARAMETERS | NODE_PARAMETERS


@dataclass(frozen=True)
class NodeSettings:
    """What concerns the node rather than its drives."""

    autostart: bool
    input_reliability: str
    input_depth: int
    longest_pool: float
    diagnostics_period: float
    use_memory: bool
    memory_period: float


@dataclass(frozen=True)
class UnitSettings:
    """How one drive is connected. `memory_file` is absolute; None: no memory."""

    input: InputKind
    input_reorder_window: float
    input_disorder: float
    input_slop: float
    input_skew: float
    input_loads: bool
    state_period: float
    memory_file: Path | None


@dataclass(frozen=True)
class DriveDescription:
    """One drive: its settings, and how it is connected."""

    drive: DriveSettings
    unit: UnitSettings
