"""What is judged: an estimate's error and stated deviation in each quantity, and a run's rows."""

import hashlib
import math
import time
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

import belt_ros
from belt_ros.estimation import BeltEstimate, BeltMonitor, Measurement, Quantity
from belt_ros.estimation.estimate import log_spread
from belt_ros.mechanics import Tensioning
from belt_ros.rig.truth import Truth
from belt_ros.settings import DriveSettings

QUANTITIES = ("slip", "tight_tension", "slack_tension", "margin", "ln_kf", "ln_tension", "ln_mu")
PARAMETERS = ("ln_tension", "ln_kf", "ln_mu")
INTERVALS = ("slip", "tight_tension", "slack_tension", "ln_kf", "margin")
_WARM_UP = 50  # samples, in which code may have to be compiled

Quantities = dict[str, Quantity]


class Row(NamedTuple):
    """One judged instant of one run."""

    method: str
    case: str
    seed: int
    time: float  # [s]
    microseconds: float  # of processor a sample, mean over the run
    sources: str
    errors: tuple[float, ...]  # estimate less truth, as `QUANTITIES`
    stddevs: tuple[float, ...]  # stated; NaN where none is
    nees: float = math.nan  # per degree of freedom, of `PARAMETERS` together; NaN: not known


class Estimator(Protocol):
    """Whatever is judged."""

    def step(self, measurement: Measurement) -> None:
        """Take in a measurement."""

    def quantities(self) -> Quantities:
        """Return what is known now, by name in `QUANTITIES`."""


class Own:
    """The estimator of belt_ros, by its public face."""

    def __init__(self, settings: DriveSettings) -> None:
        self._monitor: BeltMonitor = settings.monitor()
        # Elsewhere what is held, which is what is learned, is not what the truth tells: the mean.
        self._mean_is_held = settings.drive.tensioning is Tensioning.CONSTANT_MEAN

    def step(self, measurement: Measurement) -> None:
        """Take in a measurement."""
        self._monitor.step(measurement)

    def quantities(self) -> Quantities:
        """Return what is known now."""
        estimate = self._monitor.estimate
        assert estimate is not None, "the rig's first measurement is a good one"
        return of_estimate(estimate)

    def nees(self, true: dict[str, float]) -> float:
        """Error squared of `PARAMETERS`, normalised by their covariance, per degree of freedom.

        NaN for a drive of which something other than the mean tension is held.
        """
        learned = self._monitor.learned(0.0)
        if learned is None or not self._mean_is_held:
            return math.nan
        weights, count = learned.weights, len(PARAMETERS)
        mean = weights @ learned.means
        about = learned.means - mean
        covariance = np.tensordot(weights, learned.covariances, 1) + (about.T * weights) @ about
        error = mean[:count] - [true[name] for name in PARAMETERS]
        return float(error @ np.linalg.solve(covariance[:count, :count], error)) / count


def of_estimate(estimate: BeltEstimate) -> Quantities:
    """Return what is judged of an estimate."""
    mean, friction = estimate.mean_tension, estimate.friction_coefficient
    log_variance = math.log1p((mean.stddev / mean.value) ** 2)
    return {
        "slip": estimate.slip,
        "tight_tension": estimate.tight_tension,
        "slack_tension": estimate.slack_tension,
        "margin": estimate.margin,
        "ln_kf": Quantity(
            math.log(estimate.friction_stiffness.value), estimate.friction_stiffness_log_stddev
        ),
        "ln_tension": Quantity(math.log(mean.value) - 0.5 * log_variance, math.sqrt(log_variance)),
        "ln_mu": Quantity(math.log(friction.value), log_spread(friction)),
    }


def of_truth(truth: Truth) -> dict[str, float]:
    """Return what is judged of the truth."""
    return {
        "slip": truth.slip,
        "tight_tension": truth.tight_tension,
        "slack_tension": truth.slack_tension,
        "margin": truth.margin,
        "ln_kf": math.log(truth.friction_stiffness),
        "ln_tension": math.log(truth.mean_tension),
        "ln_mu": math.log(truth.friction_coefficient),
    }


def judge(
    estimator: Estimator,
    samples: Iterable[tuple[Measurement, Truth]],
    instants: tuple[float, ...],
    method: str,
    case: str,
    seed: int,
) -> list[Row]:
    """Run an estimator over the samples of a drive; judge it at `instants` [s]."""
    waiting = list(instants)
    found: list[tuple[float, Quantities, dict[str, float], float]] = []
    drive = list(samples)  # simulated before the clock starts, which is read seldom: it can be dear
    began, judging = time.process_time(), 0.0
    for number, (measurement, truth) in enumerate(drive):
        if number == _WARM_UP:
            began, judging = time.process_time(), 0.0
        estimator.step(measurement)
        if waiting and measurement.stamp_ns >= waiting[0] * 1e9:
            paused = time.process_time()
            true = of_truth(truth)
            nees = estimator.nees(true) if isinstance(estimator, Own) else math.nan
            found.append((waiting.pop(0), estimator.quantities(), true, nees))
            judging += time.process_time() - paused
    spent = time.process_time() - began - judging
    cost = spent / max(len(drive) - _WARM_UP, 1) * 1e6
    return [
        Row(
            method,
            case,
            seed,
            instant,
            cost,
            SOURCES,
            tuple(quantities[name].value - true[name] for name in QUANTITIES),
            tuple(quantities[name].stddev for name in QUANTITIES),
            nees,
        )
        for instant, quantities, true, nees in found
    ]


def _sources() -> str:
    """Digest of what is judged, and of what it is judged on: different code is not to be mixed."""
    root, here = Path(belt_ros.__file__).parent, Path(__file__).parent
    digest = hashlib.sha256()
    for package in ("mechanics", "estimation", "rig"):
        for source in sorted((root / package).rglob("*.py")):
            digest.update(source.read_bytes())
    for source in sorted(here.glob("*.py")):
        if not source.stem.endswith("report"):
            digest.update(source.read_bytes())
    return digest.hexdigest()[:8]


SOURCES = _sources()
