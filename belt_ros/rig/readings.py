"""Readings of single pulleys out of what goes out for a drive, each pulley at a rate of its own."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from belt_ros.rig.faults import Report
from belt_ros.rig.sensors import LoadSample

DRIVER, DRIVEN = "driver", "driven"
NO_LOADS = LoadSample(math.nan, math.nan, math.nan)
# Share of a sample period after a sample at which it is decided. Stamps are rounded to whole ns, so
# this is no simple fraction, at which a rate could fall due together with the decision.
_DECIDED = 0.5642


class PulleyReading(NamedTuple):
    """What the sensors of one pulley say, in the terms of its joint. NaN: not measured."""

    stamp_ns: int
    drive: str
    pulley: str  # DRIVER or DRIVEN
    joint: str
    position: float  # [rad]
    speed: float  # [rad/s]
    torque: float
    hub_load: float  # [N]
    span_tension: float  # [N]


class Rates(NamedTuple):
    """Readings per second of either pulley [Hz]."""

    driver: float
    driven: float


def is_due(since_start_ns: int, period_ns: int, rate: float) -> bool:
    """Whether a reading falls due in the sample period that ends `since_start_ns` [ns].

    Of samples every `period_ns`, this leaves `rate` [Hz] a second, that at the start among them,
    and needs no memory: what comes late or in another order is judged by its own stamp.
    """
    decided = since_start_ns + _DECIDED * period_ns
    return math.floor(decided * rate * 1e-9) > math.floor((decided - period_ns) * rate * 1e-9)


def pulley_readings(
    drive: str, report: Report, loads: LoadSample, since_start_ns: int, period_ns: int, rates: Rates
) -> Iterator[PulleyReading]:
    """Yield the readings that are due of one report.

    Parameters
    ----------
    drive : str
    report : Report
    loads : LoadSample
        What the load sensors said when the report was read.
    since_start_ns : int
        Time of the report's stamp since the start of the run [ns].
    period_ns : int
        Time between two samples of the run [ns].
    rates : Rates
    """
    stamp_ns, joints = report
    of_pulleys = (
        (DRIVER, loads.driver_hub_load, math.nan),
        (DRIVEN, loads.driven_hub_load, loads.span_tension),
    )
    for place, (pulley, hub_load, span_tension) in enumerate(of_pulleys):
        if is_due(since_start_ns, period_ns, rates[place]):
            yield PulleyReading(
                stamp_ns,
                drive,
                pulley,
                joints.names[place],
                joints.positions[place],
                joints.velocities[place],
                joints.efforts[place],
                hub_load,
                span_tension,
            )
