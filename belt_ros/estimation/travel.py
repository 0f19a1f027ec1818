"""Rim travel that one pulley is ahead of the other, counted from the angles of both.

Angles need not come at once: each is unwrapped by itself, and travel is told whenever both have
been read anew. What of them is a little older is taken on by its speed.
"""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.measurement import unwrapped
from belt_ros.estimation.process import Process
from belt_ros.estimation.state import STATES, Index
from belt_ros.mechanics.constants import DriveConstants

_Floats = NDArray[np.float64]
_FORGOTTEN = 0.1  # [s] without an angle
_TOGETHER = 0.012  # [s] by which two angles may be apart


class _Encoder:
    """The angle of one pulley, unwrapped."""

    def __init__(self, turn: float) -> None:
        self._turn = turn
        self._speed = math.nan
        self.forget()

    def forget(self) -> None:
        """Count anew from the next reading on."""
        self._angle = self._speed_then = math.nan
        self._since = 0.0
        self.read_anew = False

    def read(self, speed: float, position: float, dt: float) -> None:
        """Take in what was read `dt` [s] after the last call, NaN where nothing was."""
        self._since += dt
        if not math.isnan(speed):
            self._speed = speed
        if math.isnan(position) or math.isnan(self._speed):
            if self._since > _FORGOTTEN:
                self.forget()
            return
        if self.counts:
            turned = 0.5 * self._since * (self._speed_then + self._speed)
            position = unwrapped(self._angle, position, turned, self._turn)
        self._angle, self._speed_then = position, self._speed
        self._since = 0.0
        self.read_anew = True

    @property
    def counts(self) -> bool:
        """Whether its angle is known."""
        return not math.isnan(self._angle)

    @property
    def fresh(self) -> bool:
        """Whether it has been read since it was last used, and just now."""
        return self.read_anew and self._since <= _TOGETHER

    @property
    def angle(self) -> float:
        """Where it is now [rad]."""
        return self._angle + self._speed * self._since


class Travel:
    """Count rim travel from the first angles on.

    Parameters
    ----------
    constants : DriveConstants
    turns : tuple of float
        One turn of either joint, seen at its pulley [rad].
    """

    def __init__(self, constants: DriveConstants, turns: tuple[float, float]) -> None:
        self._constants = constants
        self._encoders = _Encoder(turns[0]), _Encoder(turns[1])
        self.start()

    def start(self) -> None:
        """Count anew from the next angles on."""
        self._first: tuple[float, float] | None = None
        for encoder in self._encoders:
            encoder.forget()

    @property
    def counts(self) -> bool:
        """Whether the angles of both pulleys are known since an earlier measurement."""
        return self._first is not None

    def ahead(
        self, speeds: tuple[float, float], positions: tuple[float, float], dt: float
    ) -> float:
        """Return by how much the driver's rim is ahead since angles are counted [m].

        NaN unless both angles were read since it was last told. `dt` [s] has passed since the
        measurement before.
        """
        driver, driven = self._encoders
        driver.read(speeds[0], positions[0], dt)
        driven.read(speeds[1], positions[1], dt)
        if not (driver.counts and driven.counts):
            self._first = None
            return math.nan
        if not (driver.fresh and driven.fresh):
            return math.nan
        angles = driver.angle, driven.angle
        driver.read_anew = driven.read_anew = False
        if self._first is None:
            self._first = angles
            return math.nan
        c = self._constants
        ahead = c.driver_radius * (angles[0] - self._first[0])
        return ahead - c.driven_radius * (angles[1] - self._first[1])


def travel_anew(constants: DriveConstants, variances: tuple[float, float]) -> Process:
    """Return what lets travel count from here, by angles of driver and driven with `variances`."""
    memory, variance = np.ones(STATES), np.zeros(STATES)
    memory[Index.TRAVEL] = 0.0
    driver, driven = variances
    variance[Index.TRAVEL] = (
        constants.driver_radius**2 * driver + constants.driven_radius**2 * driven
    )
    return Process(memory, np.diag(variance), np.zeros(STATES))
