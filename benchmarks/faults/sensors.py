"""Faults of sensors, and of the way from them, under a load that moves."""

from typing import Any

from belt_ros.estimation import Condition, Rejection
from benchmarks.faults.belt import GOODS, conveyor_script
from benchmarks.faults.cases import BEGIN, END, MOVING, Case, Right, demo_script

_STALE = frozenset({Condition.SENSOR_STALE})
_DOUBTED = frozenset({Condition.SENSOR_IMPLAUSIBLE, Condition.ESTIMATOR_LOST})

_SILENT = Right("limits.greatest_gap 1 s, and 0.5 s more", _STALE, 1.5)
_IMPOSSIBLE = Right(
    "every sample is impossible: on-delay of an implausible sensor 0.2 s, half its memory of 0.5 s "
    "and 0.5 s more",
    _DOUBTED,
    1.0,
)
_MISFIT = Right(
    "shows only as the load moves: at the latest the estimator is lost, on-delay 2 s, and 0.5 s "
    "more",
    _DOUBTED,
    2.5,
)
_ALONE = Right("one sample says nothing: it is turned away", counted=Rejection.GATED)
_LATE = Right("used or turned away by their stamps", counted=Rejection.OUT_OF_ORDER)


def _case(name: str, what: str, right: Right, kind: str, sensor: str = "all", **more: Any) -> Case:
    """Return a fault of the demonstration's drive, from `BEGIN` to `END` where not said else."""
    fault = {"kind": kind, "sensor": sensor, "at": BEGIN, "duration": END - BEGIN, **more}
    return Case(name, what, demo_script(MOVING, faults=[fault]), right)


def _on_conveyor(name: str, what: str, right: Right, kind: str, sensor: str) -> Case:
    """Return a fault of the conveyor, under a load that moves."""
    fault = {"kind": kind, "sensor": sensor, "at": 20.0, "duration": 3.0}
    load = [*GOODS, [20.0, 60.0], [21.0, 90.0], [22.0, 60.0], [23.0, 90.0]]
    script = conveyor_script(load, 28.0, faults=[fault])
    return Case(name, what, script, right, begin=20.0, end=23.0, drive="conveyor_drive")


_FOR_GOOD = 1e3  # [s]: to the end of the run

FAULTS = (
    _case("dropout_all", "no joint state comes", _SILENT, "dropout"),
    _case(
        "dropout_half",
        "every other joint state is lost",
        Right("what comes is enough"),
        "dropout",
        share=0.5,
    ),
    *(
        _case(f"dropout_{sensor}", "NaN", _SILENT, "dropout", sensor)
        for sensor in ("driven_speed", "driver_torque")
    ),
    _on_conveyor(
        "dropout_conveyor", "tail drum's encoder: NaN", _SILENT, "dropout", "driven_encoder"
    ),
    *(
        _case(f"stuck_{sensor}", "says what it said", _MISFIT, "stuck", sensor)
        for sensor in ("driven_speed", "driven_encoder", "driver_torque", "driven_torque")
    ),
    _on_conveyor("stuck_conveyor", "tail drum's encoder", _MISFIT, "stuck", "driven_encoder"),
    _case(
        "spike_speed",
        "one sample, 60 rad/s off",
        _ALONE,
        "spike",
        "driven_speed",
        value=60.0,
        duration=0.0,
    ),
    _case(
        "spike_torque",
        "one sample, 200 N m off",
        _ALONE,
        "spike",
        "driver_torque",
        value=200.0,
        duration=0.0,
    ),
    _case(
        "spikes",
        "a tenth of the samples, 60 rad/s off",
        _ALONE._replace(why="below half of the samples: turned away"),
        "spike",
        "driven_speed",
        value=60.0,
        share=0.1,
    ),
    _case(
        "spikes_small",
        "three samples in ten, 2 rad/s off",
        _MISFIT,
        "spike",
        "driven_speed",
        value=2.0,
        share=0.3,
    ),
    _case(
        "quantised_torque",
        "steps of 1 N m, thrice the noise",
        Right("within what the estimator allows for"),
        "quantised",
        "driven_torque",
        value=1.0,
    ),
    _case(
        "quantised_speed",
        "steps of 0.05 rad/s, thrice the noise",
        Right("within what the estimator allows for"),
        "quantised",
        "driven_speed",
        value=0.05,
    ),
    _case("delayed", "joint states 0.1 s late", _LATE, "delayed", value=0.1),
    _case(
        "delayed_long",
        "joint states 2 s late, until the late ones are through",
        _SILENT._replace(counted=Rejection.OUT_OF_ORDER),
        "delayed",
        value=2.0,
    )._replace(end=END + 2.0),
    *(
        _case(f"delayed_{sensor}", "0.2 s late", _MISFIT, "delayed", sensor, value=0.2)
        for sensor in ("driven_speed", "driver_torque")
    ),
    _case("reordered", "of two joint states the later comes first", _LATE, "reordered"),
    _case(
        "jump_ahead",
        "stamps 5 s ahead from then on",
        Right(
            "three stamps to believe it, 0.5 s more: time passed without measurements", _STALE, 0.6
        ),
        "time_jump",
        value=5.0,
        duration=_FOR_GOOD,
    )._replace(end=BEGIN),
    _case(
        "jump_back",
        "stamps 5 s back from then on, as of a bag that begins again",
        Right("one new beginning", counted=Rejection.OUT_OF_ORDER, resets=1),
        "time_jump",
        value=-5.0,
        duration=_FOR_GOOD,
    ),
    _case(
        "jump_short",
        "stamps 0.5 s back, and on again after 3 s",
        Right("less than a gap: waits until time has caught up", counted=Rejection.OUT_OF_ORDER),
        "time_jump",
        value=-0.5,
    ),
    *(
        _case(f"sign_{sensor}", "wrong sign", _IMPOSSIBLE, "wrong_sign", sensor)
        for sensor in ("driver_torque", "driven_torque", "driver_speed", "driven_speed")
    ),
    _on_conveyor(
        "sign_conveyor", "motor current: wrong sign", _IMPOSSIBLE, "wrong_sign", "driver_torque"
    ),
)
