"""A speed that is missing for a while is told from the other, through the whole monitor."""

import dataclasses
import math

import pytest
from runs import assert_sound, within
from sensor_runs import POSITIONS, Alter, only, play

from belt_ros.estimation import Measurement, Rejection
from belt_ros.settings import DriveSettings


def without_speed(missing: str) -> Alter:
    """Leave a speed out for a second, and positions always."""

    def alter(measurement: Measurement) -> Measurement:
        measurement = dataclasses.replace(only()(measurement), **POSITIONS)
        gone = 1.0e9 <= measurement.stamp_ns < 2.0e9
        return dataclasses.replace(measurement, **{missing: math.nan}) if gone else measurement

    return alter


@pytest.mark.parametrize("missing", ["driver_speed", "driven_speed"])
@pytest.mark.parametrize("seed", range(3))
def test_a_speed_that_is_missing_is_told_from_the_other(
    settings: DriveSettings, missing: str, seed: int
) -> None:
    run = play(
        settings,
        without_speed(missing),
        seed=seed,
        duration=2.6,
        speed=120.0,
        load=[[0.3, 0.0], [0.5, 30.0], [1.4, 30.0], [1.5, 15.0]],
        condition__tension=440.0,
    )
    for seconds in (1.1, 1.3, 1.7, 1.98, 2.1, 2.5):
        estimate, truth = run.at(seconds)
        for name in (missing, "slip", "transmitted_torque", "margin"):
            assert within(getattr(estimate, name), getattr(truth, name), 3.5), (seconds, name)
    with_both, alone = run.at(0.98)[0], run.at(1.3)[0]
    assert getattr(alone, missing).stddev > 1.2 * getattr(with_both, missing).stddev


@pytest.mark.parametrize(("missing", "rate"), [("driver_speed", 100.0), ("driven_speed", 50.0)])
def test_it_is_also_while_the_drive_slows_down(
    settings: DriveSettings, missing: str, rate: float
) -> None:
    run = play(
        settings,
        without_speed(missing),
        seed=1,
        sample_rate=rate,
        duration=2.0,
        speed=[[1.2, 120.0], [1.5, 80.0]],
        load=[[0.3, 0.0], [0.5, 30.0]],
        condition__tension=440.0,
    )
    begun = round(1.2 * rate)
    for output, truth in zip(run.outputs[begun:], run.truths[begun:], strict=True):
        estimate = output.estimate
        assert output.rejection is Rejection.NONE
        assert getattr(estimate, missing).value == pytest.approx(getattr(truth, missing), rel=0.005)
        torque = estimate.transmitted_torque.value
        assert torque == pytest.approx(truth.transmitted_torque, abs=2.0)
        assert_sound(estimate)
