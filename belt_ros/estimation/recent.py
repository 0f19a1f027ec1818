"""The filter's last steps, which may have to be repeated before they are final."""

import math
from collections import deque
from typing import NamedTuple, Protocol

from belt_ros.estimation.gaussian_sum import Component
from belt_ros.estimation.load import Activity
from belt_ros.estimation.process import CreepChange, Process
from belt_ros.estimation.sensing import Sensed
from belt_ros.estimation.smoother import Members, Moved

_WINDOW = 20  # steps
_RISEN = 5.0  # of the load's activity, at which a step is repeated
_LIVELIEST = math.inf, math.inf
_SECONDS = 1e-9  # of a nanosecond


class Step(NamedTuple):
    """One step of the filter: its members before, what it took in, and how they moved."""

    stamp_ns: int
    dt: float  # [s]
    before: Members
    sensed: Sensed
    undeveloped: CreepChange
    activity: Activity  # of the load
    processes: tuple[Process, Process] | None  # for a recorder, if there was one
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


def _calmer(one: tuple[float, float], other: tuple[float, float]) -> tuple[float, float]:
    """Return the lesser of two activities, for each pulley."""
    return min(one[0], other[0]), min(one[1], other[1])


class RecentSteps:
    """Keep the last steps; those that have become final go to the recorder, if there is one."""

    def __init__(self) -> None:
        self.recorder: Recorder | None = None
        self._steps: deque[Step] = deque()
        self._switches: dict[int, tuple[list[Component], list[bool]]] = {}
        self._calmest = _LIVELIEST  # no step that is kept was calmer

    def append(self, step: Step) -> None:
        """Keep a step; the oldest becomes final."""
        self._steps.append(step)
        self._calmest = _calmer(self._calmest, step.activity.taken)
        if len(self._steps) > _WINDOW:
            self._settle(self._steps.popleft())

    def take_back(self) -> Step | None:
        """Take out the last step, unless it is final."""
        return self._steps.pop() if self._steps else None

    def take_in(self) -> None:
        """Note that what was sensed at the last step has been taken in."""
        if self._steps:
            self._steps[-1] = Step(*self._steps[-1][:-1], taken_in=True)

    def switch(self, members: list[Component], came_from: list[bool]) -> None:
        """Keep a change of modes, after the last step."""
        if self.recorder is None:
            return
        if self._steps:
            self._switches[self._steps[-1].stamp_ns] = members, came_from
        else:
            self.recorder.switch(members, came_from)

    def taken_too_calm(self, activity: Activity) -> list[Step]:
        """Take out the last steps, from the first that was taken for much calmer than torques show.

        Only those in which the load can have been like this unseen: what the steps before have
        told, while it rested, stands. Slip that moves by itself takes none: it may as well be
        traction that is being lost. A jump is no livelier than the liveliest walk.
        """
        driver, driven = (min(shown, 1.0) / _RISEN for shown in activity.shown)
        if not self._steps or (driver <= self._calmest[0] and driven <= self._calmest[1]):
            return []
        last = self._steps[-1].stamp_ns
        driver_since, driven_since = (last - unseen / _SECONDS for unseen in activity.unseen)
        self._calmest = _LIVELIEST
        first = len(self._steps)
        for at, step in enumerate(self._steps):
            taken = step.activity.taken
            if (driver > taken[0] and step.stamp_ns >= driver_since) or (
                driven > taken[1] and step.stamp_ns >= driven_since
            ):
                first = at
                break
            self._calmest = _calmer(self._calmest, taken)
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
        assert step.processes is not None, "a recorder is there from before the first step it hears"
        self.recorder.step(step.stamp_ns, step.before, step.processes, step.moved)
        if (switch := self._switches.pop(step.stamp_ns, None)) is not None:
            self.recorder.switch(*switch)
