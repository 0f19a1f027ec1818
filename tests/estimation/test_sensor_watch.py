"""Signs that a sensor is not to be believed, in words."""

import dataclasses

import numpy as np

from belt_ros.estimation import AlarmSettings
from belt_ros.estimation.sensor_watch import SensorWatch
from belt_ros.estimation.state import Index

# The least there is: a state that no sensor reads, whose misfit stays 1, is not below half of it.
STRICT = dataclasses.replace(AlarmSettings(), implausible_misfit=2.0)


def test_the_sensor_named_is_one_that_is_read_however_low_the_threshold() -> None:
    watch = SensorWatch()
    for _ in range(200):
        watch.see(np.array([Index.DRIVER_SPEED, Index.DRIVEN_TORQUE]), np.array([0.1, 0.9]), 0.01)
    assert "shows in the" in watch.reason(STRICT)
    for _ in range(200):
        watch.see(np.array([Index.DRIVER_SPEED, Index.DRIVEN_TORQUE]), np.array([0.1, 9.0]), 0.01)
    assert "shows in the driven torque" in watch.reason(STRICT)
