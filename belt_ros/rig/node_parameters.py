"""What the rig is told by parameters: read once, when the node starts."""

from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.node import Node

from belt_ros.rig.outputs import OutputKind
from belt_ros.rig.readings import Rates
from belt_ros.rig.scenario import ScenarioError

_MOST_DRIVES = 500
_FASTEST = 1e4  # [Hz]


@dataclass(frozen=True)
class RigParameters:
    """What the rig plays, how fast, and what it publishes. Rates [Hz]; 0: as the scenario says."""

    config_file: str
    scenario_file: str
    drives: int
    output: OutputKind
    rates: Rates
    truth_rate: float
    loads: bool
    rate_factor: float
    patience: float  # [s]
    subscribers: float
    loop: bool

    def rates_of(self, sample_rate: float) -> tuple[Rates, float]:
        """Return the rates of pulleys and truth [Hz] in a scenario with so many samples a second.

        Raises
        ------
        ScenarioError
            If one is greater than `sample_rate`.
        """
        told = {"driver_rate": self.rates.driver, "driven_rate": self.rates.driven}
        for name, rate in {**told, "truth_rate": self.truth_rate}.items():
            if rate > sample_rate:
                raise ScenarioError(
                    f"parameter {name} is {rate:g} Hz, the scenario has {sample_rate:g} samples a "
                    "second; raise its sample_rate"
                )
        rates = Rates(*(rate or sample_rate for rate in self.rates))
        return rates, self.truth_rate or sample_rate


def describe(meaning: str) -> ParameterDescriptor:
    """Return the descriptor of a parameter that is fixed once the node has started."""
    # A YAML's 1 is as good as 1.0, so types are left open and checked here.
    return ParameterDescriptor(description=meaning, read_only=True, dynamic_typing=True)


def read_rig_parameters(node: Node) -> RigParameters:
    """Declare all parameters but ``fault`` on `node`, and check what they were given.

    Raises
    ------
    ScenarioError
        If one cannot be used; the message names it.
    """
    reader = _Reader(node)
    return RigParameters(
        config_file=reader.path("config_file", "YAML that describes the drive, or several"),
        scenario_file=reader.path("scenario_file", "YAML that scripts the run"),
        drives=int(
            reader.number(
                "drives",
                0,
                "so many drives like the one in config_file, drive_1 and so on, which share a "
                "plant; 0: as config_file says",
                high=_MOST_DRIVES,
            )
        ),
        output=OutputKind(
            reader.choice(
                "output",
                [kind.value for kind in OutputKind],
                "what readings go out as: one joint_states; driver/state and driven/state "
                "(belt_msgs/PulleyState); or driver/speed, driver/torque, driver/position and the "
                "same of driven (std_msgs/Float64)",
            )
        ),
        rates=Rates(
            reader.rate("driver_rate", "readings of the driver per second"),
            reader.rate("driven_rate", "readings of the driven pulley per second"),
        ),
        truth_rate=reader.rate("truth_rate", "messages of the truth per second"),
        loads=reader.switch(
            "loads",
            "measure hub loads and span tension too: in the pulley states, else as "
            "driver/hub_load, driven/hub_load and driven/span_tension (std_msgs/Float64)",
        ),
        rate_factor=reader.number("rate_factor", 1.0, "times faster than real time", 0.01, 1e3),
        patience=reader.number(
            "wait_for_subscriber", 2.0, "longest wait for subscribers [s]", high=3600.0
        ),
        subscribers=reader.number(
            "subscribers", 1.0, "how many are waited for on each topic with speeds", 1.0, 1000.0
        ),
        loop=reader.switch("loop", "begin again at the end"),
    )


class _Reader:
    """Declares parameters on a node, one kind of value a method."""

    def __init__(self, node: Node) -> None:
        self._node = node

    def path(self, name: str, meaning: str) -> str:
        value = self._declare(name, "", describe(meaning))
        if not value:
            raise ScenarioError(
                f"parameter {name} is empty; give the {meaning}, e.g. with "
                f"--ros-args -p {name}:=<file>"
            )
        return str(value)

    def number(
        self, name: str, default: float, meaning: str, low: float = 0.0, high: float = _FASTEST
    ) -> float:
        descriptor = describe(meaning)
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(low), to_value=float(high))
        ]
        value = self._declare(name, default, descriptor)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ScenarioError(f"parameter {name} is {value!r}; it must be a number")
        if not low <= value <= high:
            raise ScenarioError(
                f"parameter {name} is {value:g}; it must lie between {low:g} and {high:g}"
            )
        return float(value)

    def rate(self, name: str, meaning: str) -> float:
        return self.number(name, 0.0, f"{meaning} [Hz]; 0: as many as the scenario's samples")

    def switch(self, name: str, meaning: str) -> bool:
        value = self._declare(name, default=False, descriptor=describe(meaning))
        if not isinstance(value, bool):
            raise ScenarioError(f"parameter {name} is {value!r}; it must be true or false")
        return value

    def choice(self, name: str, choices: list[str], meaning: str) -> str:
        """Return one of `choices`, the first of which is the default."""
        value = self._declare(name, choices[0], describe(meaning))
        if value not in choices:
            raise ScenarioError(
                f"parameter {name} is {value!r}; it must be one of {', '.join(choices)}"
            )
        return str(value)

    def _declare(self, name: str, default: Any, descriptor: ParameterDescriptor) -> object:
        return self._node.declare_parameter(name, default, descriptor).value
