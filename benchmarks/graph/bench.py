"""The bench: node, relay, counter and sender as processes of one domain, in one folder."""

import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import NamedTuple

from benchmarks.graph import relay
from benchmarks.graph.counter import Heard
from benchmarks.graph.domain import own_domain
from benchmarks.graph.plan import Plan, Sent, load_sent, save_plan
from benchmarks.graph.program import Program, resident_bytes

NODE = "belt_ros.node.main"
NODE_NAME = "belt_node"
INPUT, STATE = "joint_states", f"{NODE_NAME}/state"
READY = "active, listening"
_SAMPLING = 0.5  # [s] between two looks at the memory
_MARGIN = 60.0  # [s] beyond a plan's own time


class Memory(NamedTuple):
    """Memory in RAM [B] over wall time [ns]."""

    times: list[int]
    resident: list[int]

    def growth(self, first_ns: int, last_ns: int) -> int:
        """Median of the last tenth between two instants, less that of the first tenth."""
        within = [
            size
            for when, size in zip(self.times, self.resident, strict=True)
            if first_ns <= when <= last_ns
        ]
        tenth = max(len(within) // 10, 1)
        return round(median(within[-tenth:]) - median(within[:tenth]))


class Bench:
    """What runs together; see `bench`."""

    def __init__(self, folder: Path, environment: dict[str, str], running: ExitStack) -> None:
        self.folder = folder
        self.environment = environment
        self._running = running
        self._started = 0

    def start(self, module: str, *arguments: str) -> Program:
        """Start a program, which ends with the bench."""
        self._started += 1
        log = self.folder / f"{self._started}.log"
        program = Program(module, log, self.environment, *arguments)
        return self._running.enter_context(program)

    def start_node(self, params: Path, **parameters: object) -> Program:
        """Start the node as its users do, and wait until it is active."""
        arguments = ["--ros-args", "--params-file", str(params)]
        for name, value in parameters.items():
            arguments += ["-p", f"{name}:={value}"]
        node = self.start(NODE, *arguments)
        node.wait_for(READY)
        return node

    def start_relay(self, depth: int) -> Program:
        """Start the bare relay."""
        program = self.start(relay.__name__, str(depth))
        program.wait_for("ready")
        return program

    def run(
        self, plan: Plan, topics: tuple[str, ...], node: Program
    ) -> tuple[list[Sent], list[Heard], Memory]:
        """Send by a plan; return what was sent, what came on `topics`, and the node's memory."""
        written, result, noted = (self.folder / name for name in ("plan", "sent", "heard"))
        save_plan(plan, written)
        counter = self.start("benchmarks.graph.counter", str(noted), *topics)
        counter.wait_for("ready")
        sender = self.start("benchmarks.graph.sender", str(written), str(result))
        memory = Memory([], [])
        end = time.monotonic() + _MARGIN + sum(block.seconds + block.pause for block in plan.blocks)
        while sender.alive and time.monotonic() < end:
            memory.times.append(time.time_ns())
            memory.resident.append(resident_bytes(node.pid))
            time.sleep(_SAMPLING)
        sender.wait(0.1)
        counter.stop()
        return load_sent(result), Heard.load(noted), memory


@contextmanager
def bench() -> Iterator[Bench]:
    """Open a bench in a domain of its own; all that it started ends with it."""
    with (
        own_domain() as environment,
        TemporaryDirectory(prefix="belt_graph_") as folder,
        ExitStack() as running,
    ):
        yield Bench(Path(folder), environment, running)
