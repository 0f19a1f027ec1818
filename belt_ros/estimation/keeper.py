"""What changes belief of the belt between measurements: memory, maintenance, rest."""

import math
from contextlib import suppress

import numpy as np

from belt_ros.estimation.belt_filter import BeltFilter
from belt_ros.estimation.credence import Credence
from belt_ros.estimation.gaussian_sum import Component
from belt_ros.estimation.installed import Installed, installed_as
from belt_ros.estimation.maintenance import Maintenance, MaintenanceKind, maintained
from belt_ros.estimation.memory import Learned, MemoryRefusedError, learned_from, restore
from belt_ros.mechanics.drive import BeltDrive


class Keeper:
    """Keeps what has been learned, and says what it is worth after a while or a repair.

    Parameters
    ----------
    name : str
        Of the drive.
    drive : BeltDrive
    belt_filter : BeltFilter
    credence : Credence
        Of that filter; it is told what is believed from now on.
    told : Installed
        How the belt is installed, as the drive's description has it.

    Attributes
    ----------
    installed : Installed
        With which traction is compared.
    """

    def __init__(
        self,
        name: str,
        drive: BeltDrive,
        belt_filter: BeltFilter,
        credence: Credence,
        told: Installed,
    ) -> None:
        self._name = name
        self._drive = drive
        self._filter = belt_filter
        self._credence = credence
        self._told = self.installed = told

    def forget(self) -> None:
        """Go by the drive's description alone."""
        self._install(self._told)
        self._credence.initial = None

    def learned(self, date: float) -> Learned | None:
        """Return what has been learned of the belt by `date` [s], None if that is nothing yet."""
        known = self._credence.known
        if known is None:
            return None
        # As told is as told then: descriptions are edited between runs.
        installed = None if self.installed == self._told else self.installed
        return learned_from(known, self._name, self._drive, date, installed)

    def restore(self, learned: Learned, elapsed: float) -> str:
        """Start from what was learned `elapsed` [s] ago; return a note for the log, or ""."""
        note = self._adopt_aged(learned, elapsed)
        if learned.installed is not None:
            self._install(learned.installed)
        return note

    def rest(self, elapsed: float) -> None:
        """Let what is known age by `elapsed` [s] of standstill in which nothing was measured.

        It is as if the drive had been switched off, and what it had learned restored.
        """
        with suppress(MemoryRefusedError):  # where nothing is sane, nothing can age
            learned = self.learned(0.0)
            if learned is not None:
                self._adopt_aged(learned, elapsed)
                self._filter.rest(elapsed)

    def maintain(self, maintenance: Maintenance) -> str:
        """Take in what was done to the belt; return a sentence for the log."""
        f, known = self._filter, self._credence.known
        prior = Component(0.0, f.prior_mean.copy(), np.diag(f.prior_stddev**2))
        done = maintained(known or [prior], maintenance, f.prior_mean, f.prior_stddev)
        self._credence.adopt(done.components)
        if maintenance.kind is not MaintenanceKind.TENSION_MEASURED:
            told = maintenance.tension if math.isfinite(maintenance.tension) else self._told.tension
            self._install(installed_as(done.components, told))
        return done.message

    def _adopt_aged(self, learned: Learned, elapsed: float) -> str:
        f = self._filter
        restored = restore(learned, self._drive, f.prior_mean, f.prior_stddev, f.drift, elapsed)
        self._credence.adopt(restored.components, of_belt_only=True)
        return restored.note

    def _install(self, installed: Installed) -> None:
        self.installed = installed
        self._credence.compare_with(installed)
