"""The error of creep becomes another with time and as the load changes."""

import math

import pytest

from belt_ros.estimation.load import Activity
from belt_ros.estimation.process import CREEP_ERROR, drift_processes, drift_wander, prior_state
from belt_ros.mechanics.constants import drive_constants
from belt_ros.settings import DriveSettings


def creep_memory(settings: DriveSettings, changed: float, dt: float) -> tuple[float, float]:
    """Share of the creep's error that is kept in a step, and the variance that is added."""
    c = drive_constants(settings.drive)
    _, spread = prior_state(settings.prior, settings.drive)
    wander = drift_wander(settings.drift, spread, settings.prior.tension)
    calm = Activity((0.0, 0.0), (0.0, 0.0))
    process, _ = drift_processes(wander, c, calm, (0.01, 0.0, changed), dt, dt)
    gained = process.covariance_before[CREEP_ERROR, CREEP_ERROR]
    return float(process.memory[CREEP_ERROR]), float(gained)


def test_the_creeps_error_becomes_another_as_the_load_changes(settings: DriveSettings) -> None:
    drift, spread = settings.drift, settings.prior.creep_error_stddev
    far = drift.creep_error_load * settings.prior.tension
    steady, _ = creep_memory(settings, 0.0, 0.01)
    assert steady == pytest.approx(math.exp(-0.01 / drift.creep_error_time), rel=1e-12)
    moved, added = creep_memory(settings, far, 1e-9)
    assert moved == pytest.approx(math.exp(-1.0), rel=1e-6)
    assert added == pytest.approx((1.0 - math.exp(-2.0)) * spread**2, rel=1e-6)


def test_it_does_not_matter_in_how_many_steps_the_load_changes(settings: DriveSettings) -> None:
    whole, added = creep_memory(settings, 500.0, 0.2)
    half, part = creep_memory(settings, 250.0, 0.1)
    assert half**2 == pytest.approx(whole, rel=1e-12)
    assert half**2 * part + part == pytest.approx(added, rel=1e-12)
