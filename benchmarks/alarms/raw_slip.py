"""The alarm that everyone has: speed ratio, low-passed, against a threshold."""

import math

import numpy as np

from belt_ros.estimation import Measurement
from belt_ros.settings import DriveSettings

THRESHOLDS = np.geomspace(1e-4, 0.5, 60)
_MEMORY = 0.2  # [s], the alarms' on-delay


class RawSlip:
    """Slip of the rims as the encoders have it, low-passed, and when it crossed thresholds.

    Parameters
    ----------
    settings : DriveSettings
    since : float
        Crossings count from here on [s].
    """

    def __init__(self, settings: DriveSettings, since: float) -> None:
        self._ratio = settings.drive.driven.radius / settings.drive.driver.radius
        self._since = since
        self._value = 0.0
        self._now = 0.0
        self.greatest = 0.0
        self.crossed = np.full(THRESHOLDS.size, math.nan)

    def take(self, measurement: Measurement) -> None:
        """Take in a measurement."""
        now = measurement.stamp_ns * 1e-9
        if measurement.driver_speed == 0.0:
            return
        slip = 1.0 - self._ratio * measurement.driven_speed / measurement.driver_speed
        self._value -= math.expm1((self._now - now) / _MEMORY) * (slip - self._value)
        self._now = now
        if now >= self._since:
            self.greatest = max(self.greatest, self._value)
            new = np.isnan(self.crossed) & (self._value >= THRESHOLDS)
            self.crossed[new] = now
