"""Measurements as the filter takes them in: values, variances, and the states that they read."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.assumptions import SensorNoise
from belt_ros.estimation.measurement import Measurement, Sensor, sensor_variances
from belt_ros.estimation.state import Index
from belt_ros.estimation.travel import Travel
from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants

_Floats = NDArray[np.float64]
# Compiled code wants plain integers.
_PLACES = (
    int(Index.DRIVER_SPEED),
    int(Index.DRIVEN_SPEED),
    int(Index.DRIVER_TORQUE),
    int(Index.DRIVEN_TORQUE),
    int(Index.TRAVEL),
)
_READ = len(_PLACES)
_TRAVEL = 4  # place in `_PLACES`; those before are also places among the sensors
_DRIVER_POSITION, _DRIVEN_POSITION = int(Sensor.DRIVER_POSITION), int(Sensor.DRIVEN_POSITION)
_AVERAGED = _DRIVER_POSITION  # sensors before this one: the error of a mean is less
_LOADS = slice(Sensor.DRIVER_HUB_LOAD, Sensor.SPAN_TENSION + 1)
# Load cells err in gain and zero rather than from sample to sample, so not every sample counts,
# and a mean is no better than one.
_BETWEEN_LOADS = 1.0  # [s]
LOADS = 3
NO_LOADS = np.full(LOADS, math.nan)
_NOTHING = np.zeros(0)


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
    def states(self) -> tuple[_Floats, _Floats, NDArray[np.int64]]:
        """Readings of states, their variances and places (m,)."""
        return self.z, self.variance, self.places

    def part(self, begin: int, end: int | None) -> "Sensed":
        """Return this with only some of the readings of states."""
        some = slice(begin, end)
        return self._replace(z=self.z[some], variance=self.variance[some], places=self.places[some])


@compiled
def _read(
    values: _Floats,
    noise: _Floats,
    samples: _Floats,
    bending: _Floats,
    radii: tuple[float, float],
    travel: float,
) -> tuple[_Floats, _Floats, _Floats, NDArray[np.int64]]:
    """Return variances of what was measured; of the states read, readings, variances and places."""
    variances = sensor_variances(values, noise)
    for i in range(variances.size):
        if i < _AVERAGED and samples.size > 0:
            variances[i] /= samples[i]
        if _DRIVER_POSITION <= i <= _DRIVEN_POSITION:
            variances[i] = noise[1, i]  # also of one that came a little before
        if bending.size > 0:
            variances[i] += bending[i]
    z, variance, places = np.empty(_READ), np.empty(_READ), np.empty(_READ, dtype=np.int64)
    count = 0
    for i in range(_READ):
        reading, own = travel, 0.0
        if i < _TRAVEL:
            reading, own = values[i], variances[i]
        else:
            for pulley in range(2):
                own += radii[pulley] ** 2 * variances[_DRIVER_POSITION + pulley]
        if not math.isnan(reading):
            z[count], variance[count], places[count] = reading, own, _PLACES[i]
            count += 1
    return variances, z[:count], variance[:count], places[:count]


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
        self._radii = constants.driver_radius, constants.driven_radius
        self._travel = Travel(constants, turns)
        self.retune(noise)
        self.start()

    def retune(self, noise: SensorNoise) -> None:
        """Go on with other noise."""
        self._noise = noise.noise_rows()

    def start(self) -> None:
        """Begin anew: angles count from the next reading on, loads are taken in at once."""
        self._travel.start()
        self._since_loads = [math.inf] * LOADS

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
        travel = self._travel.ahead(measurement.speeds, measurement.positions, dt)
        variances, z, variance, places = _read(
            values,
            self._noise,
            np.array(measurement.samples) if measurement.samples else _NOTHING,
            np.array(measurement.bending) if measurement.bending else _NOTHING,
            self._radii,
            travel,
        )
        self._since_loads = [since + dt for since in self._since_loads]
        loads = NO_LOADS
        for load, reading in enumerate(measurement.loads):
            if self._since_loads[load] >= _BETWEEN_LOADS and not math.isnan(reading):
                self._since_loads[load] = 0.0
                loads = loads.copy() if loads is NO_LOADS else loads
                loads[load] = reading
        return Sensed(
            values, variances, z, variance, places, loads, variances[_LOADS], measurement.change
        )
