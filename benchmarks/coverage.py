"""Do the stated intervals hold the truth? Random drives of the rig, drawn from the priors.

Each drive's tension, friction, kf, creep error and radius-ratio bias are drawn from the priors that
the estimator is given; the load takes two to four levels of 30 to 95 % of the true capacity.
"""

import dataclasses
import math
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np

from belt_ros.estimation import BeltEstimate
from belt_ros.estimation.process import lognormal
from belt_ros.mechanics import torque_capacity
from belt_ros.rig import measured
from belt_ros.rig.scenario import Scenario, scenario_from_mapping
from belt_ros.rig.truth import Truth
from belt_ros.settings import DriveSettings, load_settings

CONFIG = Path(__file__).resolve().parents[1] / "config"
CONFIGURATIONS = ("demo_drive", "paper_drive")
JUDGED_AT = (3.0, 6.0, 9.5)  # [s]
QUANTITIES = ("slip", "tight_tension", "slack_tension", "margin", "accumulated_slip")
LOG_STIFFNESS = "ln kf"
DURATION = 10.0
SPEED = 120.0


@dataclasses.dataclass(frozen=True)
class Judged:
    """Errors over their stated standard deviations, by quantity and instant."""

    scores: dict[str, list[float]]


def drawn(settings: DriveSettings, seed: int) -> Scenario:
    """Return a scenario whose drive is a draw from the priors."""
    random = np.random.default_rng(1000 + seed)
    prior = settings.prior
    tension = math.exp(_normal(random, *lognormal(prior.tension, prior.tension_stddev)))
    friction = math.exp(
        _normal(random, *lognormal(prior.friction_coefficient, prior.friction_coefficient_stddev))
    )
    decades = prior.friction_stiffness_decades * random.standard_normal()
    drive = dataclasses.replace(
        settings.drive,
        driven=dataclasses.replace(settings.drive.driven, friction_coefficient=friction),
        driver=dataclasses.replace(settings.drive.driver, friction_coefficient=friction),
    )
    capacity = float(torque_capacity(drive, tension, SPEED))
    values: dict[str, object] = {
        "duration": DURATION,
        "seed": seed + 1,
        "speed": [[0.0, 0.0], [1.0, SPEED]],
        "condition.tension": tension,
        "condition.friction_coefficient": friction,
        "condition.friction_stiffness": prior.friction_stiffness * 10.0**decades,
        "condition.creep_error": _normal(random, 0.0, prior.creep_error_stddev),
        "condition.ratio_bias": _normal(random, 0.0, prior.ratio_bias_stddev),
        "load": _load(random, capacity),
    }
    return scenario_from_mapping(values, settings)


def _normal(random: np.random.Generator, mean: float, stddev: float) -> float:
    return float(mean + stddev * random.standard_normal())


def _load(random: np.random.Generator, capacity: float) -> list[list[float]]:
    levels = capacity * random.uniform(0.3, 0.95, int(random.integers(2, 5)))
    points = [[1.3, 0.0]]
    for begin, level in zip(np.linspace(1.5, 9.0, len(levels) + 1), levels, strict=False):
        points += [[float(begin), points[-1][1]], [float(begin) + 0.2, float(level)]]
    return points


def judge(configuration: str, seed: int) -> Judged:
    """Run one drive through a fresh monitor."""
    settings = load_settings(CONFIG / f"{configuration}.yaml")
    monitor = settings.monitor()
    scores: dict[str, list[float]] = {name: [] for name in (*QUANTITIES, LOG_STIFFNESS)}
    waiting = list(JUDGED_AT)
    for measurement, truth in measured(settings, drawn(settings, seed)):
        monitor.step(measurement)
        if waiting and measurement.stamp_ns >= waiting[0] * 1e9:
            waiting.pop(0)
            assert monitor.estimate is not None
            for name, score in _scores(monitor.estimate, truth):
                scores[name].append(score)
    return Judged(scores)


def _scores(estimate: BeltEstimate, truth: Truth) -> Iterator[tuple[str, float]]:
    for name in QUANTITIES:
        quantity = getattr(estimate, name)
        yield name, (quantity.value - getattr(truth, name)) / quantity.stddev
    error = math.log(estimate.friction_stiffness.value / truth.friction_stiffness)
    yield LOG_STIFFNESS, error / estimate.friction_stiffness_log_stddev


def campaign(drives: int, workers: int) -> Iterator[tuple[str, Judged]]:
    """Judge `drives` random drives of each configuration."""
    with ProcessPoolExecutor(workers) as pool:
        for configuration in CONFIGURATIONS:
            for judged in pool.map(partial(judge, configuration), range(drives)):
                yield configuration, judged


def table(results: list[tuple[str, Judged]]) -> list[str]:
    """Return the results as a Markdown table."""
    header = " | ".join(f"{instant:g} s" for instant in JUDGED_AT)
    lines = [
        f"| drive | quantity | {header} | mean z | rms z | worst z |",
        "| --- | --- |" + " ---: |" * (len(JUDGED_AT) + 3),
    ]
    for configuration in CONFIGURATIONS:
        runs = [judged for name, judged in results if name == configuration]
        for quantity in (*QUANTITIES, LOG_STIFFNESS):
            z = np.array([judged.scores[quantity] for judged in runs])
            held = " | ".join(f"{share:.0%}" for share in np.mean(np.abs(z) < 1.96, axis=0))
            worst = z.flat[int(np.argmax(np.abs(z)))]
            lines.append(
                f"| {configuration} | {quantity.replace('_', ' ')} | {held} | {z.mean():+.2f} | "
                f"{np.sqrt(np.mean(z**2)):.2f} | {worst:+.1f} |"
            )
    return lines
