"""What the alarms are judged on: belts, contact stiffness, and what is known of the tension."""

import zlib
from typing import NamedTuple

from belt_ros.estimation import BeltMonitor, Maintenance, MaintenanceKind
from belt_ros.settings import DriveSettings
from benchmarks.estimation.cells import Cell, cell_settings

PRIOR, LEARNED, MEASURED = "prior", "learned", "measured"
KNOWLEDGE = (PRIOR, LEARNED, MEASURED)
_GAUGE = 0.05  # relative standard deviation of a measured tension


class Case(NamedTuple):
    """One drive, and what is known of its tension before the load rises."""

    belt: str
    stiffness: float
    knowledge: str = PRIOR

    @property
    def name(self) -> str:
        """Its name in tables and files."""
        return f"{self.belt} kf {self.stiffness:.1e} {self.knowledge}"

    @property
    def seed(self) -> int:
        """A number that belongs to this drive alone, whatever is known of it."""
        return zlib.crc32(f"{self.belt} {self.stiffness:.1e}".encode())

    def settings(self, seed: int) -> DriveSettings:
        """Return what the estimator is told; every other drive has the coarser sensors."""
        noise = "fine" if seed % 2 == 0 else "coarse"
        return cell_settings(Cell(self.belt, self.stiffness, 1.0, noise))


def case_of(name: str) -> Case:
    """Return the case of a name."""
    belt, _, stiffness, knowledge = name.split()
    return Case(belt, float(stiffness), knowledge)


def monitor_of(case: Case, settings: DriveSettings, tension: float, gauge: float) -> BeltMonitor:
    """Return a monitor that knows what the case says.

    `gauge` is the error of the tension gauge over its standard deviation.
    """
    monitor = settings.monitor()
    if case.knowledge == MEASURED:
        said = tension * (1.0 + _GAUGE * gauge)
        monitor.maintain(Maintenance(MaintenanceKind.TENSION_MEASURED, said, _GAUGE * said))
    return monitor
