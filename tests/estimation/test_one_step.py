"""A step in one compiled call is its parts, one after the other, to the last bit."""

import math

import numpy as np
import pytest

from belt_ros.estimation.bank import UnscentedBank
from belt_ros.estimation.foretold_slip import lead_innovation
from belt_ros.estimation.gaussian_sum import mixture_moments, normalised
from belt_ros.estimation.load import Activity
from belt_ros.estimation.one_step import Foretold, take_in_and_weigh
from belt_ros.estimation.process import Wander, drift_processes, drift_wander, prior_state
from belt_ros.estimation.state import STATES, Index
from belt_ros.estimation.torque_told import torques_among
from belt_ros.estimation.weighing import innovations_squared
from belt_ros.mechanics.constants import DriveConstants, drive_constants
from belt_ros.settings import DriveSettings

DT = 0.01
MEMBERS = 5
MODE = np.array([0, 1, 0, 0, 1])
ACTIVITY = Activity((0.4, 0.2), (0.3, 0.2))
UNDEVELOPED = (0.02, 1e-3, 4.0)
SEEN = (
    (Index.DRIVER_SPEED, Index.DRIVEN_SPEED, Index.DRIVER_TORQUE, Index.DRIVEN_TORQUE),
    (Index.DRIVEN_SPEED, Index.DRIVEN_TORQUE, Index.TRAVEL),
    (Index.DRIVER_SPEED,),
    (),
)
_Readings = tuple[np.ndarray, np.ndarray, np.ndarray]


class Drive:
    """Members about a loaded drive, and what is read of it."""

    def __init__(self, settings: DriveSettings, seen: tuple[Index, ...]) -> None:
        random = np.random.default_rng(len(seen))
        self.constants: DriveConstants = drive_constants(settings.drive)
        self.mean, spread = prior_state(settings.prior, settings.drive)
        self.wander: Wander = drift_wander(settings.drift, spread, settings.prior.tension)
        loaded = self.mean.copy()
        loaded[:5] = 100.0, 100.0, 60.0, 6.0, -6.0
        roots = 0.1 * spread * random.standard_normal((MEMBERS, STATES, STATES))
        self.x = loaded + 0.1 * spread * random.standard_normal((MEMBERS, STATES))
        self.covariance = roots.transpose(0, 2, 1) @ roots
        self.weights = random.dirichlet(np.ones(MEMBERS))
        places = np.array(seen, dtype=np.int64)
        variance = (0.1 * spread[places]) ** 2
        self.readings: _Readings = loaded[places], variance, places

    def bank(self) -> UnscentedBank:
        bank = UnscentedBank(self.constants, self.mean)
        bank.x, bank.P = self.x, self.covariance
        return bank

    def step(self, bank: UnscentedBank, change: float) -> Foretold:
        added = self.wander, ACTIVITY, UNDEVELOPED, change
        return bank.step(DT, added, MODE, self.weights, self.readings, crosses=True)


@pytest.fixture(params=SEEN, ids=len)
def drive(settings: DriveSettings, request: pytest.FixtureRequest) -> Drive:
    return Drive(settings, request.param)


@pytest.mark.parametrize("change", [DT, 0.3])
def test_members_move_as_they_are_predicted(drive: Drive, change: float) -> None:
    whole, parts = drive.bank(), drive.bank()
    foretold = drive.step(whole, change)
    processes = drift_processes(drive.wander, drive.constants, ACTIVITY, UNDEVELOPED, DT, change)
    torques = torques_among(*drive.readings)
    crosses = parts.predict(DT, processes, MODE, torques=torques, crosses=True)
    np.testing.assert_array_equal(whole.x, parts.x)
    np.testing.assert_array_equal(whole.P, parts.P)
    np.testing.assert_array_equal(foretold.crosses, crosses)


def test_readings_are_compared_with_what_was_predicted(drive: Drive) -> None:
    bank, (z, variance, places) = drive.bank(), drive.readings
    foretold = drive.step(bank, DT)
    assert foretold.squared.shape == (MEMBERS,)
    assert foretold.least == foretold.squared.min()
    assert foretold.average == pytest.approx(drive.weights @ foretold.squared)
    mean = drive.weights @ bank.x
    within = np.tensordot(drive.weights, bank.P, 1)[np.ix_(places, places)] + np.diag(variance)
    away = z - bank.x[:, places]
    expected = [one @ np.linalg.solve(within, one) if len(one) else 0.0 for one in away]
    np.testing.assert_allclose(foretold.squared, expected, rtol=1e-6)
    surprises = (z - mean[places]) ** 2 / np.diag(within)
    np.testing.assert_allclose(foretold.surprises, surprises, rtol=1e-6, atol=1e-12)
    radii = drive.constants.driver_radius, drive.constants.driven_radius
    lead = lead_innovation(radii, drive.weights, bank.x, bank.P, *drive.readings)
    np.testing.assert_array_equal(foretold.lead, lead)


def test_what_is_taken_in_weighs_the_members_and_sums_them_up(drive: Drive) -> None:
    bank, log_weights = drive.bank(), np.log(drive.weights)
    squared, _ = innovations_squared(bank.x, bank.P, drive.weights, *drive.readings)
    x, covariance, logs, weights, mean, spread, finite = take_in_and_weigh(
        bank.x, bank.P, log_weights, squared, *drive.readings
    )
    bank.update(*drive.readings)
    np.testing.assert_array_equal(x, bank.x)
    np.testing.assert_array_equal(covariance, bank.P)
    expected = drive.weights * np.exp(-0.5 * squared)
    np.testing.assert_allclose(weights, expected / expected.sum(), rtol=1e-12)
    np.testing.assert_array_equal(weights, normalised(logs))
    for ours, theirs in zip((mean, spread), mixture_moments(weights, x, covariance), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    assert finite


@pytest.mark.parametrize("broken", [math.nan, math.inf, -math.inf])
def test_a_member_that_is_not_finite_is_told_of(drive: Drive, broken: float) -> None:
    bank, squared = drive.bank(), np.zeros(MEMBERS)
    means = bank.x.copy()
    means[2, Index.LOG_TENSION] = broken
    *_, finite = take_in_and_weigh(means, bank.P, np.zeros(MEMBERS), squared, *drive.readings)
    assert not finite
