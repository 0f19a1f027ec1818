"""How well measurements fit, and what became of them: counts and innovations, kept up to date."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.estimate import Health
from belt_ros.estimation.fit import SPEEDS, InnovationFit, SensorFits
from belt_ros.estimation.measurement import Rejection
from belt_ros.estimation.state import STATES, Index

_SENSORS = (*SPEEDS, "driver torque", "driven torque", "positions")
_SENSOR_OF = np.zeros(STATES, dtype=np.int64)  # by the state that it reads
_SENSOR_OF[[Index.DRIVER_SPEED, Index.DRIVEN_SPEED]] = 0, 1
_SENSOR_OF[[Index.DRIVER_TORQUE, Index.DRIVEN_TORQUE, Index.TRAVEL]] = 2, 3, 4


class HealthRecord:
    """Counts since start or reset, and the fit of the run that is under way."""

    def __init__(self) -> None:
        self._resets = 0
        self.reset()

    def reset(self) -> None:
        """Count anew, but for the resets themselves."""
        self._accepted = 0
        self._rejections = [0] * len(Rejection)
        self._last_rejection = Rejection.NONE
        self.begin()

    def begin(self) -> None:
        """Judge the fit anew."""
        self._innovation = (0.0, 0)
        self._fit = InnovationFit()
        self._sensor_fits = SensorFits(_SENSORS)

    def count_reset(self) -> None:
        """Count a start anew."""
        self._resets += 1

    def accept(self, count: int = 1) -> None:
        """Count measurements that were used."""
        self._accepted += count

    def reject(self, reason: Rejection, count: int = 1) -> None:
        """Count measurements that were not."""
        self._rejections[reason] += count
        self._last_rejection = reason

    def judge(
        self,
        innovation: tuple[float, int],
        seen: NDArray[np.int64],
        surprises: NDArray[np.float64],
        dt: float,
        *,
        standing: bool,
    ) -> None:
        """Take in innovations; at standstill they say nothing.

        Parameters
        ----------
        innovation : tuple of float and int
            Innovation squared, normalised, and its degrees of freedom.
        seen : ndarray
            States that were read (n,).
        surprises : ndarray
            Innovation squared over its variance, of each (n,).
        dt : float
            Since the one before [s].
        """
        self._innovation = innovation
        self._fit.update(*((0.0, 0) if standing else innovation), dt)
        self._sensor_fits.update(_SENSOR_OF[seen[:0] if standing else seen], surprises, dt)

    @property
    def brief(self) -> Health:
        """Counts and fit."""
        return Health(
            innovation_squared=self._innovation[0],
            degrees_of_freedom=self._innovation[1],
            accepted=self._accepted,
            resets=self._resets,
            last_rejection=self._last_rejection,
            rejections=tuple(self._rejections),
            fit=self._fit.fit,
        )

    @property
    def health(self) -> Health:
        """Counts and fit, with the fit of every sensor."""
        return replace(self.brief, sensor_fits=self._sensor_fits.fits)
