"""Rim travel lost by slip, added up."""

from belt_ros.estimation.estimate import Quantity


class LostTravel:
    """Integral of the slip speed over time."""

    def __init__(self) -> None:
        self._lost = 0.0  # [m]
        self._deviation = 0.0

    def advance(self, slip_speed: Quantity, dt: float) -> None:
        """Add what is lost in `dt` [s] at a slip speed [m/s]."""
        self._lost += slip_speed.value * dt
        # Most of its error is the ratio bias, which is the same all along.
        self._deviation += slip_speed.stddev * dt

    @property
    def total(self) -> Quantity:
        """Rim travel lost so far [m]."""
        return Quantity(self._lost, self._deviation)
