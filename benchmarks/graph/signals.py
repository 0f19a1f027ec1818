"""What the sender sends: a drive's joint states, from the rig, as one cycle to be repeated."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.mechanics import torque_capacity
from belt_ros.rig import simulate
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.settings import DriveSettings

SPEED = 120.0  # [rad/s]
CHANGING, STEADY = (0.3, 0.8, 0.5), (0.5,) * 3  # levels of the load, of the capacity
_LEVEL = 2.0  # [s] that each lasts
_RISE = 0.2  # [s] from one to the next
_DURATION = _LEVEL * len(CHANGING)
_SETTLED = 1.0  # [s] of running before the cycle begins

_Floats = NDArray[np.float64]


class Cycle(NamedTuple):
    """Joint states at even intervals, whose last leads on to the first."""

    joints: tuple[str, ...]
    numbers: _Floats  # (samples, 2, joints): velocities [rad/s], efforts [N m]

    def repeated(self, drives: int) -> "Cycle":
        """Return the joint states of several such drives in one message.

        Each is a little ahead of the next in its cycle: loads of drives do not change all at once.
        """
        joints = tuple(f"{joint}_{k}" for k in range(drives) for joint in self.joints)
        ahead = [k * len(self.numbers) // drives for k in range(drives)]
        shifted = [np.roll(self.numbers, -samples, axis=0) for samples in ahead]
        return Cycle(joints, np.concatenate(shifted, axis=2))

    def save(self, folder: Path) -> str:
        """Write the numbers; return the file's name."""
        path = folder / "cycle.npy"
        np.save(path, np.ascontiguousarray(self.numbers))
        return str(path)


def loaded(settings: DriveSettings, rate: float, levels: tuple[float, ...] = CHANGING) -> Cycle:
    """Return a drive that is loaded in three levels, sampled at `rate` [Hz]."""
    capacity = float(torque_capacity(settings.drive, settings.prior.tension, SPEED))
    load = [[0.0, levels[-1] * capacity]]
    for number, share in enumerate(levels):
        begin = _SETTLED + _LEVEL * number
        load += [[begin, load[-1][1]], [begin + _RISE, share * capacity]]
    values: dict[str, object] = {
        "duration": _SETTLED + _DURATION,
        "sample_rate": rate,
        "seed": 1.0,
        "speed": SPEED,
        "load": load,
    }
    samples = simulate(settings, scenario_from_mapping(values, settings))
    rows = [(each.joints.velocities, each.joints.efforts) for each in samples]
    return Cycle((settings.driver.name, settings.driven.name), np.array(rows[-_samples(rate) :]))


def _samples(rate: float) -> int:
    return round(_DURATION * rate)
