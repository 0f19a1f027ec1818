"""The grid on which the estimator is judged: three belts, kf, peak load and sensor noise."""

import itertools
import zlib
from typing import NamedTuple

from belt_ros.settings import DriveSettings, settings_from_parameters

STIFFNESSES = (1e7, 2.8e7, 8.1e7, 2e8, 4e8)  # prior median of kf [N/m2]
PEAKS = (0.30, 0.60, 0.85, 0.97)  # of the capacity
LOG_TENSION_STDDEV = 0.3  # of the prior ...
LOG_FRICTION_STDDEV = 0.05
STIFFNESS_DECADES = 0.304  # 0.7 in ln kf


class Belt(NamedTuple):
    """One kind of drive: equal pulleys, its constants in SI units."""

    axial_stiffness: float
    mass_per_length: float
    radius: float
    inertia: float
    tension: float
    friction: float
    speed: float


BELTS = {
    "paper": Belt(80068.0, 0.1036, 0.08125, 0.05, 435.0, 1.2, 120.0),
    # 4 % strain as installed; contact far stiffer than the belt, mu/(R lambda) <= 0.27
    "conveyor": Belt(20000.0, 0.3, 0.1, 0.05, 800.0, 0.6, 30.0),
    # contact softer than the belt: mu/(R lambda) is 1.2 at the stiffest kf and 7.7 at the softest
    "compliant": Belt(6e5, 0.15, 0.035, 0.01, 600.0, 1.1, 150.0),
}
NOISES = {
    "fine": {"noise.speed_relative": 1e-4, "noise.torque_relative": 0.005},
    "coarse": {"noise.speed_relative": 5e-4, "noise.torque_relative": 0.02},
}


class Cell(NamedTuple):
    """One cell of the grid."""

    belt: str
    stiffness: float
    peak: float
    noise: str

    @property
    def name(self) -> str:
        """Its name in tables and files."""
        return f"{self.belt} kf {self.stiffness:.1e} load {self.peak:.0%} {self.noise}"

    @property
    def seed(self) -> int:
        """A number that belongs to this cell alone."""
        return zlib.crc32(self.name.encode())


def all_cells() -> list[Cell]:
    """Return the whole grid."""
    return [Cell(*key) for key in itertools.product(BELTS, STIFFNESSES, PEAKS, NOISES)]


def some_cells() -> list[Cell]:
    """Return the cells on which other estimators are run too."""
    peaks = (0.60, 0.97)
    keys = itertools.product(BELTS, STIFFNESSES[::2], peaks)
    cells = [Cell(belt, stiffness, peak, "fine") for belt, stiffness, peak in keys]
    return cells + [Cell("paper", STIFFNESSES[2], peak, "coarse") for peak in peaks]


def cell_settings(cell: Cell, **changes: float | str) -> DriveSettings:
    """Return what the estimator is told of a cell's drive; `changes` by flat name, "__" for "."."""
    belt = BELTS[cell.belt]
    parameters: dict[str, object] = {
        "name": cell.belt,
        "belt.axial_stiffness": belt.axial_stiffness,
        "belt.mass_per_length": belt.mass_per_length,
        "span_length": 6.28 * belt.radius,
        "prior.tension": belt.tension,
        "prior.tension_stddev": LOG_TENSION_STDDEV * belt.tension,
        "prior.friction_stiffness": cell.stiffness,
        "prior.friction_stiffness_decades": STIFFNESS_DECADES,
        "prior.friction_coefficient": belt.friction,
        "prior.friction_coefficient_stddev": LOG_FRICTION_STDDEV * belt.friction,
        **NOISES[cell.noise],
    }
    for pulley in ("driver", "driven"):
        parameters[f"{pulley}.radius"] = belt.radius
        parameters[f"{pulley}.wrap_angle"] = 3.14159265
        parameters[f"{pulley}.inertia"] = belt.inertia
    parameters.update({name.replace("__", "."): value for name, value in changes.items()})
    return settings_from_parameters(parameters)
