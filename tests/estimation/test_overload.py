"""Probability of gross slip at a load, and the load at a probability."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from belt_ros.estimation.overload import Capacity
from belt_ros.estimation.readings import Readings
from belt_ros.estimation.state import READINGS, Reading
from belt_ros.mechanics import Belt, BeltDrive, Pulley, Tensioning, torque_capacity

MIXED = Capacity(np.array([0.6, 0.3, 0.1]), np.array([60.0, 40.0, 90.0]), np.array([3.0, 6.0, 1.0]))


def sampled_capacity(
    tensioning: Tensioning, tension: float, spread: float, speed: float
) -> np.ndarray:
    """Capacities of drives whose ln T and ln mu are drawn, through the public mechanics."""
    random = np.random.default_rng(0)
    capacities = []
    for mu in 0.8 * np.exp(0.05 * random.standard_normal(200)):
        pulley = Pulley(0.08, math.pi, mu, 1e8)
        drive = BeltDrive(Belt(80e3, 0.1), pulley, pulley, 0.5, tensioning=tensioning)
        tensions = tension * np.exp(spread * random.standard_normal(200))
        capacities.append(torque_capacity(drive, tensions, speed))
    return np.concatenate(capacities)


@pytest.mark.parametrize("tensioning", [Tensioning.CONSTANT_MEAN, Tensioning.CONSTANT_SLACK])
@pytest.mark.parametrize("speed", [0.0, 200.0])
def test_probabilities_are_those_of_sampled_drives(tensioning: Tensioning, speed: float) -> None:
    parts = [sampled_capacity(tensioning, t, s, speed) for t, s in ((420.0, 0.1), (300.0, 0.13))]
    capacity = Capacity(
        np.array([0.5, 0.5]),
        np.array([np.mean(part) for part in parts]),
        np.array([np.std(part) for part in parts]),
    )
    together = np.concatenate(parts)
    assert capacity.torque.value == pytest.approx(np.mean(together))
    assert capacity.torque.stddev == pytest.approx(np.std(together))
    for probability in (0.01, 0.05, 0.3, 0.5, 0.9):
        load = float(np.quantile(together, probability))
        assert capacity.gross_slip_probability_at(load) == pytest.approx(
            probability, abs=min(0.015, 0.5 * probability)
        )
        assert capacity.load_at_probability(probability) == pytest.approx(load, rel=0.03)


@pytest.mark.parametrize("probability", [1e-9, 1e-3, 0.05, 0.5, 0.77, 0.999999])
def test_load_is_the_inverse_of_probability(probability: float) -> None:
    load = MIXED.load_at_probability(probability)
    assert MIXED.gross_slip_probability_at(load) == pytest.approx(probability, rel=1e-6)
    assert MIXED.gross_slip_probability_at(-load) == pytest.approx(probability, rel=1e-6)


def test_nothing_slips_unloaded_and_all_does_at_any_load() -> None:
    assert MIXED.gross_slip_probability_at(0.0) == 0.0
    assert MIXED.gross_slip_probability_at(math.inf) == pytest.approx(1.0, abs=1e-15)


def test_a_certain_capacity_is_a_step() -> None:
    certain = Capacity(np.array([0.25, 0.75]), np.array([50.0, 70.0]), np.zeros(2))
    assert certain.gross_slip_probability_at(49.9) == 0.0
    assert certain.gross_slip_probability_at(50.1) == 0.25
    assert certain.gross_slip_probability_at(70.1) == 1.0
    assert certain.load_at_probability(0.2) == pytest.approx(50.0)
    assert certain.load_at_probability(0.3) == pytest.approx(70.0)


def test_a_belt_that_has_lifted_off_slips_at_once() -> None:
    lifted = Capacity(np.array([0.5, 0.5]), np.array([0.0, 50.0]), np.array([0.0, 2.0]))
    assert lifted.gross_slip_probability_at(1e-9) == 0.5
    assert lifted.load_at_probability(0.4) == pytest.approx(0.0, abs=1e-200)


@pytest.mark.parametrize("probability", [0.0, 1.0, -0.1, math.nan])
def test_there_is_no_load_of_an_impossible_probability(probability: float) -> None:
    with pytest.raises(ValueError, match="between 0 and 1"):
        MIXED.load_at_probability(probability)


@hypothesis_settings(derandomize=True, deadline=None, max_examples=200)
@given(
    means=st.lists(st.floats(0.0, 1e9), min_size=3, max_size=3),
    deviations=st.lists(st.floats(0.0, 1e9), min_size=3, max_size=3),
    load=st.floats(-1e9, 1e9),
    more=st.floats(0.0, 1e9),
)
def test_probability_rises_with_the_load(means, deviations, load: float, more: float) -> None:
    capacity = Capacity(MIXED.weights, np.array(means), np.array(deviations))
    here = capacity.gross_slip_probability_at(abs(load))
    there = capacity.gross_slip_probability_at(abs(load) + more)
    assert 0.0 <= here <= there <= 1.0
    assert 0.0 <= capacity.load_at_probability(0.01) <= capacity.load_at_probability(0.9)
    assert math.isfinite(capacity.load_at_probability(0.9))


def test_it_is_read_off_a_gaussian_sum() -> None:
    place = Reading.MARGIN  # any
    means, deviations = np.zeros((3, READINGS)), np.zeros((3, READINGS))
    means[:, place], deviations[:, place] = MIXED.means, MIXED.deviations
    readings = Readings(MIXED.weights, means, deviations)
    capacity = readings.capacity(place)
    assert capacity.torque == pytest.approx(readings.quantity(place))
    assert capacity.gross_slip_probability_at(50.0) == MIXED.gross_slip_probability_at(50.0)
