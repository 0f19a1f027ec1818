import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from belt_ros.mechanics import DriveError, Tensioning, solve_equilibrium, torque_capacity
from belt_ros.report.drive_at import Known, drive_from_config, load_curve, with_friction
from belt_ros.report.result_directory import ReportError
from belt_ros.settings import load_settings

REPOSITORY = Path(__file__).parents[2]
TENSION, MU, KF, SPEED = 440.0, 1.18, 6e6, 100.0


@pytest.fixture(scope="module")
def drive():
    return load_settings(REPOSITORY / "config" / "demo_drive.yaml").drive


def known(drive, **changes):
    found = with_friction(drive, MU, KF)
    capacity = float(torque_capacity(found, TENSION, SPEED))
    belt = Known(TENSION, 300.0, 0.0, SPEED, KF, 0.1, MU, capacity, 0.05 * capacity)
    return replace(belt, **changes)


def test_curve_is_the_equilibrium_of_the_drive_as_it_was_found(drive):
    belt = known(drive)
    curve = load_curve(drive, belt, 1.2 * belt.capacity)
    carried = (curve.torque > 0.0) & (curve.torque < 0.97 * belt.capacity)
    state = solve_equilibrium(with_friction(drive, MU, KF), curve.torque[carried], TENSION, SPEED)
    np.testing.assert_allclose(curve.slip[carried], state.slip, rtol=5e-3)


def test_curve_ends_at_the_capacity(drive):
    belt = known(drive)
    curve = load_curve(drive, belt, 1.2 * belt.capacity)
    np.testing.assert_array_equal(np.isinf(curve.slip), curve.torque >= belt.capacity)


def test_band_holds_the_curve_and_spans_95_percent_of_the_capacity(drive):
    belt = known(drive)
    curve = load_curve(drive, belt, 1.3 * belt.capacity)
    assert np.all(curve.low <= curve.slip)
    assert np.all(curve.slip <= curve.high)
    least = curve.torque[np.isinf(curve.high)][0]
    assert least == pytest.approx(belt.capacity * np.exp(-1.96 * 0.05), rel=0.03)


def test_curve_is_that_of_forward_rotation_when_the_drive_last_turned_back(drive):
    forward = load_curve(drive, known(drive), 60.0)
    back = load_curve(drive, known(drive, driver_speed=-SPEED), 60.0)
    np.testing.assert_array_equal(forward.slip, back.slip)


def test_a_held_slack_span_is_taken_from_the_slack_tension(drive):
    held = replace(drive, tensioning=Tensioning.CONSTANT_SLACK)
    found = with_friction(held, MU, KF)
    capacity = float(torque_capacity(found, 300.0, SPEED))
    belt = known(drive, capacity=capacity)
    curve = load_curve(held, belt, capacity)
    state = solve_equilibrium(found, curve.torque[20], 300.0, SPEED)
    assert curve.slip[20] == pytest.approx(float(state.slip), rel=5e-3)


def test_a_belt_of_which_nothing_is_known_has_no_curve(drive):
    with pytest.raises(DriveError):
        load_curve(drive, known(drive, stiffness_log_stddev=np.nan), 50.0)


def test_the_drive_is_that_of_the_settings(results):
    config = json.loads((results / "summary.json").read_text())["config"]
    drive = load_settings(REPOSITORY / "config" / "paper_drive.yaml").drive
    assert drive_from_config(config) == drive


@pytest.mark.parametrize("config", [{}, {"drive": 3}, {"drive": {"belt": {"mass": 1}}}])
def test_a_config_without_a_drive_is_refused(config):
    with pytest.raises(ReportError, match="describes no drive"):
        drive_from_config(config)
