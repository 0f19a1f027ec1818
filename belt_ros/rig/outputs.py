"""How the rig's readings go out: joint states, pulley states, or plain numbers."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from typing import Any

from belt_msgs.msg import PulleyState
from builtin_interfaces.msg import Time
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from belt_ros.rig.readings import DRIVEN, DRIVER, PulleyReading

Create = Callable[[type, str], "Publisher[Any]"]  # a publisher of a message type on a topic
_PULLEYS = (DRIVER, DRIVEN)


class OutputKind(str, Enum):
    """What the rig's readings go out as."""

    JOINT_STATE = "joint_state"
    PULLEY_STATE = "pulley_state"
    FLOAT64 = "float64"


def time_message(stamp_ns: int) -> Time:
    """Return nanoseconds as a stamp."""
    seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
    return Time(sec=seconds, nanosec=nanoseconds)


def prefixes(drives: Sequence[str]) -> Mapping[str, str]:
    """Return what the topics of each drive begin with: nothing, where there is but one."""
    return {drive: f"{drive}/" if len(drives) > 1 else "" for drive in drives}


class Output(ABC):
    """Publishes readings.

    Attributes
    ----------
    awaited : list of Publisher
        Those without whose subscribers nobody listens.
    publishers : list of Publisher
        All.
    """

    def __init__(self, create: Create) -> None:
        self._create = create
        self.awaited: list[Publisher[Any]] = []
        self.publishers: list[Publisher[Any]] = []

    def _publisher(self, kind: type, topic: str, *, awaited: bool = True) -> "Publisher[Any]":
        publisher = self._create(kind, topic)
        self.publishers.append(publisher)
        if awaited:
            self.awaited.append(publisher)
        return publisher

    @abstractmethod
    def publish(self, readings: Sequence[PulleyReading]) -> None:
        """Publish what falls due at one time, in its order."""


class _Numbers(Output):
    """One std_msgs/Float64 topic for each quantity of a pulley, without a stamp."""

    def __init__(
        self, create: Create, drives: Sequence[str], quantities: Sequence[tuple[str, str]]
    ) -> None:
        super().__init__(create)
        self._topics = {
            (drive, pulley, quantity): self._publisher(
                Float64, f"{prefix}{pulley}/{quantity}", awaited=quantity == "speed"
            )
            for drive, prefix in prefixes(drives).items()
            for pulley, quantity in quantities
        }
        self._quantities: dict[str, list[str]] = {pulley: [] for pulley in _PULLEYS}
        for pulley, quantity in quantities:
            self._quantities[pulley].append(quantity)

    def publish(self, readings: Sequence[PulleyReading]) -> None:
        for reading in readings:
            for quantity in self._quantities[reading.pulley]:
                topic = self._topics[reading.drive, reading.pulley, quantity]
                topic.publish(Float64(data=getattr(reading, quantity)))


_MOTION = tuple((pulley, name) for pulley in _PULLEYS for name in ("speed", "torque", "position"))
_LOADS = ((DRIVER, "hub_load"), (DRIVEN, "hub_load"), (DRIVEN, "span_tension"))


class _PulleyStates(Output):
    """One belt_msgs/PulleyState topic for each pulley."""

    def __init__(self, create: Create, drives: Sequence[str]) -> None:
        super().__init__(create)
        self._topics = {
            (drive, pulley): self._publisher(PulleyState, f"{prefix}{pulley}/state")
            for drive, prefix in prefixes(drives).items()
            for pulley in _PULLEYS
        }

    def publish(self, readings: Sequence[PulleyReading]) -> None:
        for reading in readings:
            message = PulleyState(
                position=reading.position,
                speed=reading.speed,
                torque=reading.torque,
                hub_load=reading.hub_load,
                span_tension=reading.span_tension,
            )
            message.header.stamp = time_message(reading.stamp_ns)
            self._topics[reading.drive, reading.pulley].publish(message)


class _JointStates(Output):
    """One sensor_msgs/JointState topic for the joints of all drives.

    Parameters
    ----------
    create : callable
    joints : mapping
        Name of the joint in the message, by drive and pulley.
    """

    def __init__(self, create: Create, joints: Mapping[tuple[str, str], str]) -> None:
        super().__init__(create)
        self._joints = joints
        self._topic = self._publisher(JointState, "joint_states")

    def publish(self, readings: Sequence[PulleyReading]) -> None:
        messages: dict[int, JointState] = {}
        for reading in readings:
            if reading.stamp_ns not in messages:
                messages[reading.stamp_ns] = JointState()
            message = messages[reading.stamp_ns]
            message.name.append(self._joints[reading.drive, reading.pulley])
            message.position.append(reading.position)
            message.velocity.append(reading.speed)
            message.effort.append(reading.torque)
        for stamp_ns, message in messages.items():
            message.header.stamp = time_message(stamp_ns)
            self._topic.publish(message)


class _Together(Output):
    """Several outputs of the same readings."""

    def __init__(self, outputs: Sequence[Output]) -> None:
        self._outputs = outputs
        self.awaited = [publisher for output in outputs for publisher in output.awaited]
        self.publishers = [publisher for output in outputs for publisher in output.publishers]

    def publish(self, readings: Sequence[PulleyReading]) -> None:
        for output in self._outputs:
            output.publish(readings)


def make_output(
    kind: OutputKind,
    create: Create,
    joints: Mapping[tuple[str, str], str],
    *,
    loads: bool,
) -> Output:
    """Return what publishes the readings of all drives.

    Parameters
    ----------
    kind : OutputKind
    create : callable
        Makes a publisher of a type on a topic.
    joints : mapping
        Name of the joint of each pulley, by drive and pulley. Joints with the same name are told
        apart in the joint state by the name of their drive before it.
    loads : bool
        Whether there are hub loads and span tensions, which have topics of their own where the
        messages of `kind` have no room for them.
    """
    drives = tuple(dict.fromkeys(drive for drive, _ in joints))
    if kind is OutputKind.PULLEY_STATE:
        return _PulleyStates(create, drives)
    cells = [_Numbers(create, drives, _LOADS)] if loads else []
    if kind is OutputKind.FLOAT64:
        return _Together([_Numbers(create, drives, _MOTION), *cells])
    return _Together([_JointStates(create, _told_apart(joints)), *cells])


def _told_apart(joints: Mapping[tuple[str, str], str]) -> Mapping[tuple[str, str], str]:
    if len(set(joints.values())) == len(joints):
        return joints
    return {(drive, pulley): f"{drive}_{joint}" for (drive, pulley), joint in joints.items()}
