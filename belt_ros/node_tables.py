"""The tables of what a node has of parameters beside those of its drives' mechanics and sensors.

The same file describes a drive and holds these, so whoever reads it checks them all.
"""

from collections.abc import Iterator
from enum import Enum
from typing import Any

from belt_ros.parameter_table import PARAMETERS, Parameter, SettingsError


class InputKind(str, Enum):
    """What speeds and torques come as."""

    JOINT_STATE = "joint_state"
    PULLEY_STATE = "pulley_state"
    FLOAT64 = "float64"


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
        "want of processor, so that alarms are as much later; 0: never, then it falls behind",
        "s",
        0.0,
        0.2,
    )
    yield Parameter("diagnostics_period", 1.0, "between two /diagnostics", "s", 0.05, 60.0)
    yield _Switch(
        "use_memory",
        default=True,
        meaning="whether memory_file is read and written; false for old data and for tests",
    )
    yield Parameter("memory_period", 10.0, "between two savings of memory_file", "s", 0.1, 86400.0)


def _unit_table() -> Iterator[Parameter]:
    yield Parameter(
        "input",
        InputKind.JOINT_STATE.value,
        "what speeds and torques come as: one joint_states; driver/state and driven/state "
        "(belt_msgs/PulleyState); or driver/speed, driver/torque, driver/position and the same of "
        "driven (std_msgs/Float64)",
        choices=tuple(kind.value for kind in InputKind),
    )
    yield Parameter(
        "input_reorder_window",
        0.05,
        "how long a message waits at most for what other topics say of the same time; joint_states "
        "alone waits for nothing",
        "s",
        0.0,
        10.0,
    )
    yield Parameter(
        "input_disorder",
        0.0,
        "how much older than the newest of its own topic a message may come; all wait that long",
        "s",
        0.0,
        10.0,
    )
    yield Parameter(
        "input_slop",
        0.001,
        "stamps of different topics that differ by no more than this are one measurement",
        "s",
        0.0,
        1.0,
    )
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
OF_EVERY_NODE = ("use_sim_time", "qos_overrides.", "start_type_description_service")
"""What names of parameters begin with that rclpy gives to every node."""
