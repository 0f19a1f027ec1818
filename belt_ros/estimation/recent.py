"""The filter's last steps, which may have to be repeated before they are final."""

from collections import deque
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.gaussian_sum import Component
from belt_ros.estimation.load import Activity
from belt_ros.estimation.process import CreepChange, Process
from belt_ros.estimation.sensing import Sensed
from belt_ros.estimation.smoother import Members, Moved

_Floats = NDArray[np.float64]
_WINDOW = 20  # steps
_RISEN = 5.0  # of the load's activity, at which a step is repeated


class Step(NamedTuple):
    """One step of the filter: its members before, what it took in, and how they moved."""

    stamp_ns: int
    dt: float  # [s]
    before: Members
    sensed: Sensed
    undeveloped: CreepChange
    activity: Activity  # of the load ...
    calm: tuple[float, float]  # ... and as plain floats what was taken of it
    processes: tuple[Process, Process]
    moved: Moved
    taken_in: bool = False  # a gated one is not


class Recorder(Protocol):
    """Whoever wants to know of all steps, once they are final: `smoother.Smoother`."""

    def start(self, stamp_ns: int) -> None:
        """Begin a chain of steps."""

    def step(
        self, stamp_ns: int, before: Members, processes: tuple[Process, Process], moved: Moved
    ) -> None:
        """Take in a step."""

    def fade(self, stamp_ns: int, before: Members, processes: tuple[Process, Process]) -> None:
        """Take in a gap."""

    def switch(self, members: list[Component], came_from: list[bool]) -> None:
        """Take in a change of modes."""

    def cut(self, belief: list[Component]) -> None:
        """End a chain of steps."""


class RecentSteps:
    """Keep the last steps; those that have become final go to the recorder, if there is one."""

    def __init__(self) -> None:
        self.recorder: Recorder | None = None
        self._steps: deque[Step] = deque()
        self._switches: dict[int, tuple[list[Component], list[bool]]] = {}

    def append(self, step: Step) -> None:
        """Keep a step; the oldest becomes final."""
        self._steps.append(step)
        if len(self._steps) > _WINDOW:
            self._settle(self._steps.popleft())

    def take_back(self) -> Step | None:
        """Take out the last step, unless it is final."""
        return self._steps.pop() if self._steps else None

    def take_in(self) -> None:
        """Note that what was sensed at the last step has been taken in."""
        if self._steps:
            self._steps[-1] = self._steps[-1]._replace(taken_in=True)

    def switch(self, members: list[Component], came_from: list[bool]) -> None:
        """Keep a change of modes, after the last step."""
        if self.recorder is None:
            return
        if self._steps:
            self._switches[self._steps[-1].stamp_ns] = members, came_from
        else:
            self.recorder.switch(members, came_from)

    def taken_too_calm(self, activity: _Floats) -> list[Step]:
        """Take out the last steps, from the first that was taken for much calmer than this."""
        driver, driven = (activity / _RISEN).tolist()
        calm = (driver > step.calm[0] or driven > step.calm[1] for step in self._steps)
        first = next((at for at, is_calm in enumerate(calm) if is_calm), len(self._steps))
        again = [self._steps.pop() for _ in range(len(self._steps) - first)]
        for step in again:
            self._switches.pop(step.stamp_ns, None)
        return again[::-1]

    def settle(self) -> None:
        """Make all steps final."""
        while self._steps:
            self._settle(self._steps.popleft())

    def _settle(self, step: Step) -> None:
        if self.recorder is None:
            return
        self.recorder.step(step.stamp_ns, step.before, step.processes, step.moved)
        if (switch := self._switches.pop(step.stamp_ns, None)) is not None:
            self.recorder.switch(*switch)
