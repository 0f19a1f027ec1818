"""What joints report, each for itself, as quantities at the pulleys."""

import math

from belt_ros.estimation.assumptions import Joint
from belt_ros.estimation.measurement import Measurement


def _known(joint: Joint, speed: float, last: float) -> float:
    """Return the pulley speed to take a joint's drag at; NaN if it is needed and not known."""
    if math.isfinite(speed):
        return speed
    no_drag = joint.drag_torque == 0.0 and joint.drag_damping == 0.0
    return 0.0 if no_drag else last


class JointReadings:
    """Turn readings of the two joints into measurements at the pulleys, in order of their stamps.

    The same as `measurement_from_joints` does, where each quantity may come by itself: a torque
    without its speed loses the bearings' drag at the last speed known, and is not measured as long
    as none is.
    """

    def __init__(self, driver: Joint, driven: Joint) -> None:
        self._driver = driver
        self._driven = driven
        self._driver_speed = self._driven_speed = math.nan

    def at_pulleys(self, read: Measurement) -> Measurement:
        """Return what was measured at the pulleys.

        Parameters
        ----------
        read : Measurement
            Speeds, torques (efforts) and positions as the joints report them; loads in newtons.
        """
        driver, driven = self._driver, self._driven
        driver_speed = driver.pulley_speed(read.driver_speed)
        driven_speed = driven.pulley_speed(read.driven_speed)
        self._driver_speed = _known(driver, driver_speed, self._driver_speed)
        self._driven_speed = _known(driven, driven_speed, self._driven_speed)
        return Measurement(
            read.stamp_ns,
            driver_speed,
            driven_speed,
            driver.pulley_torque(read.driver_torque, self._driver_speed),
            driven.pulley_torque(read.driven_torque, self._driven_speed),
            driver.pulley_position(read.driver_position),
            driven.pulley_position(read.driven_position),
            read.driver_hub_load,
            read.driven_hub_load,
            read.span_tension,
        )
