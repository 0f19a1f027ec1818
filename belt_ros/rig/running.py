"""A scenario while it runs: its script, its faults, and what is asked of the rig meanwhile.

What is asked for is an entry of the scenario's events or faults in words, without ``at``: it begins
at once. ``tension=261 over=2`` is an event and holds until it is cleared, whatever the script says,
and may take longer than a script that is repeated;
``stuck driven_speed duration=5`` is a fault, the kind first and then its sensor.
"""

import contextlib
import dataclasses

import numpy as np
from numpy.typing import NDArray

from belt_ros.rig.entries import QUANTITIES, Event, ScenarioError, read_event, read_fault
from belt_ros.rig.faults import Fault, Report, SensorFaults
from belt_ros.rig.scenario import LONGEST, Scenario
from belt_ros.rig.sensors import JointSample
from belt_ros.settings import DriveSettings

_Floats = NDArray[np.float64]
_LONGEST_REQUEST = 200  # characters
_MOST_REQUESTS = 100


class RunningScenario:
    """What drive and sensors are to do next, by the script and by request.

    Parameters
    ----------
    scenario : Scenario
    settings : DriveSettings
        The drive that it runs on.
    """

    def __init__(self, scenario: Scenario, settings: DriveSettings) -> None:
        self.scenario = scenario
        self._settings = settings
        self._present = scenario  # with the events that were asked for
        self._requested: list[Event] = []
        # A stream of its own: faults leave the noise of plant and sensors as it is.
        self._faults = SensorFaults(np.random.default_rng(scenario.seed).spawn(4)[3])
        self._waiting: list[Fault] = []  # asked for before the start
        self._started = False
        self._start_ns = 0
        self._now = 0.0  # since the start [s]

    def start(self, start_ns: int) -> None:
        """Begin the script at a stamp [ns], maybe again.

        What was asked for goes on, but for events under which the script cannot begin.
        """
        if self._started:
            self._begin_again()
        self._started = True
        self._start_ns = start_ns
        self._now = 0.0
        end = self.scenario.samples / self.scenario.sample_rate
        for fault in self.scenario.faults:
            until = min(fault.end, end) if fault.begin < fault.end else fault.end
            self._faults.add(dataclasses.replace(fault, end=until), start_ns)
        for fault in self._waiting:
            self._faults.add(fault, start_ns)
        self._waiting.clear()

    def _begin_again(self) -> None:
        before, self._present = self._present, self.scenario
        requested, self._requested = self._requested, []
        end = self.scenario.samples / self.scenario.sample_rate
        reached = dict(zip(QUANTITIES, before.commands(np.array([end]))[0].tolist(), strict=True))
        for event in requested:
            begun = Event(event.quantity, 0.0, reached[event.quantity], 0.0)
            left = max(event.at + event.over - end, 0.0)
            rest = dataclasses.replace(event, at=0.0, over=left)
            with contextlib.suppress(ScenarioError):
                present = self._present.with_event(begun, self._settings)
                self._present = present.with_event(rest, self._settings)
                self._requested.append(rest)

    def _hold(self, event: Event) -> None:
        self._present = self._present.with_event(event, self._settings)
        self._requested.append(event)

    def commands(self, times: _Floats) -> _Floats:
        """Rows of commands (n, 5) at `times` [s] since the start, in the order of `Command`."""
        return self._present.commands(times)

    def reports(self, stamp_ns: int, joints: JointSample) -> tuple[Report, ...]:
        """Return the joint states that go out at `stamp_ns`, when `joints` are read."""
        self._now = (stamp_ns - self._start_ns) * 1e-9
        return self._faults.reports(stamp_ns, joints)

    def request(self, text: str) -> None:
        """Let an event or a fault begin now.

        Raises
        ------
        ScenarioError
            If it is neither, or cannot be run; all goes on as before.
        """
        asked = len(self._requested) + len(self._waiting) + len(self._faults)
        if asked >= _MOST_REQUESTS + len(self.scenario.faults):
            raise ScenarioError(f"{_MOST_REQUESTS} were asked for already; clear them first")
        duration = self.scenario.duration
        entry: dict[str, object] = {**_entry(text), "at": min(self._now, duration)}
        if "kind" not in entry:
            self._hold(read_event("the event", entry, duration, longest=LONGEST))
        elif not self._started:
            self._waiting.append(read_fault("the fault", entry, duration))
        else:
            self._faults.add(read_fault("the fault", entry, duration), self._start_ns)

    def clear(self) -> tuple[str, ...]:
        """End all faults that act, scripted or not, and return to the script.

        Returns
        -------
        tuple of str
            What has ended.
        """
        ended = (*self._waiting, *self._faults.end())
        self._waiting.clear()
        events, self._requested = self._requested, []
        self._present = self.scenario
        return (
            *(event.quantity for event in events),
            *(f"{fault.kind.value} {fault.sensor}" for fault in ended),
        )


def _entry(text: str) -> dict[str, str]:
    """Entry of a list of events or faults, from words; kind and sensor may go without name."""
    if len(text) > _LONGEST_REQUEST:
        raise ScenarioError(f"it has {len(text)} characters; {_LONGEST_REQUEST} are enough")
    entry: dict[str, str] = {}
    unnamed = ["kind", "sensor"]
    for word in text.split():
        name, equals, value = word.partition("=")
        if not equals:
            if not unnamed:
                raise ScenarioError(f"{word} has no name; write name=value, e.g. duration={word}")
            name, value = unnamed.pop(0), word
        if name in entry or name == "at":
            why = "it begins at once" if name == "at" else "it is there already"
            raise ScenarioError(f"{name} cannot be given: {why}")
        entry[name] = value
    return entry
