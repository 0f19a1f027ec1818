"""Readings of single pulleys: each at its own rate, each by its own stamp."""

import itertools
import math

import hypothesis
import pytest
from hypothesis import strategies as st

from belt_ros.rig.faults import Report
from belt_ros.rig.readings import NO_LOADS, Rates, is_due, pulley_readings
from belt_ros.rig.sensors import JointSample, LoadSample

JOINTS = JointSample(("motor", "drum"), (1.0, 2.0), (3.0, 4.0), (5.0, 6.0))
RATES = st.sampled_from([0.5, 1.0, 3.0, 7.0, 25.0, 30.0, 99.0, 100.0, 400.0, 1000.0])


def due(sample_rate: float, rate: float, samples: int) -> list[int]:
    """The samples that fall due."""
    stamps = [round(sample * 1e9 / sample_rate) for sample in range(samples)]
    period = round(1e9 / sample_rate)
    return [n for n, stamp in enumerate(stamps) if is_due(stamp, period, rate)]


@hypothesis.given(sample_rate=RATES, rate=RATES, seconds=st.integers(2, 4))
@hypothesis.settings(derandomize=True, deadline=None, max_examples=100)
def test_as_many_readings_fall_due_as_the_rate_says(
    sample_rate: float, rate: float, seconds: int
) -> None:
    hypothesis.assume(rate <= sample_rate)
    samples = round(seconds * sample_rate)

    chosen = due(sample_rate, rate, samples)

    assert chosen[0] == 0
    assert len(chosen) == math.ceil(seconds * rate)
    gaps = {later - earlier for earlier, later in itertools.pairwise(chosen)}
    assert gaps <= {math.floor(sample_rate / rate), math.ceil(sample_rate / rate)}


def test_at_the_rate_of_the_samples_every_one_is_due() -> None:
    for rate in (30.0, 100.0, 333.0, 1000.0):
        assert len(due(rate, rate, 2000)) == 2000


def test_a_report_is_read_pulley_by_pulley() -> None:
    loads = LoadSample(70.0, 80.0, 90.0)

    driver, driven = pulley_readings("a", Report(5, JOINTS), loads, 0, 10**9, Rates(1.0, 1.0))

    assert driver[:8] == (5, "a", "driver", "motor", 1.0, 3.0, 5.0, 70.0)
    assert math.isnan(driver.span_tension)
    assert driven == (5, "a", "driven", "drum", 2.0, 4.0, 6.0, 80.0, 90.0)


def test_what_is_not_measured_is_nan() -> None:
    for reading in pulley_readings("a", Report(5, JOINTS), NO_LOADS, 0, 10**9, Rates(1.0, 1.0)):
        assert math.isnan(reading.hub_load)
        assert math.isnan(reading.span_tension)


@pytest.mark.parametrize("jump", [-3_000_000_000, 5_000_000_000, 1_234_567])
def test_another_clock_leaves_the_rate_as_it_is(jump: int) -> None:
    period = 10_000_000
    readings = [
        reading
        for sample in range(500)
        for reading in pulley_readings(
            "a",
            Report(jump, JOINTS),
            NO_LOADS,
            sample * period + jump,
            period,
            Rates(100.0, 25.0),
        )
    ]
    assert sum(reading.pulley == "driver" for reading in readings) == 500
    assert abs(sum(reading.pulley == "driven" for reading in readings) - 125) <= 1
