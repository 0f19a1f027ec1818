"""Both speeds at one time, also where the pulleys speak in turns."""

import math
from dataclasses import replace

from belt_ros.estimation.measurement import Measurement

_LONGEST = 1_000_000_000  # [ns] between two readings of a speed that is interpolated


class SpeedPairs:
    """Brings both speeds of a drive to the same stamp.

    A driver speed that comes alone gets the driven speed between the readings before and after it,
    so that a rotation that gets steadily faster, or slower, does not look like another ratio.
    """

    def __init__(self) -> None:
        self._driven: Measurement | None = None  # the last one with that speed alone
        self._driver: Measurement | None = None  # one that came since

    def take(self, measurement: Measurement) -> Measurement | None:
        """Take in a measurement; return one with both speeds, as soon as there is one.

        It is `measurement`, or an earlier one completed by it. None that has neither speed counts.
        """
        driver, driven = (not math.isnan(speed) for speed in measurement.speeds)
        if driver and driven:
            self._driver = self._driven = None
            return measurement
        if driver:
            self._driver = measurement
        if not driven:
            return None
        before, self._driven = self._driven, measurement
        between, self._driver = self._driver, None
        if before is None or between is None:
            return None
        return _completed(between, before, measurement)


def _completed(between: Measurement, before: Measurement, after: Measurement) -> Measurement | None:
    """Return `between` with the driven speed of its time, and the torque that came beside that."""
    length = after.stamp_ns - before.stamp_ns
    if not (0 < length <= _LONGEST and before.stamp_ns <= between.stamp_ns <= after.stamp_ns):
        return None
    share = (between.stamp_ns - before.stamp_ns) / length
    speed = before.driven_speed + share * (after.driven_speed - before.driven_speed)
    torque = between.driven_torque
    return replace(
        between,
        driven_speed=speed,
        driven_torque=after.driven_torque if math.isnan(torque) else torque,
        samples=_samples(between, after),
    )


def _samples(between: Measurement, after: Measurement) -> tuple[float, ...]:
    """Of how many each reading is the mean; of none where that is one."""
    one = (1.0,) * len(between.samples or after.samples)
    pairs = zip(between.samples or one, after.samples or one, strict=True)
    return tuple(max(pair) for pair in pairs)
