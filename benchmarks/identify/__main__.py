"""Coverage of the intervals of `belt identify`, on drives drawn from their priors, on the rig.

`python -m benchmarks.identify --draws 48` prints a table. Loads rise in four steps to a share of
the true capacity; the belt creeps by another percentage than the model says in each drive.
"""

import argparse
import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from belt_ros.estimation.process import prior_state
from belt_ros.identify import Identified, Interval, identify_measurements
from belt_ros.identify.model import BELT
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.creep import pull_capacity
from belt_ros.rig import measured
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.settings import DriveSettings, load_settings

ROOT = Path(__file__).resolve().parents[2]
QUANTITIES = (
    "tension",
    "friction_stiffness",
    "friction_coefficient",
    "ratio_bias",
    "capacity",
)
_STEPS = (0.0, 0.25, 0.5, 0.75, 1.0)  # of the greatest load
_HOLD = 2.5  # [s]
_CASES = (
    ("demo_drive", 0.85),
    ("demo_drive", 0.3),
    ("paper_drive", 0.85),
    ("paper_drive", 0.3),
)


class Draw(NamedTuple):
    """What is true of a drive."""

    values: dict[str, float]
    creep_error: float


def drawn(settings: DriveSettings, random: np.random.Generator) -> Draw:
    """Draw a belt from the priors."""
    mean, stddev = prior_state(settings.prior, settings.drive)
    tension, stiffness, friction, bias = random.normal(mean[list(BELT)], stddev[list(BELT)])
    values = {
        "tension": math.exp(tension),
        "friction_stiffness": math.exp(stiffness),
        "friction_coefficient": math.exp(friction),
        "ratio_bias": float(bias),
    }
    constants = drive_constants(settings.drive)
    speed = 120.0 * settings.drive.driver.radius
    pull = pull_capacity(
        constants,
        values["tension"],
        values["friction_coefficient"],
        values["friction_stiffness"],
        speed,
        True,  # noqa: FBT003 - compiled code takes no keywords
    )
    values["capacity"] = pull * settings.drive.driven.radius
    return Draw(values, float(random.normal(0.0, settings.prior.creep_error_stddev)))


def ran(settings: DriveSettings, draw: Draw, share: float, seed: int) -> Identified:
    """Run the rig with loads up to a share of the capacity, and identify."""
    begin = 2.5
    load: list[list[float]] = []
    for step in _STEPS:
        level = step * share * draw.values["capacity"]
        load += [[begin + (0.2 if load else 0.0), level], [begin + _HOLD, level]]
        begin += _HOLD
    condition = {
        f"condition.{name}": value for name, value in draw.values.items() if name != "capacity"
    }
    scenario = scenario_from_mapping(
        {
            "duration": begin,
            "sample_rate": 100.0,
            "seed": seed,
            "speed": [[0.2, 0.0], [2.2, 120.0]],
            "load": load,
            "condition.creep_error": draw.creep_error,
            **condition,
        },
        settings,
    )
    return identify_measurements((one for one, _ in measured(settings, scenario)), settings)


def _lines(draws: int) -> Iterator[str]:
    yield f"| drive | greatest load | quantity | held in {draws} | told in | share of prior |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for name, share in _CASES:
        settings = load_settings(ROOT / "config" / f"{name}.yaml")
        random = np.random.default_rng(20250615)
        found: dict[str, list[tuple[bool, Interval]]] = {one: [] for one in QUANTITIES}
        unlikely = 0
        for seed in range(draws):
            draw = drawn(settings, random)
            result = ran(settings, draw, share, seed)
            unlikely += result.goodness.probability < 0.01
            for one in QUANTITIES:
                interval: Interval = getattr(result, one)
                holds = interval.low <= draw.values[one] <= interval.high
                found[one].append((holds, interval))
        for one, results in found.items():
            held = sum(good for good, _ in results)
            told = sum(interval.told for _, interval in results)
            width = float(np.median([interval.share for _, interval in results]))
            yield f"| {name} | {share:.0%} | {one} | {held} | {told} | {width:.2f} |"
        yield f"| {name} | {share:.0%} | fit refused | {unlikely} | | |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=48)
    for line in _lines(parser.parse_args().draws):
        print(line, flush=True)


if __name__ == "__main__":
    main()
