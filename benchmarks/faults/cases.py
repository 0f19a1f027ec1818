"""What a fault is here: a scenario of the rig, and which alarms are right, and by when.

The drive learns for a while under a load that moves; then comes the fault, then its cause is gone,
then the alarms are acknowledged while the drive goes on.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from belt_ros.estimation import Condition, Rejection
from benchmarks.graph.program import ROOT

BEGIN, END, DURATION = 8.0, 11.0, 15.5  # [s] of fault and run where not said otherwise
TRACTION = frozenset(
    {
        Condition.TRACTION_LOST,
        Condition.TENSION_LOST,
        Condition.FRICTION_LOST,
        Condition.LOW_MARGIN,
    }
)
SLIP = frozenset({Condition.GROSS_SLIP, Condition.EXCESS_SLIP})
NOTHING: frozenset[Condition] = frozenset()


class Right(NamedTuple):
    """Which alarms are right, and by when. Without `accepted`, silence is."""

    why: str
    accepted: frozenset[Condition] = NOTHING  # one of them is to be raised ...
    within: float = 0.0  # ... in this time [s]
    also: frozenset[Condition] = NOTHING  # these may be raised too: they are true as well
    counted: Rejection = Rejection.NONE  # why measurements are to be turned away
    resets: int = 0  # how often the estimate is to begin anew


class Case(NamedTuple):
    """A fault."""

    name: str
    what: str
    script: Mapping[str, Any]
    right: Right
    begin: float = BEGIN  # [s] when it is there
    end: float = END  # [s] when its cause is gone
    drive: str = "demo_drive"

    @property
    def config(self) -> Path:
        """Parameters of the drive."""
        return ROOT / "config" / f"{self.drive}.yaml"

    @property
    def duration(self) -> float:
        """Length of the run [s]."""
        return float(self.script["duration"])

    @property
    def acknowledged(self) -> float:
        """When an operator acknowledges [s]."""
        return self.duration - 1.0


_LEARNING = [[2.0, 0.0], [2.2, 15.0], [3.2, 15.0], [3.4, 42.0], [4.6, 42.0], [4.8, 25.0]]
STEADY = [*_LEARNING, [6.0, 25.0], [6.5, 38.0]]  # N m; margin 0.43
MOVING = [
    *_LEARNING,
    *([6.0 + 0.75 * step, 38.0 if step % 2 else 22.0] for step in range(1, 25)),
]


def demo_script(
    load: Sequence[Sequence[float]] = STEADY,
    *,
    duration: float = DURATION,
    events: Sequence[Mapping[str, float]] = (),
    faults: Sequence[Mapping[str, Any]] = (),
) -> dict[str, Any]:
    """Return a scenario of the demonstration's drive.

    Parameters
    ----------
    load : sequence
        Points of time [s] and load [N m].
    duration : float
        [s]
    events, faults : sequence
        As in a scenario.
    """
    return {
        "duration": duration,
        "sample_rate": 100.0,
        "seed": 3,
        "speed": [[0.2, 0.0], [1.7, 120.0]],
        "load": [list(point) for point in load if point[0] <= duration],
        "condition": {
            "tension": 440.0,
            "friction_stiffness": 6.0e6,
            "friction_coefficient": 1.18,
            "ratio_bias": 5.0e-5,
            "creep_error": 0.01,
        },
        "events": [dict(event) for event in events],
        "faults": [dict(fault) for fault in faults],
    }


def there_and_back(
    quantity: str, lost: float, sound: float, *, begin: float = BEGIN, end: float = END
) -> list[dict[str, float]]:
    """Return events: `quantity` becomes `lost` in 0.2 s from `begin`, and is `sound` at `end`."""
    return [
        {"at": begin, quantity: lost, "over": 0.2},
        {"at": end - 0.2, quantity: sound, "over": 0.2},
    ]
