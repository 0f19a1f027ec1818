"""A drive's creep differs from the model's as the estimator takes it to."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from belt_ros.estimation.process import UndevelopedCreep
from belt_ros.mechanics.constants import DriveConstants, drive_constants
from belt_ros.rig import RigSample
from belt_ros.rig.model_error import CreepErrors, ModelError
from belt_ros.settings import DriveSettings

PULL, PER_PULL, RIM, DT = 300.0, 2e-5, 10.0, 0.01  # [N], [1/N], [m/s], [s]
DRAWS = 2000
FROM_REST = 120.0  # [N]


@pytest.fixture
def constants(settings: DriveSettings) -> DriveConstants:
    return drive_constants(settings.drive)


def after_a_change(constants: DriveConstants, steps: int, share: float = 1.0) -> np.ndarray:
    """Slip beside creep in steps after a sudden change of pull: (`DRAWS`, `steps`)."""
    random = np.random.default_rng(3)
    beside = np.empty((DRAWS, steps))
    for row in beside:
        creep = CreepErrors(ModelError(undeveloped_creep=share), constants, random)
        creep.start(FROM_REST)
        for step in range(steps):
            creep.advance(PULL, PER_PULL, RIM, DT)
            row[step] = creep.beside
    return beside


@pytest.mark.parametrize("share", [1.0, 0.3])
def test_slip_beside_creep_is_as_wide_as_the_estimator_allows(
    constants: DriveConstants, share: float
) -> None:
    allowed = UndevelopedCreep(constants)
    allowed.start(FROM_REST, developed=FROM_REST)
    variance, expected = 0.0, []
    for _ in range(12):
        renewed, deviation, _ = allowed.advance(PULL, PER_PULL, RIM, DT)
        gained = renewed * (2.0 - renewed) * deviation**2
        variance = (1.0 - renewed) ** 2 * variance + gained
        expected.append(share * math.sqrt(variance))
    drawn = after_a_change(constants, 12, share)
    assert np.std(drawn, axis=0) == pytest.approx(expected, rel=0.08)
    assert np.mean(drawn, axis=0) == pytest.approx(np.zeros(12), abs=0.1 * max(expected))


def test_nothing_is_beside_creep_that_has_developed(constants: DriveConstants) -> None:
    creep = CreepErrors(ModelError(undeveloped_creep=1.0), constants, np.random.default_rng(3))
    creep.start(PULL)
    for _ in range(10):
        creep.advance(PULL, PER_PULL, RIM, DT)
    assert creep.beside == 0.0


def test_creep_of_a_belt_that_stands_does_not_develop(constants: DriveConstants) -> None:
    creep = CreepErrors(ModelError(undeveloped_creep=1.0), constants, np.random.default_rng(3))
    creep.start(FROM_REST)
    creep.advance(PULL, PER_PULL, RIM, DT)
    left = creep.beside
    assert left != 0.0
    for _ in range(10):
        creep.advance(PULL, PER_PULL, 0.0, DT)
    assert creep.beside == left


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_belt_is_never_drawn_to_slip_against_the_power(
    constants: DriveConstants, direction: float
) -> None:
    random, least = np.random.default_rng(3), math.inf
    unloaded = 0.2 * PULL * direction
    for _ in range(DRAWS // 10):
        creep = CreepErrors(
            ModelError(undeveloped_creep=1.0, creep_error_stddev=0.1), constants, random
        )
        creep.start(PULL * direction)
        for _ in range(12):
            creep.advance(unloaded, PER_PULL, RIM, DT)
            slip = PER_PULL * unloaded * (1.0 + creep.relative) + creep.beside
            least = min(least, slip * direction)
    assert least == pytest.approx(0.0, abs=1e-12)


def excess(samples: list[RigSample], begin: float, end: float) -> np.ndarray:
    return np.array(
        [s.truth.excess_slip for s in samples if begin < s.stamp_ns * 1e-9 <= end],
    )


def test_a_plant_slips_beside_its_creep_until_the_arcs_have_been_replaced(
    run: Callable[..., list[RigSample]],
) -> None:
    script = {"duration": 2.0, "speed": 120.0, "load": [[0.5, 10.0], [0.6, 40.0]]}
    exact = run(**script)
    other = run(**script, condition__undeveloped_creep=1.0)

    beside = excess(other, 0.5, 0.7) - excess(exact, 0.5, 0.7)
    assert np.max(np.abs(beside)) > 1e-4
    assert np.max(np.abs(excess(other, 1.8, 2.0))) < 1e-7


def test_a_plant_whose_creep_is_wildly_beside_stays_finite(
    run: Callable[..., list[RigSample]],
) -> None:
    samples = run(
        duration=1.0,
        speed=[[0.0, 0.0], [0.3, 20.0], [0.6, -20.0]],
        load=[[0.2, 0.0], [0.25, 90.0]],
        condition__undeveloped_creep=10.0,
    )
    truths = [sample.truth for sample in samples]
    assert np.all(np.isfinite([[t.slip, t.driven_speed, t.tight_tension] for t in truths]))
