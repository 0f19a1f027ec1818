"""A scripted run of the rig, from YAML: speed, load, the belt's true condition, faults.

Points are [time, value] pairs joined by straight lines; two at the same time make a step. An event
moves one quantity from what it then is to a value, ``over`` seconds, where it stays until the next
event of that quantity. A fault concerns a sensor, or the joint states as a whole, for ``duration``
seconds; see `faults.Fault`::

    duration: 30.0
    speed: [[0.0, 0.0], [4.0, 120.0]]
    load: [[5.0, 0.0], [5.2, 15.0]]
    condition: {tension: 435.0, friction_stiffness: 6.0e+7}
    events:
      - {at: 16.0, tension: 261.0, over: 1.0}
    faults:
      - {at: 20.0, kind: stuck, sensor: driven_speed, duration: 2.0}

What is not given comes from the drive's own description: condition from its prior, sensors from its
noise.
"""

import dataclasses
import difflib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from belt_ros.mechanics import torque_capacity
from belt_ros.parameter_table import Parameter, SettingsError
from belt_ros.rig.entries import QUANTITIES, Event, ScenarioError, read_event, read_fault, take
from belt_ros.rig.faults import Fault
from belt_ros.rig.model_error import ModelError
from belt_ros.rig.plant import Command, Motor
from belt_ros.rig.profile import Profile
from belt_ros.rig.sensors import SensorErrors
from belt_ros.settings import DriveSettings, read_parameters

__all__ = ["Scenario", "ScenarioError", "load_scenario", "scenario_from_mapping"]

_Floats = NDArray[np.float64]
_Group = TypeVar("_Group")
_MOST_POINTS = 10_000
_MOST_SAMPLES = 100_000_000
LONGEST = 1e6  # [s] of a scenario, and of a change that is asked for while one runs
_HEAD = (
    Parameter("duration", None, "how long it takes", "s", 0.01, LONGEST),
    Parameter("name", "scenario", "name of the scenario"),
    Parameter("sample_rate", 100.0, "joint states per second", "Hz", 0.1, 1e4),
    Parameter("seed", 1.0, "of all random numbers", "-", 0.0, 2.0**32 - 1.0),
    Parameter(
        "load_direction",
        "opposes_rotation",
        "whether the load turns round with the rotation, as a brake's does, or not",
        choices=("opposes_rotation", "fixed"),
    ),
)
_SCRIPTED = ("speed", "load")


@dataclass(frozen=True)
class Scenario:
    """A run of the rig, checked. `profiles` are in the order of `Command`."""

    name: str
    duration: float  # [s]
    sample_rate: float  # [Hz]
    seed: int
    load_brakes: bool
    profiles: tuple[Profile, ...]
    motor: Motor
    model_error: ModelError
    sensors: SensorErrors
    faults: tuple[Fault, ...] = ()

    @property
    def samples(self) -> int:
        """Number of samples, that at the start included."""
        return math.floor(self.duration * self.sample_rate + 1e-9) + 1

    def stamp_ns(self, sample: int) -> int:
        """Time of a sample since the start [ns]."""
        return round(sample * 1e9 / self.sample_rate)

    def commands(self, times: _Floats) -> _Floats:
        """Rows of commands (n, 5) at `times` [s], in the order of `Command`."""
        return np.stack([profile.at(times) for profile in self.profiles], axis=-1)

    def with_event(self, event: Event, settings: DriveSettings) -> "Scenario":
        """Return this scenario with an event that holds, whatever the script says from then on.

        Raises
        ------
        ScenarioError
            If it cannot be run on this drive.
        """
        profiles = list(self.profiles)
        place = tuple(QUANTITIES).index(event.quantity)
        profiles[place] = profiles[place].with_ramp(event.at, event.target, event.over)
        scenario = dataclasses.replace(self, profiles=tuple(profiles))
        _check_runnable(scenario, settings)
        return scenario


def load_scenario(path: str | Path, settings: DriveSettings) -> Scenario:
    """Read and check a scenario for a drive.

    Raises
    ------
    ScenarioError
        If the file cannot be read, or an entry is unknown, missing, of the wrong type, out of range
        or cannot be run on this drive. The message begins with the path.
    """
    try:
        return scenario_from_mapping(read_parameters(path), settings)
    except SettingsError as error:
        text = str(error)
        raise ScenarioError(text if str(path) in text else f"{path}: {text}") from error


def scenario_from_mapping(values: Mapping[str, object], settings: DriveSettings) -> Scenario:
    """Build a scenario from flat names (``condition.tension``); errors as `load_scenario`."""
    rest = dict(values)
    head: dict[str, Any] = {entry.name: take(rest, entry) for entry in _HEAD}
    if head["seed"] != int(head["seed"]):
        raise ScenarioError(f"seed is {head['seed']:g}; it must be a whole number")
    duration = head["duration"]
    profiles = {name: _profile(rest, name, settings, duration) for name in QUANTITIES}
    _add_events(profiles, rest.pop("events", []), duration)
    faults = _entries(rest.pop("faults", []), "faults", "at, kind, sensor, duration, value")
    tension = profiles["tension"].values[0]
    strong = 2.0 * float(torque_capacity(settings.drive, tension))
    strong *= settings.drive.driver.radius / settings.drive.driven.radius
    noise = dataclasses.asdict(settings.noise)
    del noise["position_absolute"]  # the rig's encoders are exact but for counting, unless told
    scenario = Scenario(
        name=head["name"],
        duration=duration,
        sample_rate=head["sample_rate"],
        seed=int(head["seed"]),
        load_brakes=head["load_direction"] == "opposes_rotation",
        profiles=tuple(profiles.values()),
        motor=_group(rest, "motor", Motor, {"torque_limit": strong}),
        model_error=_group(rest, "condition", ModelError, {}),
        sensors=_group(rest, "sensors", SensorErrors, noise),
        faults=tuple(read_fault(name, entry, duration) for name, entry in faults),
    )
    _reject_unknown(rest)
    _check_runnable(scenario, settings)
    return scenario


def _add_events(profiles: dict[str, Profile], given: object, duration: float) -> None:
    """Let each profile follow the events of its quantity, in the order of time."""
    scripted_until = {name: profile.times[-1] for name, profile in profiles.items()}
    entries = _entries(given, "events", "at, <quantity>, over")
    events = [read_event(name, entry, duration) for name, entry in entries]
    for event in sorted(events, key=lambda event: event.at):
        name = event.quantity
        if event.at < scripted_until[name]:
            raise ScenarioError(
                f"the event of {name} at {event.at:g} s is before the last point of {name}, at "
                f"{scripted_until[name]:g} s; an event holds, so write what follows it as events"
            )
        profiles[name] = profiles[name].with_ramp(event.at, event.target, event.over)


def _group(
    rest: dict[str, object], prefix: str, kind: type[_Group], defaults: Mapping[str, float]
) -> _Group:
    values: dict[str, Any] = {}
    for field in dataclasses.fields(kind):  # type: ignore[arg-type]
        about = field.metadata
        default: Any = defaults.get(field.name, field.default)
        entry = Parameter(
            f"{prefix}.{field.name}",
            default,
            about["meaning"],
            about["unit"],
            about["low"],
            about["high"],
        )
        values[field.name] = take(rest, entry)
    return kind(**values)


def _profile(
    rest: dict[str, object], name: str, settings: DriveSettings, duration: float
) -> Profile:
    """Points of speed and load; what the condition starts with."""
    entry = QUANTITIES[name]
    if name not in _SCRIPTED:
        default = getattr(settings.prior, name)
        return Profile.constant(take(rest, dataclasses.replace(entry, default=default)))
    given = rest.pop(name, entry.default)
    if not isinstance(given, list):
        return Profile.constant(float(entry.check(given)))
    if not 1 <= len(given) <= _MOST_POINTS:
        raise ScenarioError(f"{name} has {len(given)} points; it takes 1 to {_MOST_POINTS}")
    times: list[float] = []
    values: list[float] = []
    for number, point in enumerate(given):
        if not isinstance(point, list) or len(point) != 2:
            raise ScenarioError(f"{name}[{number}] is {point!r}; a point is [time, value]")
        at = Parameter(f"time of {name}[{number}]", None, "", "s", 0.0, duration)
        time = float(at.check(point[0]))
        if times and time < times[-1]:
            raise ScenarioError(
                f"{at.name} is {time:g} s; it must not lie before that of the point before it, "
                f"{times[-1]:g} s"
            )
        times.append(time)
        value = dataclasses.replace(entry, name=f"value of {name}[{number}]").check(point[1])
        values.append(float(value))
    return Profile(tuple(times), tuple(values))


def _entries(given: object, name: str, example: str) -> Iterator[tuple[str, Mapping[str, object]]]:
    """Name and content of each entry of a list."""
    if not isinstance(given, list) or len(given) > _MOST_POINTS:
        raise ScenarioError(f"{name} must be a list of at most {_MOST_POINTS} entries")
    for number, item in enumerate(given):
        if not isinstance(item, dict):
            raise ScenarioError(f"{name}[{number}] is {item!r}; it should be {{{example}}}")
        yield f"{name}[{number}]", item


def _reject_unknown(rest: Mapping[str, object]) -> None:
    if not rest:
        return
    name = next(iter(rest))
    groups = {"condition": ModelError, "motor": Motor, "sensors": SensorErrors}
    known = [entry.name for entry in (*_HEAD, *QUANTITIES.values())] + ["events", "faults"]
    for prefix, kind in groups.items():
        known += [f"{prefix}.{field.name}" for field in dataclasses.fields(kind)]
    near = difflib.get_close_matches(str(name), known, n=1)
    hint = f"; did you mean {near[0]}?" if near else ""
    raise ScenarioError(f"unknown entry {name}{hint}")


def _check_runnable(scenario: Scenario, settings: DriveSettings) -> None:
    """Raise where the belt would lift off its pulleys; between points it can only be better."""
    if scenario.duration * scenario.sample_rate > _MOST_SAMPLES:
        raise ScenarioError(
            f"{scenario.duration:g} s at {scenario.sample_rate:g} Hz are more than "
            f"{_MOST_SAMPLES} samples"
        )
    times = np.unique([time for profile in scenario.profiles for time in profile.times])
    rows = scenario.commands(np.concatenate([times, np.nextafter(times, -np.inf)]))
    speeds = np.abs(rows[:, Command.SPEED]) * settings.drive.driver.radius
    lift = settings.drive.belt.mass_per_length * speeds**2
    tension = rows[:, Command.TENSION]
    if np.any(bad := lift >= tension):
        raise ScenarioError(
            f"the belt lifts off: at {speeds[bad][0]:g} m/s it needs more than {lift[bad][0]:g} N, "
            f"the tension is {tension[bad][0]:g} N; reduce speed or raise condition.tension"
        )
