"""A load is seen to move by the slip, too: by as much as creep in the contact makes of it."""

import dataclasses
import math

import numpy as np
import pytest

from belt_ros.estimation.load_following import LoadFollowing
from belt_ros.estimation.process import drift_wander, prior_state
from belt_ros.estimation.sensing import NO_LOADS, Sensed
from belt_ros.estimation.state import Index, slip_per_pull
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.drive import BeltDrive
from belt_ros.settings import DriveSettings

DT = 0.05
SPEED = 120.0  # [rad/s]
PULL = 300.0  # [N]


def drive_with(settings: DriveSettings, stiffness: float) -> BeltDrive:
    drive = settings.drive
    return dataclasses.replace(
        drive,
        driven=dataclasses.replace(drive.driven, friction_stiffness=stiffness),
        driver=dataclasses.replace(drive.driver, friction_stiffness=stiffness),
    )


def state_of(settings: DriveSettings, drive: BeltDrive, pull: float) -> np.ndarray:
    state, _ = prior_state(settings.prior, drive)
    state[[Index.DRIVER_SPEED, Index.DRIVEN_SPEED]] = SPEED
    state[Index.PULL] = pull
    state[Index.LOG_STIFFNESS] = math.log(drive.driven.friction_stiffness)
    return state


def test_creep_of_a_stiff_contact_is_the_strain_of_the_belt(settings: DriveSettings) -> None:
    drive = drive_with(settings, 1e10)
    slope = slip_per_pull(drive_constants(drive), state_of(settings, drive, PULL))
    assert slope == pytest.approx(1.0 / drive.belt.axial_stiffness, rel=0.02)


def test_creep_of_a_compliant_contact_is_far_more(settings: DriveSettings) -> None:
    drive = drive_with(settings, 2e5)
    slope = slip_per_pull(drive_constants(drive), state_of(settings, drive, PULL))
    assert slope > 5.0 / drive.belt.axial_stiffness


@pytest.mark.parametrize("pull", [-300.0, -1e-9, 0.0, 1e-9, 300.0, 1e6])
def test_creep_per_pull_is_a_number_at_any_pull(settings: DriveSettings, pull: float) -> None:
    drive = drive_with(settings, 6e6)
    state = state_of(settings, drive, pull)
    slope = slip_per_pull(drive_constants(drive), state)
    assert 1.0 / drive.belt.axial_stiffness <= slope < math.inf
    state[[Index.DRIVER_SPEED, Index.DRIVEN_SPEED]] = 0.0
    assert 0.0 < slip_per_pull(drive_constants(drive), state) < math.inf


@pytest.mark.parametrize("seed", range(6))
def test_slip_of_a_compliant_contact_tells_how_fast_the_load_moves(
    settings: DriveSettings, seed: int
) -> None:
    """Taken for the belt's strain, it would speak for the greatest wander there is."""
    drive = drive_with(settings, 2e5)
    c = drive_constants(drive)
    _, stddev = prior_state(settings.prior, drive)
    wander = drift_wander(settings.drift, stddev, settings.prior.tension)
    following, random = LoadFollowing(c), np.random.default_rng(seed)
    state = state_of(settings, drive, PULL)
    slope = slip_per_pull(c, state)
    noise = np.array([5e-4 * SPEED] * 2 + [0.05 * PULL * c.driven_radius] * 2)
    variances = np.concatenate([noise**2, np.ones(5)])
    seen = []
    for k in range(90):
        pull = PULL * (1.0 - 0.02 * max(k - 79, 0))
        driven = SPEED * c.driver_radius / c.driven_radius * (1.0 - slope * pull)
        torque = pull * c.driven_radius
        z = np.array([SPEED, driven, torque, -torque]) + noise * random.standard_normal(4)
        values = np.concatenate([z, np.full(5, math.nan)])
        sensed = Sensed(values, variances, z, noise**2, np.arange(4), NO_LOADS, np.ones(3))
        active = following.follow(sensed, state, wander, DT, unforeseen=k >= 79)
        seen.append(float(np.max(active.taken)))
    assert np.max(seen[60:80]) < 0.02
    assert 0.05 < np.max(seen[80:]) < 0.5
