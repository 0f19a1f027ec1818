"""All drives of the rig, side by side in the same scenario.

Drives that a parameter file tells apart have a plant each. A number of drives alike have one plant
between them, which is cheap, but sensors that go wrong one by one.
"""

import dataclasses
import itertools
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from belt_ros.mechanics.constants import drive_constants
from belt_ros.rig.entries import QUANTITIES, ScenarioError
from belt_ros.rig.readings import DRIVEN, DRIVER, NO_LOADS, PulleyReading, Rates, pulley_readings
from belt_ros.rig.running import RunningScenario
from belt_ros.rig.scenario import Scenario, load_scenario
from belt_ros.rig.sensors import LoadSample, LoadSensors
from belt_ros.rig.simulate import simulate
from belt_ros.rig.truth import Truth
from belt_ros.settings import DriveSettings, load_settings, names_of_drives, read_parameters

_LATEST = 10_000  # readings of load sensors that are kept for joint states that come late
_SEEDS = 2**32
_DRIVE = "drive="


class Instant(NamedTuple):
    """What goes out for a plant at one time, and what is true of each of its drives then."""

    stamp_ns: int
    readings: tuple[PulleyReading, ...]
    truth: Truth


class _LoadCells:
    """Load sensors, and what they said lately: a joint state may come later than it was read."""

    def __init__(self, settings: DriveSettings, scenario: Scenario) -> None:
        random = np.random.default_rng(scenario.seed).spawn(3)[2]
        self._sensors = LoadSensors(drive_constants(settings.drive), scenario.sensors, random)
        self._said: OrderedDict[int, LoadSample] = OrderedDict()
        self._last = NO_LOADS

    def measure(self, stamp_ns: int, truth: Truth) -> None:
        self._last = self._said[stamp_ns] = self._sensors.measure(truth)
        if len(self._said) > _LATEST:
            self._said.popitem(last=False)

    def at(self, stamp_ns: int) -> LoadSample:
        """Return what they said at a stamp; the latest, where it is that of another clock."""
        return self._said.get(stamp_ns, self._last)


class RigPlant:
    """One plant, and one drive or several drives alike that are read off it.

    Parameters
    ----------
    settings : DriveSettings
    scenario : Scenario
    names : sequence of str, optional
        Of the drives. By default it is one, called as in `settings`.
    loads : bool
        Whether hub loads and span tension are measured too.
    """

    def __init__(
        self,
        settings: DriveSettings,
        scenario: Scenario,
        names: Sequence[str] = (),
        *,
        loads: bool = False,
    ) -> None:
        self.settings = settings
        self.scenario = scenario
        names = names or (settings.name,)
        self.running = {name: RunningScenario(scenario, settings) for name in names}
        self._cells = _LoadCells(settings, scenario) if loads else None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its drives."""
        return tuple(self.running)

    def play(self, start_ns: int, rates: Rates) -> Iterator[Instant]:
        """Play the scenario from a stamp [ns] on, sample by sample."""
        first, *others = self.running.items()
        for _, running in others:
            running.start(start_ns)
        period_ns = self.scenario.stamp_ns(1)
        for sample in simulate(self.settings, self.scenario, start_ns, first[1]):
            if self._cells is not None:
                self._cells.measure(sample.stamp_ns, sample.truth)
            reports = [(first[0], report) for report in sample.published]
            for name, running in others:
                said = running.reports(sample.stamp_ns, sample.joints)
                reports += [(name, report) for report in said]
            readings = [
                reading
                for name, report in reports
                for reading in pulley_readings(
                    name,
                    report,
                    self._cells.at(report.stamp_ns) if self._cells else NO_LOADS,
                    report.stamp_ns - start_ns,
                    period_ns,
                    rates,
                )
            ]
            yield Instant(sample.stamp_ns, tuple(readings), sample.truth)

    def request(self, text: str, drive: str = "") -> None:
        """Let an event or a fault begin, of one drive or of all; see `running`.

        Raises
        ------
        ScenarioError
            If it is neither, cannot be run, or is an event of one drive that shares its plant.
        """
        event = any(word.partition("=")[0] in QUANTITIES for word in text.split())
        if event and drive and len(self.running) > 1:
            raise ScenarioError(
                f"{drive} shares its plant with {len(self.running) - 1} others; only faults of "
                f"sensors can be its own, or leave out {_DRIVE}{drive}"
            )
        names = [drive] if drive else list(self.running)
        for name in names[:1] if event else names:
            self.running[name].request(text)


class Fleet:
    """All drives of the rig.

    Parameters
    ----------
    plants : sequence of RigPlant
        At least one, of scenarios with the same duration and rate.
    """

    def __init__(self, plants: Sequence[RigPlant]) -> None:
        assert plants
        self.plants = tuple(plants)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all drives."""
        return tuple(name for plant in self.plants for name in plant.names)

    @property
    def joints(self) -> dict[tuple[str, str], str]:
        """Names of all joints, as their drives call them, by drive and pulley."""
        return {
            (name, pulley): joint.name
            for plant in self.plants
            for name in plant.names
            for pulley, joint in (
                (DRIVER, plant.settings.driver),
                (DRIVEN, plant.settings.driven),
            )
        }

    @property
    def scenario(self) -> Scenario:
        """What is played, as the first plant has it."""
        return self.plants[0].scenario

    def play(self, start_ns: int, rates: Rates) -> Iterator[tuple[Instant, ...]]:
        """Play the scenario from a stamp [ns] on; one `Instant` of each plant at a time."""
        yield from zip(*(plant.play(start_ns, rates) for plant in self.plants), strict=True)

    def request(self, text: str) -> None:
        """Let an event or a fault begin on all drives, or on that named by ``drive=<name>``.

        Raises
        ------
        ScenarioError
            If there is no such drive, or a drive cannot have it. Drives before it then have it.
        """
        words = text.split()
        named = [word.removeprefix(_DRIVE) for word in words if word.startswith(_DRIVE)]
        rest = " ".join(word for word in words if not word.startswith(_DRIVE))
        if not named:
            for plant in self.plants:
                plant.request(rest)
            return
        owners = {name: plant for plant in self.plants for name in plant.names}
        if len(named) > 1 or named[0] not in owners:
            raise ScenarioError(
                f"drive is {', '.join(named)}; it must be one of {', '.join(owners)}"
            )
        owners[named[0]].request(rest, named[0])

    def clear(self) -> tuple[str, ...]:
        """End all faults and return to the script; return what has ended, each thing once."""
        ended: dict[str, None] = {}
        for plant in self.plants:
            for running in plant.running.values():
                ended |= dict.fromkeys(running.clear())
        return tuple(ended)


def load_fleet(
    config_file: str | Path, scenario_file: str | Path, count: int = 0, *, loads: bool = False
) -> Fleet:
    """Read the drives and the scenario that they all play, each with a noise of its own.

    Parameters
    ----------
    config_file : str or Path
        Of one drive, or of several with their names in ``drives``.
    scenario_file : str or Path
    count : int
        So many drives like the one in `config_file`, called ``drive_1`` and so on; 0: as it says.
    loads : bool
        Whether hub loads and span tension are measured too.

    Raises
    ------
    SettingsError
        If a file cannot be used, or `count` is given for a file of several drives.
    """
    names = names_of_drives(read_parameters(config_file))
    if count and len(names) > 1:
        raise ScenarioError(f"drives is {count}, but {config_file} names {len(names)} itself")
    if count:
        settings = load_settings(config_file)
        copies = [f"drive_{number}" for number in range(1, count + 1)]
        scenario = load_scenario(scenario_file, settings)
        return Fleet([RigPlant(settings, scenario, copies, loads=loads)])
    plants = []
    for number, name in enumerate(names or ("",)):
        settings = load_settings(config_file, drive=name)
        scenario = load_scenario(scenario_file, settings)
        seed = (scenario.seed + number) % _SEEDS
        own = dataclasses.replace(scenario, seed=seed)
        plants.append(RigPlant(settings, own, loads=loads))
    return Fleet(plants)


def warm_up(fleet: Fleet) -> None:
    """Compile what the first sample would otherwise wait for; the fleet stays as it is."""
    plant = fleet.plants[0]
    for _ in itertools.islice(simulate(plant.settings, plant.scenario), 2):
        pass
