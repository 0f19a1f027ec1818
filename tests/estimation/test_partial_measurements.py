"""Sensors that speak in turns, or one seldomer than the other: as good as if all spoke at once."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from runs import scripted

from belt_ros.estimation import BeltFilter, Measurement
from belt_ros.estimation.state import Index, Reading
from belt_ros.settings import DriveSettings

SEEDS = range(2)
DURATION = 3.0
TENSION, STIFFNESS = 440.0, 8e6
DRIVER = ("driver_speed", "driver_torque", "driver_position")
DRIVEN = ("driven_speed", "driven_torque", "driven_position")
SPEEDS, TORQUES = ("driver_speed", "driven_speed"), ("driver_torque", "driven_torque")
EVERYTHING = DRIVER + DRIVEN
SLOW = 25.0  # [Hz] at which the seldomest sensor speaks
# Stated deviation to that with whole measurements. Tension is learned from how slip follows the
# change of load, of which sensors in turns see half at a time.
MOST = {"slip": 1.25, "log_tension": 2.0, "log_stiffness": 1.25}
Turns = Callable[[int], tuple[str, ...]]


class Pattern(NamedTuple):
    """How often someone speaks [Hz], who does at the k-th time, and whether that tells travel.

    Travel is told by angles that are no more than 12 ms apart, and tells the ratio's bias best.
    """

    rate: float
    turns: Turns
    travel: bool = False


PATTERNS = {
    "in turns": Pattern(2.0 * SLOW, lambda k: (DRIVER, DRIVEN)[k % 2]),
    "one seldom": Pattern(5.0 * SLOW, lambda k: DRIVER if k % 5 else EVERYTHING, travel=True),
    "one seldom, apart": Pattern(
        5.0 * SLOW, lambda k: DRIVEN if k % 5 == 3 else DRIVER, travel=True
    ),
    "torques seldom, apart": Pattern(5.0 * SLOW, lambda k: TORQUES if k % 5 == 2 else SPEEDS),
    "four apart": Pattern(4.0 * SLOW, lambda k: ((*SPEEDS, *TORQUES)[k % 4],)),
}


class Known(NamedTuple):
    """Errors and stated deviations at the end of a run."""

    slip: tuple[float, float]
    log_tension: tuple[float, float]
    log_stiffness: tuple[float, float]


def known(settings: DriveSettings, pattern: Pattern, seed: int) -> Known:
    """What a filter knows after a step and a ramp of the load."""
    belt_filter = BeltFilter(settings.drive, settings.prior, settings.noise, settings.drift)
    begun = False
    for k, (measurement, truth) in enumerate(
        scripted(
            settings,
            duration=DURATION,
            sample_rate=pattern.rate,
            seed=seed,
            speed=120.0,
            load=[[0.7, 0.0], [0.72, 30.0], [1.6, 30.0], [2.4, 50.0]],
            condition__tension=TENSION,
            condition__friction_stiffness=STIFFNESS,
        )
    ):
        there = {name: getattr(measurement, name) for name in pattern.turns(k)}
        partial = Measurement(measurement.stamp_ns, **there)
        if begun:
            belt_filter.predict(partial)
            belt_filter.update()
        else:
            begun = belt_filter.start(partial)
        true_slip = truth.slip
    slip = belt_filter.view(0.02).readings.quantity(Reading.SLIP)

    def off(place: Index, true: float) -> tuple[float, float]:
        error = float(belt_filter.x[place]) - math.log(true)
        return error, math.sqrt(belt_filter.covariance[place, place])

    return Known(
        (slip.value - true_slip, slip.stddev),
        off(Index.LOG_TENSION, TENSION),
        off(Index.LOG_STIFFNESS, STIFFNESS),
    )


@pytest.fixture(scope="module")
def whole(settings: DriveSettings) -> dict[bool, list[Known]]:
    """What whole measurements teach that tell travel, and such that do not."""
    patterns = {
        True: Pattern(SLOW, lambda _: EVERYTHING),
        False: Pattern(SLOW, lambda _: (*SPEEDS, *TORQUES)),
    }
    return {
        travel: [known(settings, pattern, seed) for seed in SEEDS]
        for travel, pattern in patterns.items()
    }


@pytest.mark.parametrize("name", list(PATTERNS))
def test_what_comes_in_parts_teaches_as_much_as_what_comes_at_once(
    settings: DriveSettings, whole: dict[bool, list[Known]], name: str
) -> None:
    partial = [known(settings, PATTERNS[name], seed) for seed in SEEDS]
    for quantity in Known._fields:
        errors, stated = np.transpose([getattr(run, quantity) for run in partial])
        reference = np.mean([getattr(run, quantity)[1] for run in whole[PATTERNS[name].travel]])
        assert np.mean(stated) < MOST[quantity] * reference, quantity
        assert np.max(np.abs(errors / stated)) < 3.0, quantity


def test_a_filter_takes_in_whatever_there_is(settings: DriveSettings) -> None:
    """Even a measurement of nothing, or of hub loads alone, is a step in time."""
    belt_filter = BeltFilter(settings.drive, settings.prior, settings.noise, settings.drift)
    assert belt_filter.start(Measurement(0, 100.0, 100.0, 0.0, 0.0))
    for k, there in enumerate([{}, {"driver_hub_load": 800.0}, {"driver_position": 1.0}], 1):
        assert math.isfinite(belt_filter.predict(Measurement(k * 10_000_000, **there)))
        squared, degrees = belt_filter.update()
        assert (squared, degrees) == (0.0, 0)
        assert np.all(np.isfinite(belt_filter.x))
        assert np.all(np.diag(belt_filter.covariance) >= 0.0)


def test_nothing_begins_before_both_speeds_are_known(settings: DriveSettings) -> None:
    belt_filter = BeltFilter(settings.drive, settings.prior, settings.noise, settings.drift)
    assert not belt_filter.start(Measurement(0, driver_speed=100.0, driver_torque=3.0))
    assert belt_filter.stamp_ns is None
    assert belt_filter.start(Measurement(5_000_000, driven_speed=99.0))
    assert belt_filter.stamp_ns == 5_000_000
    np.testing.assert_allclose(belt_filter.x[:2], [100.0, 99.0], rtol=1e-12)


def test_a_motion_is_not_resumed_before_both_speeds_are_known(settings: DriveSettings) -> None:
    belt_filter = BeltFilter(settings.drive, settings.prior, settings.noise, settings.drift)
    belt_filter.start(Measurement(0, 100.0, 100.0))
    before = belt_filter.x.copy()
    assert not belt_filter.resume(Measurement(3_000_000_000, driver_speed=50.0))
    np.testing.assert_array_equal(belt_filter.x, before)
    assert belt_filter.stamp_ns == 0
    assert belt_filter.resume(Measurement(3_005_000_000, driven_speed=49.0))
    np.testing.assert_allclose(belt_filter.x[:2], [50.0, 49.0], rtol=1e-12)


def test_a_speed_that_is_missing_for_one_sample_changes_little(settings: DriveSettings) -> None:
    whole = known(settings, Pattern(SLOW, lambda _: SPEEDS + TORQUES), 5)
    gap = known(settings, Pattern(SLOW, lambda k: DRIVER if k == 40 else SPEEDS + TORQUES), 5)
    for here, there in zip(gap, whole, strict=True):
        assert here[1] < 1.1 * there[1]
        assert abs(here[0] - there[0]) < 0.3 * there[1]
