"""A drive that runs, stands, reverses and slips: plausible, so that the filter stays alive."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.settings import DriveSettings

_Floats = NDArray[np.float64]
_SECOND_NS = 1_000_000_000
_BEHAVIOURS = ("run", "run", "stand", "reverse", "slip", "constant", "unloaded")
_SEGMENT = 150  # messages, mean
_PACE = 0.05  # share by which speed and load approach their aims in a sample
_OF_CRITICAL = 0.3  # greatest share of the belt's critical speed,
_OF_LIMIT = 0.5  # of what the limits allow,
_OF_GAP = 0.4  # and of the longest gap, that the drive itself takes
_LARGEST_NOISE = 0.1  # of a value


class Row(NamedTuple):
    """What sensors without a fault say: a stamp [ns] and values (9,) in the order of `Sensor`."""

    stamp_ns: int
    values: _Floats


class Motion:
    """Quasi-static, with noise: what drive and load do is drawn anew every hundred messages or so.

    Parameters
    ----------
    settings : DriveSettings
    random : Generator

    Attributes
    ----------
    stamp_ns : int
        The sensors' clock.
    """

    def __init__(self, settings: DriveSettings, random: np.random.Generator) -> None:
        self._settings, self._random = settings, random
        self.stamp_ns = int(random.integers(1, 2_000_000_000)) * _SECOND_NS
        self._interval = float(10.0 ** random.uniform(-4.0, -0.5))
        if random.random() < 0.8:
            self._interval = min(self._interval, _OF_GAP * settings.limits.greatest_gap)
        drive, limits = settings.drive, settings.limits
        grip = -math.expm1(-min(drive.driven.traction_limit, drive.driver.traction_limit))
        radius = max(drive.driver.radius, drive.driven.radius)
        self._capacity = min(  # pull [N]
            2.0 * settings.prior.tension * grip / (2.0 - grip),
            _OF_LIMIT * limits.greatest_torque / radius,
        )
        self._fastest = min(  # [m/s]
            _OF_CRITICAL * drive.belt.critical_speed,
            _OF_LIMIT * limits.greatest_speed * min(drive.driver.radius, drive.driven.radius),
        )
        self._speed = self._speed_aim = self._pull = self._pull_aim = 0.0  # [m/s], [N]
        self._angles = np.zeros(2)
        self._frozen: _Floats | None = None
        self._left = 0

    def next(self) -> Row:
        """Return what is measured an interval later."""
        if self._left <= 0:
            self._decide()
        self._left -= 1
        dt = self._interval * float(self._random.choice([0.5, 1.0, 1.0, 1.0, 1.5]))
        self.stamp_ns += max(round(dt * _SECOND_NS), 1)
        self._speed += _PACE * (self._speed_aim - self._speed)
        self._pull += _PACE * (self._pull_aim - self._pull)
        if self._frozen is not None:
            return Row(self.stamp_ns, self._frozen.copy())
        return Row(self.stamp_ns, self._measured(dt))

    def _decide(self) -> None:
        random = self._random
        behaviour = str(random.choice(_BEHAVIOURS))
        self._left = 1 + int(random.geometric(1.0 / _SEGMENT))
        self._frozen = self._measured(0.0) if behaviour == "constant" else None
        if behaviour == "stand":
            self._speed_aim = self._speed = 0.0
        elif behaviour != "constant":
            speed = min(10.0 ** random.uniform(-1.0, 1.5), self._fastest)
            self._speed_aim = -speed if behaviour == "reverse" else speed
        load = {"slip": random.uniform(0.9, 1.5), "unloaded": 0.0}.get(
            behaviour, random.uniform(-0.8, 0.8)
        )
        self._pull_aim = float(load) * self._capacity

    def _measured(self, dt: float) -> _Floats:
        settings, random = self._settings, self._random
        driver, driven = settings.drive.driver, settings.drive.driven
        creep = self._pull / settings.drive.belt.axial_stiffness
        if abs(self._pull) > self._capacity:
            creep += math.copysign(0.2, self._pull)
        slip = min(max(creep * math.copysign(1.0, self._speed), -0.5), 0.5)
        speeds = np.array([self._speed / driver.radius, self._speed * (1.0 - slip) / driven.radius])
        torques = np.array([self._pull * driver.radius, -self._pull * driven.radius])
        self._angles = self._angles + speeds * dt
        tension = settings.prior.tension
        loads = np.array([2.0 * tension, 2.0 * tension, tension + 0.5 * self._pull])
        values = np.concatenate([speeds, torques, self._angles, loads])
        relative, absolute = settings.noise.noise_rows()
        noise = np.sqrt(relative * values**2 + absolute)
        noise = np.minimum(noise, _LARGEST_NOISE * (np.abs(values) + 0.01))
        return np.asarray(values + noise * random.normal(size=9))
