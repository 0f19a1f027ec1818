"""The node as a process of its own, and a client that knows nothing of it but its messages."""

import gc
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any

import rclpy
from belt_msgs.msg import BeltState, SlipAlarm
from belt_msgs.srv import RecordMaintenance
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, SetParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from service_discovery import await_answers
from std_srvs.srv import Trigger

ROOT = Path(__file__).resolve().parents[2]
PAPER_DRIVE = ROOT / "config" / "paper_drive.yaml"
NAMES = ("driver_pulley_joint", "driven_pulley_joint")
MILLISECOND = 1_000_000
SECOND = 1_000_000_000
CONFIGURE = Transition.TRANSITION_CONFIGURE
CLEANUP = Transition.TRANSITION_CLEANUP
ACTIVATE = Transition.TRANSITION_ACTIVATE
DEACTIVATE = Transition.TRANSITION_DEACTIVATE


@contextmanager
def context_in(domain: int) -> Iterator[Context]:
    """Give a context for nodes in this process, of which nothing is left in the graph afterwards.

    A lifecycle node stays in the graph after it was destroyed until it is collected as garbage.
    """
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    yield context
    rclpy.shutdown(context=context)
    gc.collect()


class NodeProcess:
    """`belt_node` in a process; `log` is what it says.

    However busy this machine is with other tests, it pools nothing unless a test asks for it.
    """

    def __init__(
        self, domain: int, log: Path, params: Path | None = PAPER_DRIVE, **parameters: object
    ) -> None:
        arguments = ["--ros-args"]
        if params is not None:
            arguments += ["--params-file", str(params)]
        for name, value in ({"longest_pool": 0.0} | parameters).items():
            arguments += ["-p", f"{name.replace('__', '.')}:={value}"]
        self._log = log
        with log.open("w") as file:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "belt_ros.node.main", *arguments],
                stdout=file,
                stderr=subprocess.STDOUT,
                cwd=ROOT,
                env={**os.environ, "ROS_DOMAIN_ID": str(domain)},
            )

    def __enter__(self) -> "NodeProcess":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.alive:
            self.kill()

    @property
    def alive(self) -> bool:
        return self._process.poll() is None

    @property
    def log(self) -> str:
        return self._log.read_text()

    def wait_for_log(self, text: str, timeout: float = 60.0) -> None:
        end = time.monotonic() + timeout
        while text not in self.log:
            assert self.alive, self.log
            assert time.monotonic() < end, f"no {text!r} in:\n{self.log}"
            time.sleep(0.02)

    def wait_for_exit(self, timeout: float = 20.0) -> int:
        return self._process.wait(timeout)

    def kill(self) -> None:
        """End it as a loss of power would."""
        self._process.kill()
        self._process.wait()

    def interrupt(self, number: signal.Signals = signal.SIGINT) -> None:
        self._process.send_signal(number)


def ns(stamp: Time) -> int:
    return int(stamp.sec) * SECOND + int(stamp.nanosec)


def stamp(time_ns: int) -> Time:
    return Time(sec=time_ns // SECOND, nanosec=time_ns % SECOND)


def joint_state(
    stamp_ns: int,
    velocity: Sequence[float] = (120.0, 119.4),
    effort: Sequence[float] = (30.0, -30.0),
    name: Sequence[str] = NAMES,
) -> JointState:
    """A belt that pulls 30 N m over with half a percent of creep."""
    message = JointState(name=list(name), velocity=list(velocity), effort=list(effort))
    message.header.stamp = stamp(stamp_ns)
    return message


class Client:
    """What a user's program sees of the node. Its drive's time runs in steps of 10 ms."""

    step_ns = 10 * MILLISECOND

    def __init__(self, domain: int) -> None:
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self.node = rclpy.create_node("client", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self.states: list[BeltState] = []
        self.alarms: list[SlipAlarm] = []
        self.diagnostics: list[tuple[float, DiagnosticArray]] = []
        self._services: dict[str, Any] = {}
        self._publisher = self.node.create_publisher(JointState, "joint_states", 500)
        subscribe = self.node.create_subscription
        subscribe(BeltState, "belt_node/state", self.states.append, 1000)
        subscribe(DiagnosticArray, "/diagnostics", self._on_diagnostics, 100)
        self.listen_for_alarms(self.alarms)
        self.now_ns = time.time_ns()

    def listen_for_alarms(self, to: list[SlipAlarm]) -> None:
        latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.node.create_subscription(SlipAlarm, "belt_node/alarm", to.append, latched)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        self.diagnostics.append((time.monotonic(), message))

    def close(self) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self._context)

    def spin(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def until(self, condition: Callable[[], bool], timeout: float = 20.0) -> None:
        end = time.monotonic() + timeout
        while not condition():
            last = self.states[-1:] or "no state"
            assert time.monotonic() < end, f"timed out; {len(self.states)} states, {last}"
            self._spin_once()

    def send(self, **fields: Any) -> int:
        """Publish the drive's next joint state; return its stamp."""
        self.now_ns += self.step_ns
        self._publisher.publish(joint_state(self.now_ns, **fields))
        return self.now_ns

    def send_raw(self, message: JointState) -> None:
        self._publisher.publish(message)

    def drive(self, count: int, **fields: Any) -> list[int]:
        """Publish at real speed; return the stamps."""
        stamps = []
        due = time.monotonic()
        for _ in range(count):
            stamps.append(self.send(**fields))
            due += self.step_ns / SECOND
            self.spin(due - time.monotonic())
        return stamps

    def connect(self, **fields: Any) -> None:
        """Publish until the node answers."""

        def answered() -> bool:
            self.send(**fields)
            self.spin(0.02)
            return self.last_stamp() == self.now_ns

        self.until(answered, timeout=60.0)
        self.until(lambda: bool(self.alarms))

    def last_stamp(self) -> int:
        """Return the stamp of the last state, 0 before the first."""
        return ns(self.states[-1].header.stamp) if self.states else 0

    def next_state(self, **fields: Any) -> BeltState:
        """Publish a good measurement and return the state that comes of it."""
        sent = self.send(**fields)
        self.until(lambda: self.last_stamp() == sent)
        return self.states[-1]

    def row(self, ending: str) -> DiagnosticStatus:
        """Return the next diagnostics row whose name ends so."""
        before = len(self.diagnostics)
        self.until(lambda: bool(self.rows(ending, before)))
        return self.rows(ending, before)[0]

    def rows(self, ending: str, since: int = 0) -> list[DiagnosticStatus]:
        """Return what has come of the diagnostics rows whose name ends so."""
        return [
            row
            for _, message in self.diagnostics[since:]
            for row in message.status
            if row.name.endswith(ending)
        ]

    def call(self, kind: Any, name: str, request: Any, timeout: float = 20.0) -> Any:
        if name not in self._services:
            self._services[name] = self.node.create_client(kind, f"belt_node/{name}")
            self.until(self._services[name].service_is_ready, timeout)
            await_answers(self.node, self._spin_once, GetState, "belt_node/get_state", timeout)
        future = self._services[name].call_async(request)
        self.until(future.done, timeout)
        return future.result()

    def _spin_once(self) -> None:
        self._executor.spin_once(timeout_sec=0.05)

    def trigger(self, name: str) -> Trigger.Response:
        return self.call(Trigger, name, Trigger.Request())

    def record_maintenance(self, action: int, **fields: Any) -> RecordMaintenance.Response:
        request = RecordMaintenance.Request(action=action, **fields)
        return self.call(RecordMaintenance, "record_maintenance", request)

    def transition(self, number: int) -> bool:
        request = ChangeState.Request(transition=Transition(id=number))
        return bool(self.call(ChangeState, "change_state", request, timeout=60.0).success)

    def lifecycle_state(self) -> str:
        response = self.call(GetState, "get_state", GetState.Request())
        return str(response.current_state.label)

    def set_parameter(self, name: str, value: float | int | None) -> tuple[bool, str]:
        if isinstance(value, float):
            typed = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)
        elif isinstance(value, int):
            typed = ParameterValue(type=ParameterType.PARAMETER_INTEGER, integer_value=value)
        else:
            typed = ParameterValue()
        request = SetParameters.Request(parameters=[Parameter(name=name, value=typed)])
        result = self.call(SetParameters, "set_parameters", request).results[0]
        return bool(result.successful), str(result.reason)

    def get_parameter(self, name: str) -> ParameterValue:
        request = GetParameters.Request(names=[name])
        return self.call(GetParameters, "get_parameters", request).values[0]

    def describe_parameter(self, name: str) -> Any:
        request = DescribeParameters.Request(names=[name])
        return self.call(DescribeParameters, "describe_parameters", request).descriptors[0]


def numbers(message: Any) -> dict[str, float]:
    """The floating-point fields of a message."""
    return {
        name: getattr(message, name)
        for name, kind in message.get_fields_and_field_types().items()
        if kind == "double"
    }


def not_finite(message: Any) -> list[str]:
    return [name for name, value in numbers(message).items() if not math.isfinite(value)]
