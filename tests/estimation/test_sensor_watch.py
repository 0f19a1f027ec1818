"""Signs that a sensor is not to be believed, in words."""

import dataclasses

import numpy as np

from belt_ros.estimation import AlarmSettings
from belt_ros.estimation.condition import Evidence
from belt_ros.estimation.sensor_watch import SensorWatch
from belt_ros.estimation.state import Index

STRICT = dataclasses.replace(AlarmSettings(), implausible_misfit=2.0)  # the least there is
SEEN = np.array([Index.DRIVER_SPEED, Index.DRIVEN_TORQUE])


def seeing(watch: SensorWatch, speed: float, torque: float) -> SensorWatch:
    """Two seconds of squared surprises."""
    for _ in range(200):
        watch.see(SEEN, np.array([speed, torque]), 0.01)
    return watch


def test_the_sensor_named_is_the_worst_of_those_that_are_read() -> None:
    watch = seeing(SensorWatch(), 0.1, 1.3)
    assert "shows in the driven torque" in watch.reason(STRICT)
    assert "shows in the driver speed" in seeing(watch, 9.0, 0.1).reason(STRICT)


def test_sensors_that_nobody_has_do_not_keep_the_condition_up() -> None:
    watch = seeing(SensorWatch(), 9.0, 0.1)
    assert watch.evidence(STRICT) is Evidence.MET
    assert seeing(watch, 0.3, 0.5).evidence(STRICT) is Evidence.GONE


def test_before_anything_is_seen_nothing_is_wrong() -> None:
    watch = SensorWatch()
    watch.see(np.array([], dtype=np.int64), np.array([]), 0.01)
    assert watch.evidence(AlarmSettings()) is Evidence.GONE
    assert watch.reason(AlarmSettings()) == "its readings fit again"
