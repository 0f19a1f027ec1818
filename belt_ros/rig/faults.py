"""What goes wrong between the sensors and whoever listens: readings in, joint states out.

Time is the stamps of the readings, chance is a generator that is handed in: the same readings and
faults give the same joint states every time. Faults act in the order in which they were added.
"""

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np

from belt_ros.rig.sensors import JointSample, rounded

_NS = 1e9
ALL = "all"

# Places in a row of positions, velocities and efforts, each of driver and driven pulley. An encoder
# gives position and speed.
PLACES: dict[str, tuple[int, ...]] = {
    "driver_position": (0,),
    "driven_position": (1,),
    "driver_speed": (2,),
    "driven_speed": (3,),
    "driver_torque": (4,),
    "driven_torque": (5,),
    "driver_encoder": (0, 2),
    "driven_encoder": (1, 3),
    ALL: (0, 1, 2, 3, 4, 5),
}


class FaultKind(str, Enum):
    """What a sensor, or the way from it, does wrong; see `Fault` for what `value` is to each."""

    DROPOUT = "dropout"
    STUCK = "stuck"
    SPIKE = "spike"
    QUANTISED = "quantised"
    DELAYED = "delayed"
    REORDERED = "reordered"
    TIME_JUMP = "time_jump"
    WRONG_SIGN = "wrong_sign"


@dataclass(frozen=True)
class Fault:
    """One fault, from `begin` to before `end`; it acts on one reading at the least.

    Attributes
    ----------
    kind : FaultKind
    begin, end : float
        Since the start of the run [s].
    sensor : str
        A key of `PLACES`. Of ``all``, dropout and delay concern the joint state as a whole: it does
        not come, or comes late with the stamp it had. Of one sensor they concern its reading: NaN,
        or what it was before, in a joint state that comes in time. Reordering and time jumps are of
        joint states only.
    value : float
        Added by a spike, or the step of a quantised reading [as in the joint state]; by how much a
        reading is delayed, or a stamp moved [s]. NaN for the other kinds.
    share : float
        Of the readings that a dropout or a spike hits, at random.
    """

    kind: FaultKind
    begin: float
    end: float = math.inf
    sensor: str = ALL
    value: float = math.nan
    share: float = 1.0


class Report(NamedTuple):
    """One joint state as it goes out, with the stamp that its header says."""

    stamp_ns: int
    joints: JointSample


_Values = tuple[float, ...]
_Change = Callable[[int, _Values], _Values]  # of a sensor's values at a time [ns]


class _Late:
    """Values as they were some time ago, at the earliest the first; stuck if that is for ever."""

    def __init__(self, delay_ns: float) -> None:
        self._delay_ns = delay_ns
        self._line: deque[tuple[float, _Values]] = deque()  # with the time when each is due

    def __call__(self, now_ns: int, values: _Values) -> _Values:
        if not self._line or math.isfinite(self._delay_ns):
            self._line.append((now_ns + self._delay_ns, values))
        while len(self._line) > 1 and self._line[1][0] <= now_ns:
            self._line.popleft()
        return self._line[0][1]


def _change(fault: Fault) -> _Change:
    """Return what a fault makes of the values of its sensor."""
    value = fault.value
    if fault.kind is FaultKind.STUCK:
        return _Late(math.inf)
    if fault.kind is FaultKind.DELAYED:
        return _Late(round(value * _NS))
    of_one: dict[FaultKind, Callable[[float], float]] = {
        FaultKind.DROPOUT: lambda _: math.nan,
        FaultKind.SPIKE: lambda reading: reading + value,
        FaultKind.QUANTISED: lambda reading: (
            rounded(reading, value) if math.isfinite(reading) else reading
        ),
        FaultKind.WRONG_SIGN: lambda reading: -reading,
    }
    change = of_one[fault.kind]
    return lambda _, values: tuple(map(change, values))


class _Stage(ABC):
    """A fault at work: between its begin and end it acts on the reports that pass."""

    def __init__(self, fault: Fault, start_ns: int, random: np.random.Generator) -> None:
        self.fault = fault
        self._begin = start_ns + round(fault.begin * _NS)
        end = fault.end * _NS
        self._end = start_ns + round(end) if math.isfinite(end) else math.inf
        self._random = random
        self._begun = False

    def step(self, now_ns: int, reports: list[Report]) -> list[Report]:
        """Return what comes out at `now_ns` when `reports` go in."""
        acts = self.acts_at(now_ns)
        self._begun |= acts
        if acts and self.fault.share < 1.0:
            acts = bool(self._random.random() < self.fault.share)
        return self._act(now_ns, reports) if acts else self._rest(now_ns, reports)

    def end(self) -> None:
        """Act no more."""
        self._begun = True
        self._end = -math.inf

    def acts_at(self, now_ns: int) -> bool:
        """Whether it acts now; what acts on one reading does so until that has come."""
        return self._begin <= now_ns and (now_ns < self._end or not self._begun)

    def over(self, now_ns: int) -> bool:
        """Whether nothing more will come of it."""
        return self._begun and now_ns >= self._end

    @abstractmethod
    def _act(self, now_ns: int, reports: list[Report]) -> list[Report]:
        """Return what becomes of reports while the fault acts."""

    def _rest(self, _now_ns: int, reports: list[Report]) -> list[Report]:
        return reports


class _Sensor(_Stage):
    """Readings of a sensor are not what they should be."""

    def __init__(self, fault: Fault, start_ns: int, random: np.random.Generator) -> None:
        super().__init__(fault, start_ns, random)
        self._change = _change(fault)
        self._places = PLACES[fault.sensor]

    def _act(self, now_ns: int, reports: list[Report]) -> list[Report]:
        return [Report(stamp, self._changed(now_ns, joints)) for stamp, joints in reports]

    def _changed(self, now_ns: int, joints: JointSample) -> JointSample:
        row = [*joints.positions, *joints.velocities, *joints.efforts]
        changed = self._change(now_ns, tuple(row[place] for place in self._places))
        for place, value in zip(self._places, changed, strict=True):
            row[place] = value
        return JointSample(joints.names, (row[0], row[1]), (row[2], row[3]), (row[4], row[5]))


class _Dropout(_Stage):
    """Joint states do not come."""

    def _act(self, _now_ns: int, _reports: list[Report]) -> list[Report]:
        return []


class _TimeJump(_Stage):
    """The clock that stamps joint states is another one."""

    def _act(self, _now_ns: int, reports: list[Report]) -> list[Report]:
        jump = round(self.fault.value * _NS)
        return [Report(stamp + jump, joints) for stamp, joints in reports]


class _Delay(_Stage):
    """Joint states come late; when that ends, the late ones come between those in time."""

    def __init__(self, fault: Fault, start_ns: int, random: np.random.Generator) -> None:
        super().__init__(fault, start_ns, random)
        self._line: deque[tuple[int, Report]] = deque()  # with the time when each is due

    def _act(self, now_ns: int, reports: list[Report]) -> list[Report]:
        due = now_ns + round(self.fault.value * _NS)
        self._line.extend((due, report) for report in reports)
        return self._rest(now_ns, [])

    def _rest(self, now_ns: int, reports: list[Report]) -> list[Report]:
        late: list[Report] = []
        while self._line and self._line[0][0] <= now_ns:
            late.append(self._line.popleft()[1])
        return late + reports

    def over(self, now_ns: int) -> bool:
        return super().over(now_ns) and not self._line


class _Reordering(_Stage):
    """Of two joint states the later one comes first."""

    def __init__(self, fault: Fault, start_ns: int, random: np.random.Generator) -> None:
        super().__init__(fault, start_ns, random)
        self._waiting: list[Report] = []

    def _act(self, _now_ns: int, reports: list[Report]) -> list[Report]:
        if not self._waiting:
            self._waiting = reports
            return []
        waiting, self._waiting = self._waiting, []
        return reports + waiting

    def _rest(self, _now_ns: int, reports: list[Report]) -> list[Report]:
        waiting, self._waiting = self._waiting, []
        return waiting + reports

    def over(self, now_ns: int) -> bool:
        return super().over(now_ns) and not self._waiting


_OF_JOINT_STATES: dict[FaultKind, type[_Stage]] = {
    FaultKind.DROPOUT: _Dropout,
    FaultKind.DELAYED: _Delay,
    FaultKind.REORDERED: _Reordering,
    FaultKind.TIME_JUMP: _TimeJump,
}


class SensorFaults:
    """All faults between sensors and listeners, and what they make of the readings.

    Parameters
    ----------
    random : numpy.random.Generator
        Of faults that hit some readings only; not drawn from without such a fault.
    """

    def __init__(self, random: np.random.Generator) -> None:
        self._random = random
        self._stages: list[_Stage] = []
        self._now_ns = 0

    def __len__(self) -> int:
        return len(self._stages)

    def add(self, fault: Fault, start_ns: int = 0) -> None:
        """Let a fault come, its times counted from `start_ns` [ns]."""
        kinds = _OF_JOINT_STATES if fault.sensor == ALL else {}
        stage = kinds.get(fault.kind, _Sensor)
        self._stages.append(stage(fault, start_ns, self._random))

    def reports(self, now_ns: int, joints: JointSample) -> tuple[Report, ...]:
        """Return the joint states that go out at `now_ns`, when `joints` are read."""
        self._now_ns = now_ns
        reports = [Report(now_ns, joints)]
        for stage in self._stages:
            reports = stage.step(now_ns, reports)
        self._stages = [stage for stage in self._stages if not stage.over(now_ns)]
        return tuple(reports)

    def end(self) -> tuple[Fault, ...]:
        """End the faults that act or are about to; return them. What they hold back still comes."""
        acting = [stage for stage in self._stages if stage.acts_at(self._now_ns)]
        for stage in acting:
            stage.end()
        return tuple(stage.fault for stage in acting)
