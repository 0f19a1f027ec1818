"""Whether slip is what was foretold: noise never says no, a drift soon does."""

import math

import numpy as np
import pytest

from belt_ros.estimation.foretold_slip import ForetoldSlip, lead_innovation
from belt_ros.estimation.state import STATES, Index
from belt_ros.mechanics.constants import DriveConstants, drive_constants
from belt_ros.settings import DriveSettings

DT = 0.02
NOISE = 0.05  # of either speed [rad/s]
SPEEDS = np.array([Index.DRIVER_SPEED, Index.DRIVEN_SPEED])
MEMBERS = 4


class Foretold:
    """A Gaussian sum, as a population shows itself."""

    def __init__(self, seed: int, members: int = MEMBERS, spread: float = 0.01) -> None:
        random = np.random.default_rng(seed)
        self.weights = random.dirichlet(np.ones(members))
        self.means = 100.0 + spread * random.standard_normal((members, STATES))
        roots = spread * random.standard_normal((members, STATES, STATES))
        self.covariances = roots @ roots.transpose(0, 2, 1)

    def mixture(self) -> tuple[np.ndarray, np.ndarray]:
        mean = self.weights @ self.means
        about = self.means - mean
        between = (about.T * self.weights) @ about
        return mean, np.tensordot(self.weights, self.covariances, 1) + between


@pytest.fixture(scope="module")
def constants(settings: DriveSettings) -> DriveConstants:
    return drive_constants(settings.drive)


def lead(constants: DriveConstants, foretold: Foretold, z, places=SPEEDS) -> float:
    z, places = np.asarray(z, dtype=float), np.asarray(places, dtype=np.int64)
    radii = constants.driver_radius, constants.driven_radius
    sums = foretold.weights, foretold.means, foretold.covariances
    return lead_innovation(radii, *sums, z, np.full(z.size, NOISE**2), places)


@pytest.mark.parametrize("read", [(0,), (1,), (0, 1), (1, 0), (2, 0, 1)])
@pytest.mark.parametrize("seed", range(3))
def test_the_innovation_is_that_of_the_whole_sum(seed: int, read: tuple[int, ...]) -> None:
    foretold, radii = Foretold(seed), (0.08, 0.11)
    z = 100.0 + 0.1 * np.random.default_rng(seed).standard_normal(len(read))
    variance = np.full(len(read), NOISE**2)
    across = np.zeros(STATES)
    noise = read_off = 0.0
    for at, value in zip(read, z, strict=True):
        if at < 2:
            across[at] = (radii[0], -radii[1])[at]
            read_off += across[at] * value
            noise += across[at] ** 2 * NOISE**2
    mean, covariance = foretold.mixture()
    expected = (read_off - across @ mean) / math.sqrt(across @ covariance @ across + noise)

    found = lead_innovation(
        radii,
        foretold.weights,
        foretold.means,
        foretold.covariances,
        z,
        variance,
        np.array(read),
    )

    assert found == pytest.approx(expected, rel=1e-6)


def test_without_a_speed_there_is_no_innovation_and_nothing_fails(constants) -> None:
    foretold, slip = Foretold(0), ForetoldSlip()
    for _ in range(50):
        slip.compare(lead(constants, foretold, [1e9], [Index.DRIVER_TORQUE]), DT)
    assert not slip.failed


def play(constants, seed: int, drift: float, steps: int, dt: float = DT) -> list[bool]:
    """Whether it has failed after each step; `drift` is in deviations of the noise."""
    random, slip = np.random.default_rng(seed), ForetoldSlip()
    foretold = Foretold(seed, spread=1e-9)
    failed = []
    for _ in range(steps):
        z = 100.0 + NOISE * random.standard_normal(2)
        z[1] -= drift * NOISE
        slip.compare(lead(constants, foretold, z), dt)
        failed.append(slip.failed)
    return failed


@pytest.mark.parametrize("dt", [0.005, 0.02, 0.1, 1.0])
def test_noise_is_what_was_foretold(constants, dt: float) -> None:
    assert np.mean([play(constants, seed, 0.0, 500, dt) for seed in range(10)]) < 0.06


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_slip_that_stays_aside_is_noticed_within_a_quarter_of_a_second(constants, side) -> None:
    failed = np.array([play(constants, seed, side * 2.5, 25) for seed in range(20)])
    assert np.all(np.any(failed, axis=1))
    assert np.median(np.argmax(failed, axis=1)) * DT < 0.25


def test_one_reading_alone_proves_nothing_however_far_off_it_is(constants) -> None:
    foretold, slip = Foretold(1, spread=1e-9), ForetoldSlip()
    for _ in range(50):
        slip.compare(lead(constants, foretold, [100.0, 100.0]), DT)
    slip.compare(lead(constants, foretold, [100.0, -1e9]), DT)
    assert not slip.failed
    for value in (math.inf, math.nan):
        slip.compare(lead(constants, foretold, [value, 100.0]), DT)
    assert not slip.failed
    slip.compare(lead(constants, foretold, [100.0, -1e9]), DT)
    assert slip.failed


def test_a_start_forgets_what_was_not_foretold(constants) -> None:
    foretold, slip = Foretold(1, spread=1e-9), ForetoldSlip()
    for _ in range(9):
        slip.compare(lead(constants, foretold, [110.0, 100.0]), DT)
    assert slip.failed
    slip.start()
    assert not slip.failed
