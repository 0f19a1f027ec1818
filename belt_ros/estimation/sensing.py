"""Measurements as the filter takes them in: values, variances, and the states that they read."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.assumptions import SensorNoise
from belt_ros.estimation.measurement import Measurement, Sensor, sensor_variances
from belt_ros.estimation.state import Index
from belt_ros.estimation.torque_told import Torques
from belt_ros.estimation.travel import Travel
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
_TORQUES = np.array([Index.DRIVER_TORQUE, Index.DRIVEN_TORQUE + 1])
_TRAVEL = 4  # place in `_PLACES`, and that of the driver's position among the sensors
_POSITIONS = slice(Sensor.DRIVER_POSITION, Sensor.DRIVEN_POSITION + 1)
_AVERAGED = Sensor.DRIVER_POSITION  # sensors before this one: the error of a mean is less
_LOADS = slice(Sensor.DRIVER_HUB_LOAD, Sensor.SPAN_TENSION + 1)
# Load cells err in gain and zero rather than from sample to sample, so not every sample counts,
# and a mean is no better than one.
_BETWEEN_LOADS = 1.0  # [s]
LOADS = 3
NO_LOADS = np.full(LOADS, math.nan)


class Sensed(NamedTuple):
    """One measurement: every sensor, NaN where there is none, and what is there of the states."""

    values: _Floats  # (9,) in the order of `Sensor`
    variances: _Floats  # (9,); of positions, also where there is none
    z: _Floats  # (m,)
    variance: _Floats  # (m,)
    places: NDArray[np.int64]  # (m,) in the state
    loads: _Floats  # (3,) hub loads and span tension, NaN where none is to be taken in [N]
    load_variances: _Floats  # (3,)
    change: float = math.nan  # see `Measurement`

    @property
    def torques(self) -> Torques:
        """Readings of the torques."""
        begin, end = np.searchsorted(self.places, _TORQUES)  # places ascend
        return Torques(self.z[begin:end], self.variance[begin:end], self.places[begin:end])

    def part(self, begin: int, end: int | None) -> "Sensed":
        """Return this with only some of the readings of states."""
        some = slice(begin, end)
        return self._replace(z=self.z[some], variance=self.variance[some], places=self.places[some])


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

    Counts the travel, and keeps when each load was last taken in.

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
        self._travel = Travel(constants, turns)
        self.retune(noise)
        self.start()

    def retune(self, noise: SensorNoise) -> None:
        """Go on with other noise."""
        self._noise = noise.noise_rows()

    def start(self) -> None:
        """Begin anew: angles count from the next reading on, loads are taken in at once."""
        self._travel.start()
        self._since_loads = np.full(LOADS, math.inf)

    def ask_for_load(self, load: int) -> None:
        """Take a load in again with its next reading."""
        self._since_loads[load] = math.inf

    def lose_travel(self) -> None:
        """Count angles anew from the next reading on."""
        self._travel.start()

    @property
    def counts_travel(self) -> bool:
        """Whether the angles of both pulleys are known since an earlier measurement."""
        return self._travel.counts

    def sense(self, measurement: Measurement, dt: float) -> Sensed:
        """Return what was sensed `dt` [s] after the measurement before."""
        values = measurement.values()
        variances = sensor_variances(values, self._noise)
        if measurement.samples:
            variances[:_AVERAGED] /= measurement.samples[:_AVERAGED]
        variances[_POSITIONS] = self._noise[1, _POSITIONS]  # also of one that came a little before
        if measurement.bending:
            variances += measurement.bending
        travel = self._travel.ahead(measurement.speeds, measurement.positions, dt)
        self._since_loads += dt
        loads = NO_LOADS
        if not all(map(math.isnan, measurement.loads)):
            due = (self._since_loads >= _BETWEEN_LOADS) & ~np.isnan(values[_LOADS])
            if np.any(due):
                self._since_loads[due] = 0.0
                loads = np.where(due, values[_LOADS], math.nan)
        return Sensed(
            values,
            variances,
            *_there(self._constants, values, variances, travel),
            loads,
            variances[_LOADS],
            measurement.change,
        )
