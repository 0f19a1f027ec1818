"""The faults: what happens to a drive, and which alarms are right, and by when.

Every case is a scenario of the rig. Its drive learns for a while under a load that moves; then
comes the fault, then it is gone, then the alarms are acknowledged while the drive goes on.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from belt_ros.estimation import Condition, Rejection
from benchmarks.graph.program import ROOT

_CONFIG = ROOT / "config"
BEGIN, END = 8.0, 11.0  # [s] of a fault where not said otherwise
DURATION = 16.0  # [s] likewise
ACKNOWLEDGED = 1.0  # [s] before the end of the run
LATENCY = 0.5  # [s] beyond its on-delay in which an alarm is to be heard, as for margin and slip

_TRACTION = frozenset(
    {
        Condition.TRACTION_LOST,
        Condition.TENSION_LOST,
        Condition.FRICTION_LOST,
        Condition.LOW_MARGIN,
    }
)
_SLIPPING = frozenset({Condition.GROSS_SLIP, Condition.EXCESS_SLIP})
_STALE = frozenset({Condition.SENSOR_STALE})
_SENSOR = frozenset({Condition.SENSOR_IMPLAUSIBLE})
_LOST = frozenset({Condition.ESTIMATOR_LOST})
_NONE: frozenset[Condition] = frozenset()


class Case(NamedTuple):
    """A fault, and what is right to be said of it."""

    name: str
    what: str
    script: Mapping[str, Any]
    accepted: frozenset[Condition] = _NONE  # one of them is to be raised; none: silence is right
    why: str = ""  # these, and within that time
    within: float = 0.0  # [s] after `begin`
    also: frozenset[Condition] = _NONE  # what may be raised as well, being true, or its consequence
    counted: Rejection = Rejection.NONE  # why measurements are to be turned away
    begin: float = BEGIN  # [s] when it is there
    end: float = END  # [s] when its cause is gone
    drive: str = "demo_drive"
    belt: bool = False  # whether it is the belt that fails

    @property
    def silent(self) -> bool:
        """Whether nothing is to be raised."""
        return not self.accepted

    @property
    def config(self) -> str:
        """Path of the drive's parameters."""
        return str(_CONFIG / f"{self.drive}.yaml")

    @property
    def duration(self) -> float:
        """Length of the run [s]."""
        return float(self.script["duration"])


_LEARNING = [[2.0, 0.0], [2.2, 15.0], [3.2, 15.0], [3.4, 42.0], [4.6, 42.0], [4.8, 25.0]]
_STEADY = [*_LEARNING, [6.0, 25.0], [6.5, 38.0]]
_MOVING = [
    *_LEARNING,
    *([6.0 + 0.75 * step, 38.0 if step % 2 else 22.0] for step in range(1, 13)),
]
_CONDITION = {"tension": 440.0, "friction_stiffness": 6.0e6, "friction_coefficient": 1.18}


def _script(
    *,
    load: list[list[float]] | None = None,
    events: list[dict[str, float]] | None = None,
    faults: list[dict[str, Any]] | None = None,
    **more: Any,
) -> dict[str, Any]:
    """Return a scenario of the demonstration's drive."""
    return {
        "duration": DURATION,
        "sample_rate": 100.0,
        "seed": 3,
        "speed": [[0.2, 0.0], [1.7, 120.0]],
        "load": load or _STEADY,
        "condition": _CONDITION,
        "events": events or [],
        "faults": faults or [],
        **more,
    }


def _sensor(kind: str, sensor: str = "all", **more: Any) -> dict[str, Any]:
    """Return the scenario of a fault between sensors and node, under a load that moves."""
    fault = {"kind": kind, "sensor": sensor, "at": BEGIN, "duration": END - BEGIN, **more}
    return _script(load=_MOVING, faults=[fault])


def _there_and_back(quantity: str, lost: float, back: float, over: float) -> dict[str, Any]:
    """Return the scenario of a quantity that is lost, and comes back."""
    return _script(
        events=[
            {"at": BEGIN, quantity: lost, "over": over},
            {"at": END - 0.2, quantity: back, "over": 0.2},
        ]
    )


CASES = (
    Case(
        "tension_sudden",
        "40 % of the tension lost in 0.2 s",
        _there_and_back("tension", 264.0, 440.0, 0.2),
        _TRACTION,
        "",
        1.2,
        _SLIPPING,
        belt=True,
    ),
    Case(
        "tension_slow",
        "36 % of the tension lost in 6 s",
        _script(
            duration=24.0,
            events=[
                {"at": 8.0, "tension": 280.0, "over": 6.0},
                {"at": 17.8, "tension": 440.0, "over": 0.2},
            ],
        ),
        _TRACTION,
        "",
        1.5,
        _SLIPPING,
        begin=11.3,
        end=18.0,
        belt=True,
    ),
    Case(
        "contamination",
        "mu",
        _there_and_back("friction_coefficient", 0.6, 1.18, 0.2),
        _TRACTION,
        "",
        1.2,
        _SLIPPING,
        belt=True,
    ),
    Case(
        "overload",
        "mu",
        _there_and_back("load", 72.0, 20.0, 0.2),
        frozenset({Condition.GROSS_SLIP}),
        "",
        1.2,
        _SLIPPING | _TRACTION,
        belt=True,
    ),
    Case("dropout_all", "", _sensor("dropout"), _STALE, "", 1.5),
    Case("dropout_half", "", _sensor("dropout", share=0.5)),
    Case("dropout_driven_speed", "", _sensor("dropout", "driven_speed"), _STALE, "", 1.5),
    Case("dropout_driver_torque", "", _sensor("dropout", "driver_torque"), _STALE, "", 1.5),
    Case("stuck_driven_speed", "", _sensor("stuck", "driven_speed"), _SENSOR, "", 1.5, _LOST),
    Case("stuck_driven_encoder", "", _sensor("stuck", "driven_encoder"), _SENSOR, "", 1.5, _LOST),
    Case("stuck_driver_torque", "", _sensor("stuck", "driver_torque"), _SENSOR, "", 1.5, _LOST),
    Case("stuck_driven_torque", "", _sensor("stuck", "driven_torque"), _SENSOR, "", 1.5, _LOST),
    Case(
        "spike_speed",
        "",
        _sensor("spike", "driven_speed", value=60.0, duration=0.0),
        counted=Rejection.GATED,
    ),
    Case(
        "spike_torque",
        "",
        _sensor("spike", "driver_torque", value=200.0, duration=0.0),
        counted=Rejection.GATED,
    ),
    Case("spike_small", "", _sensor("spike", "driver_torque", value=20.0, duration=0.0)),
    Case(
        "spikes_many",
        "",
        _sensor("spike", "driven_speed", value=60.0, share=0.1),
        counted=Rejection.GATED,
    ),
    Case(
        "spikes_half",
        "",
        _sensor("spike", "driven_speed", value=2.0, share=0.3),
        _SENSOR,
        "",
        1.5,
        _LOST,
    ),
    Case("quantised_torque", "", _sensor("quantised", "driven_torque", value=1.0)),
    Case("quantised_speed", "", _sensor("quantised", "driven_speed", value=0.05)),
    Case("quantised_coarse", "", _sensor("quantised", "driven_torque", value=5.0)),
    Case("delayed_01", "", _sensor("delayed", value=0.1), counted=Rejection.OUT_OF_ORDER),
    Case(
        "delayed_2",
        "",
        _sensor("delayed", value=2.0),
        _STALE,
        "",
        1.5,
        counted=Rejection.OUT_OF_ORDER,
    ),
    Case(
        "delayed_torque",
        "",
        _sensor("delayed", "driver_torque", value=0.2),
        _SENSOR,
        "",
        1.5,
        _LOST,
    ),
    Case(
        "delayed_speed", "", _sensor("delayed", "driven_speed", value=0.2), _SENSOR, "", 1.5, _LOST
    ),
    Case("reordered", "", _sensor("reordered"), counted=Rejection.OUT_OF_ORDER),
    Case("jump_forward", "", _sensor("time_jump", value=5.0), _STALE, "", 1.5),
    Case("jump_back", "", _sensor("time_jump", value=-5.0), counted=Rejection.OUT_OF_ORDER),
    Case("jump_small", "", _sensor("time_jump", value=-0.5), counted=Rejection.OUT_OF_ORDER),
    Case("sign_driver_torque", "", _sensor("wrong_sign", "driver_torque"), _SENSOR, "", 1.5, _LOST),
    Case("sign_driven_torque", "", _sensor("wrong_sign", "driven_torque"), _SENSOR, "", 1.5, _LOST),
    Case("sign_driver_speed", "", _sensor("wrong_sign", "driver_speed"), _SENSOR, "", 1.5, _LOST),
    Case("sign_driven_speed", "", _sensor("wrong_sign", "driven_speed"), _SENSOR, "", 1.5, _LOST),
)
