"""Positions, fine, wrapping or with gaps, through the whole monitor."""

import dataclasses
import math

import numpy as np
import pytest
from runs import Run, assert_sound, within
from sensor_runs import POSITIONS, only, play

from belt_ros.estimation import Measurement, Rejection
from belt_ros.settings import DriveSettings


def rounded_to(settings: DriveSettings, quantum: float) -> DriveSettings:
    """Coarse speeds and fine positions."""
    noise = dataclasses.replace(settings.noise, speed_quantum=quantum, position_absolute=2e-5)
    return dataclasses.replace(settings, noise=noise)


SLOW = {
    "slow": 3.0,
    "dwell": [[0.0, 3.0], [1.5, 3.0], [1.7, 0.0], [3.0, 0.0], [3.2, 3.0]],
    "reversal": [[0.0, 3.0], [1.5, 3.0], [1.9, -3.0], [3.0, -3.0], [3.4, 3.0]],
}


@pytest.fixture(scope="module", params=list(SLOW))
def pairs(settings: DriveSettings, request: pytest.FixtureRequest) -> list[tuple[Run, Run]]:
    """Runs with coarse speeds, with and without fine positions."""
    coarse = rounded_to(settings, 0.5)

    def without(measurement: Measurement) -> Measurement:
        return dataclasses.replace(only()(measurement), **POSITIONS)

    scenario = {
        "duration": 4.6,
        "speed": SLOW[request.param],
        "load": [[0.5, 0.0], [0.7, 20.0]],
        "load_direction": "fixed",
        "condition__tension": 440.0,
    }
    return [
        (
            play(coarse, only(), seed=seed, **scenario),
            play(coarse, without, seed=seed, **scenario),
        )
        for seed in range(2)
    ]


def lost_travel_errors(run: Run) -> np.ndarray:
    return np.array(
        [
            output.estimate.accumulated_slip.value - truth.accumulated_slip
            for output, truth in zip(run.outputs, run.truths, strict=True)
        ]
    )


def test_positions_count_the_lost_travel_where_speeds_are_coarse(pairs) -> None:
    with_positions, without = (
        np.sqrt(np.mean([lost_travel_errors(pair[which]) ** 2 for pair in pairs]))
        for which in range(2)
    )
    assert with_positions < 0.4 * without
    assert with_positions < 1e-4  # [m], of 3 to 5 mm


def test_positions_teach_kf_where_speeds_are_too_coarse_to(pairs) -> None:
    for run, blind in pairs:
        estimate, truth = run.outputs[-1].estimate, run.truths[-1]
        other = blind.outputs[-1].estimate
        assert estimate.friction_stiffness_log_stddev < 0.8 * other.friction_stiffness_log_stddev
        off = math.log(estimate.friction_stiffness.value / truth.friction_stiffness)
        assert abs(off) < 2.5 * estimate.friction_stiffness_log_stddev


def test_with_positions_every_number_is_sound(pairs) -> None:
    for run, _ in pairs:
        for output in run.outputs:
            assert output.rejection is Rejection.NONE
            assert_sound(output.estimate)


@pytest.fixture(scope="module")
def fast(settings: DriveSettings) -> dict[str, object]:
    return {
        "duration": 3.0,
        "seed": 4,
        "speed": [[0.0, 0.0], [0.5, 120.0]],
        "load": [[1.0, 0.0], [1.2, 30.0]],
    }


def test_encoders_that_wrap_say_the_same(settings: DriveSettings, fast) -> None:
    def wrapping(measurement: Measurement) -> Measurement:
        wrapped = [math.remainder(position, 2.0 * math.pi) for position in measurement.positions]
        return dataclasses.replace(
            only()(measurement), driver_position=wrapped[0], driven_position=wrapped[1]
        )

    counting, wrapped = play(settings, only(), **fast), play(settings, wrapping, **fast)
    assert abs(wrapped.measurements[-1].driver_position) <= math.pi
    assert abs(counting.measurements[-1].driver_position) > 100.0
    for name in ("slip", "accumulated_slip", "mean_tension", "friction_stiffness"):
        here = getattr(wrapped.outputs[-1].estimate, name)
        assert here == pytest.approx(getattr(counting.outputs[-1].estimate, name), rel=1e-6)


def test_a_gap_of_positions_starts_the_count_anew(settings: DriveSettings, fast) -> None:
    """In which an encoder has been reset as well."""

    def alter(measurement: Measurement) -> Measurement:
        measurement = only()(measurement)
        if 1.5e9 < measurement.stamp_ns < 1.7e9:
            return dataclasses.replace(measurement, **POSITIONS)
        if measurement.stamp_ns >= 1.7e9:
            return dataclasses.replace(
                measurement, driven_position=measurement.driven_position + 40.0
            )
        return measurement

    run, whole = play(settings, alter, **fast), play(settings, only(), **fast)
    for seconds in (1.6, 1.7, 1.72, 2.0, 2.9):
        estimate, truth = run.at(seconds)
        assert within(estimate.slip, truth.slip, 3.0)
        assert_sound(estimate)
    fitted = dict(settings.monitor().health.sensor_fits)
    assert "positions" in fitted
    here, there = run.outputs[-1].estimate, whole.outputs[-1].estimate
    assert here.friction_stiffness.value == pytest.approx(there.friction_stiffness.value, rel=0.1)
