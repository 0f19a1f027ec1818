"""What is done without an estimator: a filtered speed ratio, and Euler-Eytelwein's capacity.

The tension is what the maintenance sheet says. None of it has an error bar, so errors alone count.
"""

import math

from belt_ros.estimation import Measurement, Quantity
from belt_ros.mechanics import torque_capacity
from belt_ros.settings import DriveSettings
from benchmarks.estimation.judged import QUANTITIES, Quantities

_MEMORY = 0.3  # [s] of the low-pass


class Today:
    """Low-passed slip and torque; tensions and margin by what the maintenance sheet says."""

    def __init__(self, settings: DriveSettings) -> None:
        self._settings = settings
        self._stamp_ns: int | None = None
        self._slip = 0.0
        self._torque = 0.0
        self._speed = 0.0

    def step(self, measurement: Measurement) -> None:
        """Take in a measurement."""
        dt = 0.0 if self._stamp_ns is None else (measurement.stamp_ns - self._stamp_ns) * 1e-9
        self._stamp_ns = measurement.stamp_ns
        drive = self._settings.drive
        driver = drive.driver.radius * measurement.driver_speed
        driven = drive.driven.radius * measurement.driven_speed
        new = -math.expm1(-dt / _MEMORY)
        slip = 1.0 - driven / driver if abs(driver) > 0.1 else 0.0
        self._slip += new * (slip - self._slip)
        self._torque += new * (-measurement.driven_torque - self._torque)
        self._speed = measurement.driver_speed

    def quantities(self) -> Quantities:
        """Return what is known now."""
        drive, prior = self._settings.drive, self._settings.prior
        pull = self._torque / drive.driven.radius
        capacity = float(torque_capacity(drive, prior.tension, self._speed))
        values = dict.fromkeys(QUANTITIES, math.nan)
        values["slip"] = self._slip
        values["tight_tension"] = prior.tension + 0.5 * pull
        values["slack_tension"] = prior.tension - 0.5 * pull
        values["margin"] = 1.0 - abs(self._torque) / capacity
        return {name: Quantity(value, math.nan) for name, value in values.items()}
