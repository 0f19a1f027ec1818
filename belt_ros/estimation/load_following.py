"""How lively the load is in every step: what the sensors say of it, taken to `load.LoadWander`."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.load import Activity, LoadWander, Tracks, follow_paces
from belt_ros.estimation.measurement import Sensor
from belt_ros.estimation.process import Wander
from belt_ros.estimation.sensing import Sensed
from belt_ros.estimation.state import Index, slip_per_pull
from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants

_Floats = NDArray[np.float64]
_Pair = tuple[float, float]
_SLOW = 0.1  # rim speed [m/s] below which the slip's wander no longer shrinks with it
# Compiled code wants plain integers.
_DRIVER_SPEED, _DRIVER_TORQUE = int(Index.DRIVER_SPEED), int(Sensor.DRIVER_TORQUE)


@compiled
def _ahead(
    c: DriveConstants, values: _Floats, variances: _Floats, rims: _Floats
) -> tuple[float, float]:
    """By how much the driver's rim is faster [m/s], and its variance; NaN if not told.

    `rims` (2, 2) are the speeds last read and not yet used [m/s], NaN without, and their variances.
    """
    for pulley in range(2):
        radius = c.driver_radius if pulley == 0 else c.driven_radius
        if not math.isnan(values[pulley]):
            rims[0, pulley] = radius * values[pulley]
            rims[1, pulley] = radius**2 * variances[pulley]
    ahead: float = rims[0, 0] - rims[0, 1]
    if not math.isnan(ahead):
        rims[0] = math.nan
    return ahead, rims[1, 0] + rims[1, 1]


@compiled
def _follow(
    constants: tuple[Any, ...],
    tracks: Tracks,
    values: _Floats,
    variances: _Floats,
    state: _Floats,
    rims: _Floats,
    wander: tuple[float, float],
    slip_tells: bool,  # noqa: FBT001 - compiled functions take no keywords
    dt: float,
) -> tuple[float, _Pair, _Pair, _Pair, bool]:
    """Return slip per pull, and what `load.follow_paces` does.

    `wander` is that of the load and that of creep at a steady load.
    """
    c = DriveConstants(*constants)  # a named tuple is slow to pass from Python
    load, creep = wander
    ahead, variance = _ahead(c, values, variances, rims)
    rim = max(c.driver_radius * abs(state[_DRIVER_SPEED]), _SLOW)
    per_pull = slip_per_pull(c, state)
    signals, noise, fastest, anyway = np.empty(3), np.empty(3), np.empty(3), np.zeros(3)
    for torque in range(2):
        signals[torque] = values[_DRIVER_TORQUE + torque]
        noise[torque] = variances[_DRIVER_TORQUE + torque]
        fastest[torque] = load * (c.driver_radius if torque == 0 else c.driven_radius)
    signals[2], noise[2] = ahead, variance
    fastest[2], anyway[2] = rim * per_pull * load, creep * abs(ahead)
    taken, shown, unseen, still = follow_paces(
        tracks, signals, noise, fastest, anyway, slip_tells, dt
    )
    return per_pull, taken, shown, unseen, still


class LoadFollowing:
    """Follow torques and slip speed, also where they come in separate measurements.

    The slip speed is told whenever both speeds have been read anew.

    Attributes
    ----------
    slip_per_pull : float
        Of steady creep [1/N] by the state last followed from, at least the belt's own strain.
    """

    def __init__(self, constants: DriveConstants) -> None:
        self._constants = tuple(constants)
        self._wander = LoadWander()
        self.slip_per_pull = 1.0 / constants.axial_stiffness
        self.start()

    def start(self) -> None:
        """Forget all signals, as before the first reading."""
        self._wander.start()
        self._rims = np.array([[math.nan, math.nan], [0.0, 0.0]])

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
        paces = self._wander
        self.slip_per_pull, taken, shown, unseen, paces.slip_tells = _follow(
            self._constants,
            paces.tracks,
            sensed.values,
            sensed.variances,
            state,
            self._rims,
            (wander.load, wander.creep),
            paces.slip_tells or unforeseen,
            dt,
        )
        return Activity(taken, shown, unseen)
