"""The first measurement from which a motion can be followed, where sensors speak in turns."""

import math
from dataclasses import replace

from belt_ros.estimation.measurement import Measurement, Sensor

_TOGETHER = 500_000_000  # [ns] by which readings may be apart
_CHANNELS = tuple(sensor.name.lower() for sensor in Sensor)


class FirstReadings:
    """Gather readings until both speeds are known."""

    def __init__(self) -> None:
        self._gathered: list[Measurement] = []

    def gather(self, measurement: Measurement) -> Measurement | None:
        """Return a measurement with both speeds, None while there is none.

        One that lacks a speed gets what it lacks from those that were gathered in the half second
        before it, the latest first.
        """
        if not any(map(math.isnan, measurement.speeds)):
            self._gathered.clear()
            return measurement
        self._forget_before(measurement.stamp_ns)
        whole = measurement
        for earlier in reversed(self._gathered):
            whole = _completed(whole, earlier)
        if any(map(math.isnan, whole.speeds)):
            self._gathered.append(measurement)
            return None
        self._gathered.clear()
        return whole

    def keep(self, measurement: Measurement) -> None:
        """Keep what may complete a later measurement."""
        self._forget_before(measurement.stamp_ns)
        self._gathered.append(measurement)

    def _forget_before(self, stamp_ns: int) -> None:
        self._gathered = [
            earlier
            for earlier in self._gathered
            if stamp_ns - _TOGETHER <= earlier.stamp_ns < stamp_ns
        ]


def _completed(measurement: Measurement, earlier: Measurement) -> Measurement:
    missing = (name for name in _CHANNELS if math.isnan(getattr(measurement, name)))
    return replace(measurement, **{name: getattr(earlier, name) for name in missing})
