"""Finite element plants of the estimator's benchmark: smooth, and with equilibrium's creep."""

import numpy as np
import pytest

from belt_ros.mechanics import Tensioning, solve_equilibrium
from benchmarks.estimation.cells import BELTS, Cell, cell_settings
from benchmarks.estimation.elements import JUDGED_AT, prior_errors, smooth_change, trajectory

CELL = Cell("conveyor", 8.1e7, 0.9, "fine")


def test_a_change_has_no_step_in_its_first_two_derivatives() -> None:
    time, value = np.array(smooth_change(1.0, 0.4, 2.0, 12.0)).T
    assert (time[0], time[-1], value[0], value[-1]) == pytest.approx((1.0, 1.4, 2.0, 12.0))
    slope = np.gradient(value, time)
    bend = np.gradient(slope, time)
    assert np.all(np.diff(value) > 0.0)
    assert max(slope[0], slope[-1]) < 0.01 * slope.max()
    assert max(abs(bend[0]), abs(bend[-1])) < 0.15 * np.abs(bend).max()


def test_plant_creeps_as_in_equilibrium_where_it_is_judged() -> None:
    belt = BELTS[CELL.belt]
    drive = cell_settings(CELL, tensioning=Tensioning.FIXED_CENTRES.value).drive
    samples = trajectory(CELL)
    for instant in JUDGED_AT:
        truth = [truth for stamp, truth in samples if 0.0 <= instant - stamp * 1e-9 < 0.1]
        torque = np.mean([one.transmitted_torque for one in truth])
        expected = solve_equilibrium(drive, torque, belt.tension, belt.speed)
        slip = np.mean([one.slip for one in truth])
        assert slip == pytest.approx(float(expected.slip), rel=5e-3)


def test_priors_of_few_runs_err_as_evenly_as_a_prior_says() -> None:
    errors = np.array([prior_errors(CELL, seed) for seed in range(32)])
    assert errors.mean(axis=0) == pytest.approx(0.0, abs=0.1)
    assert errors.std(axis=0) == pytest.approx(1.0, abs=0.1)
    assert np.corrcoef(errors.T) == pytest.approx(np.eye(3), abs=0.15)
    outside = np.sum(np.abs(errors) > 1.96, axis=0)  # 1.6 of 32
    assert np.all(outside <= 2)
    assert np.sum(outside) > 0


def test_errors_of_a_prior_are_those_of_its_run_alone() -> None:
    assert prior_errors(CELL, 7) == prior_errors(CELL, 7) != prior_errors(CELL, 8)
    assert prior_errors(CELL, 7) != prior_errors(CELL._replace(peak=0.5), 7)
