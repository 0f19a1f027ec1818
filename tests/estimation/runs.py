"""Runs of the virtual rig, what the monitor makes of them, and how the two compare."""

import dataclasses
import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from belt_ros.estimation import (
    BeltEstimate,
    Measurement,
    MonitorOutput,
    Quantity,
)
from belt_ros.rig import measured
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.rig.truth import Truth
from belt_ros.settings import DriveSettings

ROOT = Path(__file__).resolve().parents[2]


@dataclasses.dataclass
class Run:
    """One scenario: measurements, truth and the monitor's outputs, sample by sample."""

    settings: DriveSettings
    measurements: list[Measurement]
    truths: list[Truth]
    outputs: list[MonitorOutput]

    def at(self, seconds: float) -> tuple[BeltEstimate, Truth]:
        period = self.measurements[1].stamp_ns - self.measurements[0].stamp_ns
        index = round(seconds * 1e9 / period)
        estimate = self.outputs[index].estimate
        assert estimate is not None
        return estimate, self.truths[index]


Runner = Callable[..., Run]


def scripted(settings: DriveSettings, **scenario: object) -> Iterator[tuple[Measurement, Truth]]:
    named = {name.replace("__", "."): value for name, value in scenario.items()}
    yield from measured(settings, scenario_from_mapping(named, settings))


def numbers(estimate: BeltEstimate) -> Iterator[float]:
    """Every number in an estimate."""
    for field in dataclasses.fields(estimate):
        value = getattr(estimate, field.name)
        if isinstance(value, Quantity):
            yield from value
        elif isinstance(value, float):
            yield value
    yield estimate.health.innovation_squared


def assert_sound(estimate: BeltEstimate) -> None:
    """No NaN, no infinity, no negative standard deviation."""
    assert all(math.isfinite(number) for number in numbers(estimate)), estimate
    for field in dataclasses.fields(estimate):
        value = getattr(estimate, field.name)
        if isinstance(value, Quantity):
            assert value.stddev >= 0.0, field.name


def within(quantity: Quantity, truth: float, sigmas: float = 1.96) -> bool:
    """Whether the truth lies in the quantity's own interval."""
    low, high = quantity.interval(sigmas)
    return bool(low <= truth <= high)


def coverage(run: Run, name: str, start: float) -> float:
    """Share of samples after `start` [s] in which the 95 % interval of `name` holds the truth."""
    first = run.measurements[0].stamp_ns + round(start * 1e9)
    return float(
        np.mean(
            [
                within(getattr(output.estimate, name), getattr(truth, name))
                for m, truth, output in zip(run.measurements, run.truths, run.outputs, strict=True)
                if m.stamp_ns >= first and output.estimate is not None
            ]
        )
    )
