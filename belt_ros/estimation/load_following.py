"""How lively the load is in every step: what the sensors say of it, taken to `load.LoadWander`."""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.load import Activity, LoadWander
from belt_ros.estimation.measurement import Sensor
from belt_ros.estimation.process import Wander
from belt_ros.estimation.sensing import Sensed
from belt_ros.estimation.state import Index, slip_per_pull
from belt_ros.mechanics.constants import DriveConstants

_Floats = NDArray[np.float64]
_SLOW = 0.1  # rim speed [m/s] below which the slip's wander no longer shrinks with it
_TORQUES = slice(Sensor.DRIVER_TORQUE, Sensor.DRIVEN_TORQUE + 1)


class LoadFollowing:
    """Follow torques and slip speed, also where they come in separate measurements.

    The slip speed is told whenever both speeds have been read anew.

    Attributes
    ----------
    slip_per_pull : float
        Of steady creep [1/N] by the state last followed from, at least the belt's own strain.
    """

    def __init__(self, constants: DriveConstants) -> None:
        self._constants = constants
        self._wander = LoadWander()
        self.slip_per_pull = 1.0 / constants.axial_stiffness
        self.start()

    def start(self) -> None:
        """Forget all signals, as before the first reading."""
        self._wander.start()
        self._rims = np.full(2, math.nan)  # speeds last read and not yet used [m/s] ...
        self._variances = np.zeros(2)  # ... and their variances

    def follow(
        self, sensed: Sensed, state: _Floats, wander: Wander, dt: float, *, unforeseen: bool
    ) -> Activity:
        """Take in what was sensed at the end of a step of `dt` [s], from a state (12,) on.

        `unforeseen`: slip has not been what was foretold, see `LoadWander.follow`.

        Returns
        -------
        Activity
            Of the load, see `LoadWander.follow`.
        """
        c = self._constants
        ahead, variance = self._ahead(sensed)
        rim = max(c.driver_radius * abs(float(state[Index.DRIVER_SPEED])), _SLOW)
        self.slip_per_pull = slip_per_pull(c, state)
        slip = rim * self.slip_per_pull * wander.load
        torques, noise = sensed.values[_TORQUES], sensed.variances[_TORQUES]
        return self._wander.follow(
            np.array((*torques, ahead)),
            np.array((*noise, variance)),
            np.array((wander.load * c.driver_radius, wander.load * c.driven_radius, slip)),
            np.array((0.0, 0.0, wander.creep * abs(ahead))),
            dt,
            unforeseen=unforeseen,
        )

    def _ahead(self, sensed: Sensed) -> tuple[float, float]:
        """By how much the driver's rim is faster [m/s], and its variance; NaN if not told."""
        c = self._constants
        for pulley, radius in enumerate((c.driver_radius, c.driven_radius)):
            if not math.isnan(sensed.values[pulley]):
                self._rims[pulley] = radius * sensed.values[pulley]
                self._variances[pulley] = radius**2 * sensed.variances[pulley]
        ahead = float(self._rims[0] - self._rims[1])
        if not math.isnan(ahead):
            self._rims[:] = math.nan
        return ahead, float(self._variances[0] + self._variances[1])
