"""One drive of a node in this process: what it logs and keeps when estimation begins anew."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from node_harness import PAPER_DRIVE, context_in, joint_state
from rclpy.context import Context
from rclpy.parameter import Parameter

from belt_ros.estimation.belt_filter import BeltFilter
from belt_ros.estimation.memory_file import load
from belt_ros.node.belt_node import BeltNode
from belt_ros.node.pipeline import Pipeline
from belt_ros.settings import read_parameters

STEP_NS = 10_000_000
NEVER = 3600.0


class Drive:
    """A node of one drive, its log, and its memory file."""

    def __init__(
        self, context: Context, memory_file: Path, console: pytest.CaptureFixture[str]
    ) -> None:
        values = read_parameters(PAPER_DRIVE) | {
            "memory_file": str(memory_file),
            "memory_period": NEVER,
            "longest_pool": 0.0,
        }
        given = [Parameter(name, value=value) for name, value in values.items()]
        self.node = BeltNode(context=context, parameter_overrides=given)
        (self._unit,) = self.node.units
        (self._subscription,) = [
            each for each in self.node.subscriptions if each.topic_name == "/joint_states"
        ]
        self._console = console
        self.path = memory_file
        self._stamp_ns = 10**12

    def take(self, count: int) -> None:
        """Hand joint states to the node as its executor does."""
        for _ in range(count):
            self._stamp_ns += STEP_NS
            self._subscription.callback(joint_state(self._stamp_ns))

    def save(self) -> bytes:
        """Write what has been learned; return it."""
        assert self._unit._memory is not None
        self._unit._memory.finish()
        return self.path.read_bytes()

    @property
    def pipeline(self) -> Pipeline:
        assert self._unit.pipeline is not None
        return self._unit.pipeline

    def end(self) -> None:
        """Destroy the node and forget it."""
        self.node.destroy_node()
        del self.node, self._unit, self._subscription

    def log(self) -> list[str]:
        """Return what the node has logged since this was last asked."""
        return self._console.readouterr().err.splitlines()


@pytest.fixture
def drive(ros_domain: int, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> Iterator[Drive]:
    with context_in(ros_domain) as context:
        drive = Drive(context, tmp_path / "belt.json", capfd)
        yield drive
        drive.end()


@pytest.mark.parametrize(
    ("broken", "error"),
    [
        ((Pipeline, "take"), np.linalg.LinAlgError("singular")),
        ((Pipeline, "take"), ZeroDivisionError("division by zero")),
        ((BeltFilter, "predict"), FloatingPointError("overflow")),
    ],
)
def test_what_was_learned_before_a_failure_is_set_aside_and_the_failure_told_as_what_it_is(
    drive: Drive, broken: tuple[type, str], error: ArithmeticError
) -> None:
    drive.take(50)
    before = drive.save()

    def fail(*_: object) -> None:
        raise type(error)(*error.args)  # the parameter itself would keep the node by its traceback

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(*broken, fail)
        drive.take(1)
    drive.take(50)
    drive.save()

    aside = drive.path.with_name("belt.json.before_failure")
    assert aside.read_bytes() == before
    assert load(drive.path, "paper_drive") is not None
    log = drive.log()
    (line,) = [each for each in log if "estimation failed, starting anew at the priors" in each]
    assert line.endswith(f"; what was learned before is kept as {aside}")
    assert not any("the stamps went back" in each for each in log)
    assert drive.pipeline.health.resets == 1
