"""Measurements turned into readings of the state: which, how uncertain, and the counted travel."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from belt_ros.estimation import Measurement, SensorNoise
from belt_ros.estimation.sensing import NO_LOADS, Sensing
from belt_ros.estimation.state import Index
from belt_ros.mechanics import Belt, BeltDrive, Pulley
from belt_ros.mechanics.constants import drive_constants

DRIVEN_RADIUS, DRIVER_RADIUS = 0.08, 0.05
TURN = 2.0 * math.pi
CONSTANTS = drive_constants(
    BeltDrive(
        Belt(80e3, 0.1),
        Pulley(DRIVEN_RADIUS, 3.3, 0.8, 1e7, 0.05),
        Pulley(DRIVER_RADIUS, 2.9, 0.8, 1e7, 0.05),
        0.5,
    )
)
NOISE = SensorNoise(position_absolute=2e-4, position_quantum=1e-3)
SPEEDS = (40.0, 24.0)  # [rad/s]; the driver's rim is 0.08 m/s faster
AHEAD = DRIVER_RADIUS * SPEEDS[0] - DRIVEN_RADIUS * SPEEDS[1]
FULL = Measurement(0, *SPEEDS, 3.0, -4.0, 0.3, 0.1, 700.0, 690.0, 350.0)


def sensing(turns: tuple[float, float] = (TURN, TURN)) -> Sensing:
    return Sensing(CONSTANTS, NOISE, turns)


def wrapped(angle: float, turn: float = TURN) -> float:
    """As an encoder of a joint reports it, within half a turn either way."""
    return (angle + 0.5 * turn) % turn - 0.5 * turn


def turning(time: float, turns: tuple[float, float] = (TURN, TURN), **changes: float):
    """The drive at constant speeds, positions wrapped."""
    angles = [speed * time for speed in SPEEDS]
    driver, driven = (wrapped(*pair) for pair in zip(angles, turns, strict=True))
    measurement = Measurement(round(time * 1e9), *SPEEDS, 3.0, -4.0, driver, driven)
    return dataclasses.replace(measurement, **changes)


def travels(sense: Sensing, measurements: list[Measurement], dt: float) -> list[float]:
    """Travel that each measurement says, NaN where it says none."""
    out = []
    for measurement in measurements:
        sensed = sense.sense(measurement, dt)
        there = sensed.places.tolist()
        out.append(float(sensed.z[-1]) if Index.TRAVEL in there else math.nan)
    return out


def test_what_is_measured_directly_is_read_with_its_variance() -> None:
    sensed = sensing().sense(FULL, 0.0)
    np.testing.assert_array_equal(sensed.z, [*SPEEDS, 3.0, -4.0])
    assert sensed.places.tolist() == [
        Index.DRIVER_SPEED,
        Index.DRIVEN_SPEED,
        Index.DRIVER_TORQUE,
        Index.DRIVEN_TORQUE,
    ]
    speed = (NOISE.speed_relative * SPEEDS[0]) ** 2 + NOISE.speed_absolute**2
    torque = (NOISE.torque_relative * 4.0) ** 2 + NOISE.torque_absolute**2
    assert sensed.variance[[0, 3]] == pytest.approx([speed, torque])
    np.testing.assert_array_equal(sensed.values, FULL.values())


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("driver_speed", Index.DRIVER_SPEED),
        ("driven_speed", Index.DRIVEN_SPEED),
        ("driver_torque", Index.DRIVER_TORQUE),
        ("driven_torque", Index.DRIVEN_TORQUE),
    ],
)
def test_what_is_missing_is_left_out(name: str, place: Index) -> None:
    sensed = sensing().sense(dataclasses.replace(FULL, **{name: math.nan}), 0.0)
    assert place not in sensed.places.tolist()
    assert len(sensed.z) == len(sensed.variance) == len(sensed.places) == 3
    assert np.all(np.isfinite(sensed.z))


def test_travel_counts_from_the_first_positions_on() -> None:
    sense, dt = sensing(), 0.01
    assert not sense.counts_travel
    seen = travels(sense, [turning(k * dt) for k in range(11)], dt)
    assert math.isnan(seen[0])
    assert sense.counts_travel
    assert seen[1:] == pytest.approx([AHEAD * k * dt for k in range(1, 11)], abs=1e-12)


def test_travel_is_as_uncertain_as_both_encoders() -> None:
    sense = sensing()
    sense.sense(turning(0.0), 0.0)
    sensed = sense.sense(turning(0.01), 0.01)
    position = NOISE.position_absolute**2 + NOISE.position_quantum**2 / 12.0
    assert sensed.variance[-1] == pytest.approx(
        (DRIVER_RADIUS**2 + DRIVEN_RADIUS**2) * position, rel=1e-12
    )


@pytest.mark.parametrize("turns", [(TURN, TURN), (TURN / 4.0, TURN / 1.5)])
def test_encoders_that_wrap_are_unwrapped_over_many_turns(turns: tuple[float, float]) -> None:
    dt = 0.01
    seen = travels(sensing(turns), [turning(k * dt, turns) for k in range(1001)], dt)
    assert seen[-1] == pytest.approx(AHEAD * 10.0, abs=1e-9)  # after 64 turns
    np.testing.assert_allclose(np.diff(seen[1:]), AHEAD * dt, atol=1e-9)


@pytest.mark.parametrize("name", ["driver_position", "driven_position"])
def test_after_a_gap_of_either_encoder_travel_counts_anew(name: str) -> None:
    sense, dt = sensing(), 0.01
    rows = [turning(k * dt) for k in range(30)]
    for k in range(5, 20):
        rows[k] = dataclasses.replace(rows[k], **{name: math.nan})
    seen = travels(sense, rows, dt)
    assert np.all(np.isnan(seen[5:21]))
    assert seen[21:] == pytest.approx([AHEAD * dt * k for k in range(1, 10)], abs=1e-12)


@pytest.mark.parametrize("name", ["driver_position", "driven_position", "driver_speed"])
def test_one_reading_that_is_missing_does_not_end_the_count(name: str) -> None:
    sense, dt = sensing(), 0.01
    rows = [turning(k * dt) for k in range(10)]
    rows[5] = dataclasses.replace(rows[5], **{name: math.nan})
    seen = travels(sense, rows, dt)
    assert math.isnan(seen[5]) == (name != "driver_speed")
    assert seen[6:] == pytest.approx([AHEAD * dt * k for k in range(6, 10)], abs=1e-12)


def test_lost_travel_counts_anew_from_the_next_measurement() -> None:
    sense, dt = sensing(), 0.01
    travels(sense, [turning(k * dt) for k in range(5)], dt)
    sense.lose_travel()
    assert not sense.counts_travel
    seen = travels(sense, [turning(k * dt) for k in range(5, 8)], dt)
    assert math.isnan(seen[0])
    assert seen[1:] == pytest.approx([AHEAD * dt, 2.0 * AHEAD * dt], abs=1e-12)


def test_loads_are_taken_in_once_a_second_and_nothing_of_them_is_invented() -> None:
    sense, dt = sensing(), 0.125
    taken = [sense.sense(FULL, dt).loads is not NO_LOADS for _ in range(30)]
    assert [k for k, there in enumerate(taken) if there] == [0, 8, 16, 24]
    sense.start()
    only_span = dataclasses.replace(FULL, driver_hub_load=math.nan, driven_hub_load=math.nan)
    sensed = sense.sense(only_span, dt)
    np.testing.assert_array_equal(sensed.loads, [math.nan, math.nan, 350.0])
    expected = (NOISE.load_relative * 350.0) ** 2 + NOISE.load_absolute**2
    assert sensed.load_variances[2] == pytest.approx(expected)


def test_each_load_counts_once_a_second_by_itself() -> None:
    """Also where each cell has a message of its own."""
    sense, dt = sensing(), 0.125
    only_span = dataclasses.replace(FULL, driver_hub_load=math.nan, driven_hub_load=math.nan)
    only_driver = dataclasses.replace(FULL, driven_hub_load=math.nan, span_tension=math.nan)
    taken = [
        np.flatnonzero(~np.isnan(sense.sense(only_span if k % 2 else only_driver, dt).loads))
        for k in range(18)
    ]
    assert [k for k, loads in enumerate(taken) if 0 in loads] == [0, 8, 16]
    assert [k for k, loads in enumerate(taken) if 2 in loads] == [1, 9, 17]
    sense.ask_for_load(2)
    np.testing.assert_array_equal(sense.sense(only_span, dt).loads, [math.nan, math.nan, 350.0])


def test_a_load_that_comes_after_a_pause_is_taken_in_at_once() -> None:
    sense = sensing()
    without = dataclasses.replace(
        FULL, driver_hub_load=math.nan, driven_hub_load=math.nan, span_tension=math.nan
    )
    sense.sense(FULL, 0.0)
    for _ in range(15):
        assert sense.sense(without, 0.1).loads is NO_LOADS
    assert sense.sense(FULL, 0.1).loads is not NO_LOADS


def test_other_noise_counts_from_the_next_measurement_on() -> None:
    sense = sensing()
    before = sense.sense(turning(0.0), 0.0).variance
    sense.retune(dataclasses.replace(NOISE, speed_quantum=0.5))
    after = sense.sense(turning(0.01), 0.01).variance
    np.testing.assert_allclose(after[:2] - before[:2], 0.25 / 12.0)
    np.testing.assert_array_equal(after[2:4], before[2:4])


ANGLE = st.one_of(st.just(math.nan), st.floats(-1e15, 1e15))
SPEED = st.one_of(st.just(math.nan), st.floats(-1e4, 1e4))


@hypothesis_settings(derandomize=True, deadline=None, max_examples=200)
@given(
    rows=st.lists(
        st.tuples(SPEED, SPEED, ANGLE, ANGLE, st.floats(1e-6, 10.0)), min_size=1, max_size=12
    )
)
def test_whatever_encoders_say_readings_are_numbers(rows) -> None:
    sense = sensing()
    for driver, driven, driver_angle, driven_angle, dt in rows:
        measurement = Measurement(0, driver, driven, 1.0, -1.0, driver_angle, driven_angle)
        sensed = sense.sense(measurement, dt)
        assert np.all(np.isfinite(sensed.z))
        assert np.all(sensed.variance > 0.0)
        assert len(set(sensed.places.tolist())) == len(sensed.places)
