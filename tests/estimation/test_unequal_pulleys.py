"""Drives whose pulleys differ: a load at the rim is another torque at either of them."""

import dataclasses
import math

import numpy as np
import pytest
from runs import ROOT, Runner

from belt_ros.estimation import Drift, Phase
from belt_ros.estimation.load import Activity
from belt_ros.estimation.process import drift_processes, drift_wander, prior_state
from belt_ros.estimation.state import Index
from belt_ros.mechanics import torque_capacity
from belt_ros.mechanics.constants import drive_constants
from belt_ros.settings import DriveSettings, load_settings

TORQUES = [Index.DRIVER_TORQUE, Index.DRIVEN_TORQUE]


def geared(ratio: float) -> DriveSettings:
    """The demonstration's drive with a driven pulley `ratio` times as large."""
    one = load_settings(ROOT / "config" / "demo_drive.yaml").drive.driven
    larger = {"driven.radius": one.radius * ratio, "driven.inertia": one.inertia * ratio**2}
    return load_settings(ROOT / "config" / "demo_drive.yaml", {**larger, "span_length": 1.0})


@pytest.mark.parametrize("ratio", [0.25, 4.0])
def test_torques_are_as_uncertain_as_their_radii_say(ratio: float) -> None:
    drive = geared(ratio).drive
    _, stddev = prior_state(geared(ratio).prior, drive)
    assert stddev[TORQUES[1]] == pytest.approx(ratio * stddev[TORQUES[0]])
    c = drive_constants(drive)
    wander = drift_wander(Drift(), stddev, 400.0)
    activity = Activity((1.0, 1.0), (1.0, 1.0))
    settled, _ = drift_processes(wander, c, activity, (0.1, 0.0, 0.0), 0.01, 0.01)
    driver, driven = np.sqrt(np.diag(settled.covariance_before)[TORQUES])
    assert driven == pytest.approx(ratio * driver)


@pytest.mark.parametrize("missing", ["", "driven_torque"])
@pytest.mark.parametrize("ratio", [0.25, 4.0])
def test_load_steps_of_a_geared_drive_are_followed(run: Runner, ratio: float, missing: str) -> None:
    settings = geared(ratio)
    capacity = float(torque_capacity(settings.drive, settings.prior.tension, 60.0))
    load = [[0.0, 0.0], [1.5, 0.0]]
    for level, share in enumerate((0.7, 0.2, 0.6)):
        begin = 1.5 + 1.5 * level
        load += [[begin, load[-1][1]], [begin + 0.2, share * capacity]]
    for seed in range(2):
        played = run(
            alter=lambda m: dataclasses.replace(m, **{missing: math.nan}) if missing else m,
            drive=settings,
            duration=6.0,
            sample_rate=50.0,
            seed=seed,
            speed=[[0.0, 0.0], [1.0, 60.0]],
            load=load,
        )
        phases = {output.estimate.phase for output in played.outputs[100:] if output.estimate}
        assert Phase.LOST not in phases
