"""Compile what a drive may need before it needs it: some of it takes seconds, and not at once."""

import dataclasses
import math
import time
from collections.abc import Iterator

from belt_ros.estimation import Maintenance, MaintenanceKind, Measurement, SensorLimits
from belt_ros.settings import DriveSettings

_SAMPLES, _BEFORE_PAUSE = 45, 30
_PAUSE_NS = 10_000_000_000
_INTERVAL_NS = 20_000_000
_SPEED = 1.0  # [rad/s]
_SHARE = 0.1  # of a probability


def warm_up(settings: DriveSettings) -> float:
    """Run a drive with all sensors that there are; return the seconds it took."""
    began = time.monotonic()
    # With limits of its own: those of the drive may turn this measurement or that away.
    monitor = dataclasses.replace(settings, limits=SensorLimits()).monitor()
    for measurement in _measurements(settings.prior.tension):
        monitor.step(measurement)
    monitor.gross_slip_probability_at(monitor.load_at_probability(_SHARE))
    tension = settings.prior.tension
    monitor.maintain(Maintenance(MaintenanceKind.TENSION_MEASURED, tension, _SHARE * tension))
    return time.monotonic() - began


def _measurements(tension: float) -> Iterator[Measurement]:
    """Yield those of a drive that is loaded and turns without slip, and pauses once."""
    for sample in range(_SAMPLES):
        turned = _SPEED * sample * _INTERVAL_NS * 1e-9
        paused_ns = _PAUSE_NS if sample >= _BEFORE_PAUSE else 0
        torque = _SHARE * math.sin(sample)
        yield Measurement(
            (1 + sample) * _INTERVAL_NS + paused_ns,
            *(_SPEED, _SPEED, torque, -torque, turned, turned),
            driver_hub_load=2.0 * tension,
            driven_hub_load=2.0 * tension,
            span_tension=tension,
        )
