"""Faults of the belt: traction lost, too much load; and none, under loads that vary."""

from typing import Any

from belt_ros.estimation import Condition
from benchmarks.faults.cases import (
    BEGIN,
    SLIP,
    TRACTION,
    Case,
    Right,
    demo_script,
    there_and_back,
)

_GROSS = frozenset({Condition.GROSS_SLIP})
_TENSION, _FRICTION, _LOST = 440.0, 1.18, 0.2  # N, -, share of traction that counts as lost
_LOSS = Right("lost after 0.2 s; on-delay of traction 0.5 s, and 0.5 s more", TRACTION, 1.2, SLIP)
_OVERLOAD = Right(
    "slips after 0.2 s; on-delay of gross slip 0.2 s, and 0.5 s more", _GROSS, 0.9, SLIP | TRACTION
)


def _slow_loss(lost: float, over: float) -> Case:
    """Return a loss of tension to `lost` [N] that takes `over` [s], undone thereafter."""
    gone = BEGIN + over + 3.0
    events = [
        {"at": BEGIN, "tension": lost, "over": over},
        {"at": gone - 0.2, "tension": _TENSION, "over": 0.2},
    ]
    return Case(
        f"tension_in_{over:g}_s",
        f"tension from {_TENSION:g} to {lost:g} N in {over:g} s; it counts from the 20 % on at "
        "which traction is lost",
        demo_script(duration=gone + 4.5, events=events),
        Right("on-delay of traction 0.5 s, and 0.5 s more", TRACTION, 1.0, SLIP),
        begin=BEGIN + over * _LOST * _TENSION / (_TENSION - lost),
        end=gone,
    )


def paper_script(**more: Any) -> dict[str, Any]:
    """Return a scenario of the paper's drive; as `demo_script`."""
    script = demo_script(**more)
    return {**script, "condition": {**script["condition"], "friction_stiffness": 6.0e7}}


def conveyor_script(
    load: list[list[float]],
    duration: float,
    *,
    events: list[dict[str, float]] | None = None,
    faults: list[dict[str, Any]] | None = None,
) -> dict[str, Any]:
    """Return a scenario of the conveyor, on which the torque of the tail drum is not measured."""
    unmeasured = {"at": 0.0, "kind": "dropout", "sensor": "driven_torque"}
    return {
        "duration": duration,
        "sample_rate": 50.0,
        "seed": 3,
        "speed": [[0.5, 0.0], [3.5, 5.0]],
        "load": [[0.0, 15.0], [5.0, 15.0], *load],
        "motor": {"bandwidth": 3.0},
        "condition": {
            "tension": 1100.0,
            "friction_coefficient": 0.58,
            "friction_stiffness": 9.0e7,
            "ratio_bias": 4.0e-4,
            "creep_error": 0.01,
        },
        "events": events or [],
        "faults": [unmeasured, *(faults or [])],
    }


GOODS = [[7.0, 60.0], [10.0, 60.0], [12.0, 90.0], [15.0, 90.0], [17.0, 60.0]]

FAULTS = (
    Case(
        "tension_at_once",
        "40 % of the tension lost in 0.2 s",
        demo_script(events=there_and_back("tension", 264.0, _TENSION)),
        _LOSS,
    ),
    Case(
        "tension_at_once_stiff",
        "43 % of the tension lost in 0.2 s: the belt slips",
        paper_script(events=there_and_back("tension", 250.0, _TENSION)),
        _LOSS,
        drive="paper_drive",
    ),
    _slow_loss(264.0, 2.0),
    _slow_loss(264.0, 6.0),
    Case(
        "contamination",
        "mu from 1.18 to 0.5 in 0.2 s",
        demo_script(events=there_and_back("friction_coefficient", 0.5, _FRICTION)),
        _LOSS,
    ),
    Case(
        "contamination_stiff",
        "mu from 1.18 to 0.4 in 0.2 s: the belt slips",
        paper_script(events=there_and_back("friction_coefficient", 0.4, _FRICTION)),
        _LOSS,
        drive="paper_drive",
    ),
    Case(
        "overload",
        "38 to 72 N m, beyond capacity, in 0.2 s",
        demo_script(events=there_and_back("load", 72.0, 20.0)),
        _OVERLOAD,
    ),
    Case(
        "overload_stiff",
        "38 to 75 N m, beyond capacity, in 0.2 s",
        paper_script(events=there_and_back("load", 75.0, 20.0)),
        _OVERLOAD,
        drive="paper_drive",
    ),
    Case(
        "overload_conveyor",
        "60 to 420 N m, beyond capacity, in 1 s; it is over when the drums have swung out on the "
        "elastic belt, which truly slips by more than 1 % until then",
        conveyor_script(
            GOODS,
            30.0,
            events=[
                {"at": 20.0, "load": 420.0, "over": 1.0},
                {"at": 24.0, "load": 60.0, "over": 0.5},
            ],
        ),
        _OVERLOAD._replace(
            why="slips after 1 s; on-delay of gross slip 0.2 s, and 0.5 s more", within=1.7
        ),
        begin=20.0,
        end=26.4,
        drive="conveyor_drive",
    ),
)

_WELL = Right("nothing is wrong")
_LEVELS = (15.0, 38.0, 22.0, 45.0, 8.0, 30.0, 44.0, 12.0, 40.0, 25.0, 45.0)


def _varied(drive: str) -> dict[str, Any]:
    """Return loads that change by steps every other second, up to 70 % of what the belt carries."""
    load = [
        point
        for step, level in enumerate(_LEVELS)
        for point in ([2.2 + 2.0 * step, level], [4.0 + 2.0 * step, level])
    ]
    script = demo_script if drive == "demo_drive" else paper_script
    return script(load=[[2.0, 0.0], *load], duration=24.0)


_CROSSINGS = [
    *([2.0, 0.0], [2.2, 15.0], [3.2, 15.0], [3.4, 42.0], [4.6, 42.0], [4.8, 25.0], [7.0, 25.0]),
    *([7.5, 55.0], [9.5, 55.0], [10.0, 20.0], [13.0, 20.0]),  # below the warning, above the alarm
    *([14.0, 62.0], [16.0, 62.0], [16.5, 20.0], [19.5, 20.0]),  # below the alarm
    *([21.0, 72.0], [22.0, 72.0], [22.3, 20.0], [26.5, 20.0]),  # gross slip
]
_CROSSED = Right("each margin that is crossed, see below", TRACTION, 1.0, SLIP)


def _crossings(drive: str) -> dict[str, Any]:
    """Return loads that cross every threshold of the margin."""
    script = demo_script if drive == "demo_drive" else paper_script
    return script(load=_CROSSINGS, duration=26.5)


LOADS = (
    *(
        Case(
            f"varied_load_{drive}",
            "load varies up to 70 % of capacity",
            _varied(drive),
            _WELL,
            drive=drive,
        )
        for drive in ("demo_drive", "paper_drive")
    ),
    Case(
        "varied_load_conveyor_drive",
        "goods come and go",
        conveyor_script([*GOODS, [19.0, 30.0], [21.0, 110.0]], 24.0),
        _WELL,
        drive="conveyor_drive",
    ),
    *(
        Case(
            f"crossings_{drive}",
            "load crosses warning, alarm and capacity",
            _crossings(drive),
            _CROSSED,
            begin=7.4,
            end=22.3,
            drive=drive,
        )
        for drive in ("demo_drive", "paper_drive")
    ),
)
