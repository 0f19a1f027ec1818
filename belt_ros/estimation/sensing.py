"""Measurements as the filter takes them in: values, variances, and the states that they read."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.assumptions import SensorNoise
from belt_ros.estimation.measurement import Measurement, Sensor, sensor_variances, unwrapped
from belt_ros.estimation.state import Index
from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants

_Floats = NDArray[np.float64]
_PLACES = np.array(
    [
        Index.DRIVER_SPEED,
        Index.DRIVEN_SPEED,
        Index.DRIVER_TORQUE,
        Index.DRIVEN_TORQUE,
        Index.TRAVEL,
    ],
    dtype=np.int64,
)
_TRAVEL = 4  # place in `_PLACES`, and that of the driver's position among the sensors
_LOADS = slice(Sensor.DRIVER_HUB_LOAD, Sensor.SPAN_TENSION + 1)
# Load cells err in gain and zero rather than from sample to sample, so not every sample counts.
_BETWEEN_LOADS = 1.0  # [s]
_NOWHERE = math.nan, math.nan
NO_LOADS = np.full(3, math.nan)


class Sensed(NamedTuple):
    """One measurement: every sensor, NaN where there is none, and what is there of the states."""

    values: _Floats  # (9,) in the order of `Sensor`
    variances: _Floats  # (9,)
    z: _Floats  # (m,)
    variance: _Floats  # (m,)
    places: NDArray[np.int64]  # (m,) in the state
    loads: _Floats  # (3,) hub loads and span tension, NaN where none is to be taken in [N]
    load_variances: _Floats  # (3,)


@compiled
def _there(
    c: DriveConstants, values: _Floats, variances: _Floats, travel: float
) -> tuple[_Floats, _Floats, NDArray[np.int64]]:
    """Return the readings of states that are there, their variances and places."""
    z, variance = np.empty(_PLACES.size), np.empty(_PLACES.size)
    z[:_TRAVEL], variance[:_TRAVEL] = values[:_TRAVEL], variances[:_TRAVEL]
    z[_TRAVEL] = travel
    variance[_TRAVEL] = (
        c.driver_radius**2 * variances[_TRAVEL] + c.driven_radius**2 * variances[_TRAVEL + 1]
    )
    there = np.flatnonzero(~np.isnan(z))
    return z[there], variance[there], _PLACES[there]


class Sensing:
    """Turn measurements into readings of the state.

    Keeps the angles that encoders wrap, and when loads were last taken in.

    Parameters
    ----------
    constants : DriveConstants
    noise : SensorNoise
    turns : tuple of float
        One turn of either joint, seen at its pulley [rad], see `Joint.turn`.
    """

    def __init__(
        self, constants: DriveConstants, noise: SensorNoise, turns: tuple[float, float]
    ) -> None:
        self._constants = constants
        self._turns = turns
        self.retune(noise)
        self.start()

    def retune(self, noise: SensorNoise) -> None:
        """Go on with other noise."""
        self._noise = noise.noise_rows()

    def start(self) -> None:
        """Begin anew: angles count from the next reading on, loads are taken in at once."""
        self._angles = self._first = self._speeds = _NOWHERE
        self._since_loads = math.inf

    def ask_for_loads(self) -> None:
        """Take loads in again with the next measurement."""
        self._since_loads = math.inf

    def lose_travel(self) -> None:
        """Count angles anew from the next reading on."""
        self._angles = _NOWHERE

    @property
    def counts_travel(self) -> bool:
        """Whether the angles of both pulleys are known since an earlier measurement."""
        return not math.isnan(self._angles[0])

    def sense(self, measurement: Measurement, dt: float) -> Sensed:
        """Return what was sensed `dt` [s] after the measurement before."""
        values = measurement.values()
        variances = sensor_variances(values, self._noise)
        travel = self._travel(measurement, dt)
        self._since_loads += dt
        loads = NO_LOADS
        if self._since_loads >= _BETWEEN_LOADS and not all(map(math.isnan, measurement.loads)):
            self._since_loads = 0.0
            loads = values[_LOADS]
        return Sensed(
            values,
            variances,
            *_there(self._constants, values, variances, travel),
            loads,
            variances[_LOADS],
        )

    def _travel(self, measurement: Measurement, dt: float) -> float:
        """Rim travel that the driver is ahead since angles are counted [m]; NaN without both."""
        speeds, now = measurement.speeds, measurement.positions
        before, speeds_before = self._angles, self._speeds
        self._speeds = speeds
        if math.isnan(sum(speeds) + sum(now)):
            self._angles = _NOWHERE
            return math.nan
        if not self.counts_travel:
            self._angles = self._first = now
            return math.nan
        turned = [
            unwrapped(before[i], now[i], 0.5 * dt * (speeds_before[i] + speeds[i]), self._turns[i])
            for i in range(2)
        ]
        self._angles = turned[0], turned[1]
        c = self._constants
        driver = c.driver_radius * (turned[0] - self._first[0])
        return driver - c.driven_radius * (turned[1] - self._first[1])
