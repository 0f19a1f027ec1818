"""Entries of a scenario's lists of events and faults, checked; the same may be asked for live."""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from belt_ros.parameter_table import Parameter, SettingsError
from belt_ros.rig.faults import ALL, PLACES, Fault, FaultKind

_GREATEST = 1e9
_LONGEST = 1e6  # [s]


class ScenarioError(SettingsError):
    """A scenario that cannot be run; the message names entry, value and limit."""


QUANTITIES = {
    "speed": Parameter("speed", 0.0, "of the driver", "rad/s", -_GREATEST, _GREATEST),
    "load": Parameter("load", 0.0, "against positive rotation", "N m", -_GREATEST, _GREATEST),
    "tension": Parameter("condition.tension", None, "as held", "N", 1e-3, 1e9),
    "friction_coefficient": Parameter(
        "condition.friction_coefficient", None, "mu", "-", 1e-3, 10.0
    ),
    "friction_stiffness": Parameter("condition.friction_stiffness", None, "kf", "N/m2", 1.0, 1e15),
}

_KIND = Parameter("kind", None, "what goes wrong", choices=tuple(kind.value for kind in FaultKind))
_SENSOR = Parameter("sensor", ALL, "what it concerns", choices=tuple(PLACES))
_DURATION = Parameter("duration", math.inf, "how long it lasts", "s", 0.0)
_SHARE = Parameter("share", 1.0, "of the readings that it hits", "-", 0.0, 1.0)


class _Use(NamedTuple):
    """What a kind of fault needs to be told."""

    value: Parameter | None = None
    sensors: tuple[str, ...] = tuple(PLACES)
    by_share: bool = False  # may hit some readings only
    duration: float = math.inf  # unless told


_SINGLE = tuple(name for name, places in PLACES.items() if len(places) == 1)
_UNIT = "as in the joint state"
_USES: dict[FaultKind, _Use] = {
    FaultKind.DROPOUT: _Use(by_share=True),
    FaultKind.STUCK: _Use(),
    FaultKind.SPIKE: _Use(
        Parameter("value", None, "what is added", _UNIT, -_GREATEST, _GREATEST),
        _SINGLE,
        by_share=True,
        duration=0.0,
    ),
    FaultKind.QUANTISED: _Use(
        Parameter("value", None, "the step", _UNIT, 1e-9, _GREATEST), _SINGLE
    ),
    FaultKind.DELAYED: _Use(Parameter("value", None, "by how much", "s", 1e-9, _LONGEST)),
    FaultKind.REORDERED: _Use(None, (ALL,)),
    FaultKind.TIME_JUMP: _Use(
        Parameter("value", None, "added to the stamps", "s", -_LONGEST, _LONGEST), (ALL,)
    ),
    FaultKind.WRONG_SIGN: _Use(),
}


@dataclass(frozen=True)
class Event:
    """A quantity of the drive moves to a value, within `over` [s] from `at` [s] on."""

    quantity: str
    at: float
    target: float
    over: float


def take(rest: dict[str, object], entry: Parameter) -> Any:
    """Remove an entry from `rest` and return its checked value.

    Raises
    ------
    ScenarioError
        If it is missing and has no default.
    SettingsError
        If its value is not admissible.
    """
    value = rest.pop(entry.name, entry.default)
    if value is None:
        what = f"one of {', '.join(entry.choices)}" if entry.choices else f"[{entry.unit}]"
        raise ScenarioError(f"{entry.name} is missing: {entry.meaning}, {what}")
    return entry.check(value)


def read_event(
    name: str, given: Mapping[str, object], duration: float, *, longest: float | None = None
) -> Event:
    """Check an event of a run that takes `duration` [s]; errors call it `name`.

    It may take as long as the run does, or as `longest` [s].

    Raises
    ------
    ScenarioError
        Unless it sets exactly one quantity, to an admissible value at an admissible time.
    """
    rest = dict(given)
    named = [quantity for quantity in QUANTITIES if quantity in rest]
    if len(named) != 1:
        raise ScenarioError(f"{name} must set exactly one of {', '.join(QUANTITIES)}")
    quantity = named[0]
    entry = dataclasses.replace(QUANTITIES[quantity], name=f"{quantity} of {name}")
    target = float(entry.check(rest.pop(quantity)))
    over = Parameter("over", 0.0, f"how long {name} takes", "s", 0.0, longest or duration)
    try:
        event = Event(quantity, take(rest, _at(name, duration)), target, take(rest, over))
    except SettingsError as error:
        raise ScenarioError(f"{name}: {error}") from error
    _refuse_rest(name, rest)
    return event


def read_fault(name: str, given: Mapping[str, object], duration: float) -> Fault:
    """Check a fault of a run that takes `duration` [s]; errors call it `name`.

    Raises
    ------
    ScenarioError
        If an entry is missing, unknown, not admissible, or of no use to this kind of fault.
    """
    rest = dict(given)
    try:
        fault = _fault(rest, duration)
    except SettingsError as error:
        raise ScenarioError(f"{name}: {error}") from error
    _refuse_rest(name, rest)
    return fault


def _fault(rest: dict[str, object], duration: float) -> Fault:
    kind = FaultKind(take(rest, _KIND))
    use = _USES[kind]
    sensor = take(rest, _SENSOR)
    if sensor not in use.sensors:
        raise ScenarioError(f"sensor is {sensor!r}; {kind.value} takes {', '.join(use.sensors)}")
    at = take(rest, _at("it", duration))
    lasts = take(rest, dataclasses.replace(_DURATION, default=use.duration))
    value = take(rest, use.value) if use.value else math.nan
    share = take(rest, _SHARE) if use.by_share else 1.0
    return Fault(kind, at, at + lasts, sensor, value, share)


def _at(name: str, duration: float) -> Parameter:
    return Parameter("at", None, f"when {name} begins", "s", 0.0, duration)


def _refuse_rest(name: str, rest: Mapping[str, object]) -> None:
    if rest:
        raise ScenarioError(f"{name} has an unknown entry {next(iter(rest))}")
