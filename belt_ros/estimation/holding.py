"""What is held for a while may meanwhile have become another: by how much, is told with it."""

import math
from dataclasses import replace

from belt_ros.estimation.estimate import BeltEstimate, Quantity

_SECONDS = 1e-9
_APART = 0.1  # [s] between two estimates that are told from each other


class Pace:
    """How fast speeds and torque seem to change, from one estimate to the next."""

    def __init__(self) -> None:
        self._stamp_ns: int | None = None
        self._values = (0.0, 0.0, 0.0)
        self._paces = (0.0, 0.0, 0.0)

    def see(self, estimate: BeltEstimate, stamp_ns: int) -> None:
        """See what has been known at `stamp_ns` [ns]."""
        values = (
            estimate.driver_speed.value,
            estimate.driven_speed.value,
            estimate.transmitted_torque.value,
        )
        if self._stamp_ns is not None:
            apart = max((stamp_ns - self._stamp_ns) * _SECONDS, _APART)
            changes = zip(values, self._values, strict=True)
            first, second, third = (abs(now - before) / apart for now, before in changes)
            self._paces = first, second, third
        self._stamp_ns, self._values = stamp_ns, values

    def held(self, estimate: BeltEstimate, age: float, creep_wander: float) -> BeltEstimate:
        """Return an estimate that is `age` [s] old, as uncertain as it has become.

        `creep_wander` is that of creep at a steady load, relative [1/sqrt(s)].
        """
        driver, driven, torque = (pace * age for pace in self._paces)
        creep = creep_wander * math.sqrt(age) * estimate.predicted_creep.value
        return replace(
            estimate,
            driver_speed=_widened(estimate.driver_speed, driver),
            driven_speed=_widened(estimate.driven_speed, driven),
            transmitted_torque=_widened(estimate.transmitted_torque, torque),
            slip=_widened(estimate.slip, creep),
        )


def _widened(quantity: Quantity, by: float) -> Quantity:
    return Quantity(quantity.value, math.hypot(quantity.stddev, by))
