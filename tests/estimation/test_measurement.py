import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.estimation import Joint, Measurement, Rejection, SensorLimits, SensorNoise
from belt_ros.estimation.measurement import (
    Sensor,
    check_measurement,
    measurement_from_joints,
    sensor_variances,
    unwrapped,
)

DRIVER, DRIVEN = Joint(name="motor"), Joint(name="roller")
LIMITS = SensorLimits(greatest_speed=1000.0, greatest_torque=500.0, greatest_load=2000.0)
REPEATABLE = settings(derandomize=True, deadline=None)


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ((10.0, 9.9, 1.0, -1.0), Rejection.NONE),
        ((10.0, 9.9, math.nan, math.nan), Rejection.NONE),
        ((math.nan, 9.9, 1.0, -1.0), Rejection.NONE),
        ((math.nan, math.nan, 1.0, -1.0), Rejection.NONE),
        ((math.nan, math.nan, math.nan, math.nan), Rejection.NOT_FINITE),
        ((10.0, -math.inf, 1.0, -1.0), Rejection.NOT_FINITE),
        ((10.0, 9.9, math.inf, -1.0), Rejection.NOT_FINITE),
        ((1001.0, 9.9, 1.0, -1.0), Rejection.OUT_OF_RANGE),
        ((10.0, 9.9, 1.0, -501.0), Rejection.OUT_OF_RANGE),
        ((10.0, 9.9, 1.0, -1.0, 1e9, -1e9), Rejection.NONE),
        ((10.0, 9.9, 1.0, -1.0, 1.0, math.nan, 800.0, math.nan, 500.0), Rejection.NONE),
        ((10.0, 9.9, 1.0, -1.0, math.inf), Rejection.NOT_FINITE),
        ((10.0, 9.9, 1.0, -1.0, 1.0, 1.0, 800.0, -math.inf), Rejection.NOT_FINITE),
        ((10.0, 9.9, 1.0, -1.0, 1.0, 1.0, 2001.0), Rejection.OUT_OF_RANGE),
        ((10.0, 9.9, 1.0, -1.0, 1.0, 1.0, 800.0, 800.0, -2001.0), Rejection.OUT_OF_RANGE),
    ],
)
def test_a_measurement_is_judged_by_its_values(values, reason) -> None:
    assert check_measurement(Measurement(0, *values), LIMITS) is reason


@pytest.mark.parametrize(
    ("names", "velocities", "efforts", "positions", "reason"),
    [
        ((), (), (), (), Rejection.MALFORMED),
        (("motor", "roller"), (1.0,), (), (), Rejection.MALFORMED),
        (("motor", "roller"), (1.0, 2.0), (1.0,), (), Rejection.MALFORMED),
        (("motor", "roller"), (1.0, 2.0), (), (1.0, 2.0, 3.0), Rejection.MALFORMED),
        (("motor", "roller"), (), (), (), Rejection.INCOMPLETE),
        (("motor", "roller"), (), (), (1.0, 2.0), Rejection.INCOMPLETE),
        (("motor", "other"), (1.0, 2.0), (), (), Rejection.INCOMPLETE),
    ],
)
def test_a_joint_state_that_cannot_be_read_says_why(
    names, velocities, efforts, positions, reason
) -> None:
    found = measurement_from_joints(DRIVER, DRIVEN, 0, names, velocities, efforts, positions)
    assert found is reason


def test_a_speed_that_is_missing_takes_a_torque_along_only_where_there_is_drag() -> None:
    arguments = 7, ["motor", "roller"], [math.nan, 2.0], [5.0, -4.0]
    found = measurement_from_joints(DRIVER, DRIVEN, *arguments)
    assert isinstance(found, Measurement)
    assert math.isnan(found.driver_speed)
    assert (found.driver_torque, found.driven_torque) == (5.0, -4.0)
    rubbing = dataclasses.replace(DRIVER, drag_damping=0.1)
    found = measurement_from_joints(rubbing, DRIVEN, *arguments)
    assert isinstance(found, Measurement)
    assert math.isnan(found.driver_torque)
    assert found.driven_torque == -4.0


@pytest.mark.parametrize("lengths", [(2, 0, 0), (0, 0, 2), (0, 0, 0), (1, 0, 0)])
def test_a_joint_state_of_somebody_else_is_nothing(lengths) -> None:
    arrays = ([1.0] * length for length in lengths)
    assert measurement_from_joints(DRIVER, DRIVEN, 0, ("elbow", "wrist"), *arrays) is None


def test_joints_are_found_by_name_and_what_is_missing_is_nan() -> None:
    found = measurement_from_joints(DRIVER, DRIVEN, 7, ["a", "roller", "motor"], [1, 2, 3], [])
    assert isinstance(found, Measurement)
    assert (found.stamp_ns, found.driver_speed, found.driven_speed) == (7, 3.0, 2.0)
    assert np.all(np.isnan(found.values()[Sensor.DRIVER_TORQUE :]))


def test_positions_are_read_like_speeds() -> None:
    geared = Joint("motor", gear_ratio=5.0, sign=-1.0)
    names, nothing = ["roller", "motor"], [0.0, 0.0]
    found = measurement_from_joints(geared, DRIVEN, 0, names, nothing, [], [2.0, -35.0])
    assert isinstance(found, Measurement)
    assert found.positions == (7.0, 2.0)
    assert geared.turn == pytest.approx(2.0 * math.pi / 5.0)


# A motor with 0.2 N m/A behind a gear of 5:1, mounted the other way round, whose drive shows 0.5 A
# at no torque. The pulley's bearings take 0.4 N m and 0.02 N m s/rad.
GEARED = Joint(
    "motor",
    gear_ratio=5.0,
    sign=-1.0,
    torque_scale=0.2,
    torque_offset=0.5,
    drag_torque=0.4,
    drag_damping=0.02,
)


@pytest.mark.parametrize(
    ("velocity", "speed", "torque"),
    [
        # -7.5 A: -8 A, -1.6 N m at the motor, +1.6 N m along the belt, 8 N m at the pulley.
        (-50.0, 10.0, 8.0 - 0.4 - 0.2),
        (50.0, -10.0, 8.0 + 0.4 + 0.2),  # braking: the bearings help
        (0.0, 0.0, 8.0),
    ],
)
def test_effort_becomes_the_torque_that_the_belt_sees(velocity, speed, torque) -> None:
    found = measurement_from_joints(
        GEARED, DRIVEN, 0, ["motor", "roller"], [velocity, 9.0], [-7.5, 1.0]
    )
    assert isinstance(found, Measurement)
    assert found.driver_speed == pytest.approx(speed)
    assert found.driver_torque == pytest.approx(torque)
    assert GEARED.effort(torque, speed) == pytest.approx(-7.5)


@REPEATABLE
@given(st.floats(-1e3, 1e3), st.floats(1e-9, 1e3))
def test_drag_takes_power_and_never_jumps(speed, step) -> None:
    assert GEARED.drag(speed) * speed >= 0.0
    assert GEARED.drag(-speed) == -GEARED.drag(speed)
    steepest = 0.4 / 0.05 + 0.02
    assert (
        abs(GEARED.drag(speed + step) - GEARED.drag(speed)) <= steepest * step * (1 + 1e-9) + 1e-9
    )


def test_a_driven_pulley_that_coasts_is_slowed_by_its_bearings() -> None:
    coasting = Joint("roller", drag_torque=0.3)
    assert coasting.pulley_torque(0.0, 20.0) == pytest.approx(-0.3)
    assert coasting.pulley_torque(0.0, -20.0) == pytest.approx(0.3)
    assert abs(coasting.pulley_torque(0.0, 1e-4)) < 1e-3


def test_values_stand_where_sensor_says() -> None:
    measurement = Measurement(0, *np.arange(9.0).tolist())
    np.testing.assert_array_equal(measurement.values(), np.arange(9.0))
    names = [field.name for field in dataclasses.fields(Measurement)][1 : 1 + len(Sensor)]
    assert [sensor.name.lower() for sensor in Sensor] == names


def test_noise_is_relative_absolute_and_of_rounding() -> None:
    noise = SensorNoise(
        speed_relative=1e-3,
        speed_absolute=0.02,
        torque_relative=0.01,
        torque_absolute=0.1,
        speed_quantum=0.3,
        position_absolute=1e-4,
        position_quantum=1e-3,
        load_relative=0.02,
        load_absolute=3.0,
    )
    values = np.array([100.0, -50.0, 20.0, -10.0, 1e6, math.nan, 400.0, math.nan, 0.0])
    found = sensor_variances(values, noise.noise_rows())
    expected = [
        0.1**2 + 0.02**2 + 0.3**2 / 12,
        0.05**2 + 0.02**2 + 0.3**2 / 12,
        0.2**2 + 0.1**2,
        0.1**2 + 0.1**2,
        1e-4**2 + 1e-3**2 / 12,
        math.nan,
        8.0**2 + 3.0**2,
        math.nan,
        3.0**2,
    ]
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_rounding_to_a_quantum_has_the_variance_that_is_stated() -> None:
    quantum = 0.3
    speeds = np.random.default_rng(1).uniform(-100.0, 100.0, 100_000)
    errors = np.round(speeds / quantum) * quantum - speeds
    rounding = SensorNoise(speed_quantum=quantum).noise_rows() - SensorNoise().noise_rows()
    assert np.var(errors) == pytest.approx(rounding[1, Sensor.DRIVER_SPEED], rel=0.02)


TURN = 2.0 * math.pi


@REPEATABLE
@given(
    st.lists(st.tuples(st.floats(-50.0, 50.0), st.floats(-0.49, 0.49)), min_size=1, max_size=30),
    st.sampled_from([-math.pi, 0.0]),
    st.sampled_from([1.0, 0.25, 7.0]),
)
def test_a_position_that_wraps_is_followed_over_any_number_of_turns(moves, lowest, gear) -> None:
    joint = Joint("motor", gear_ratio=gear)
    true, followed = 0.3, 0.3
    for increment, misjudged in moves:
        true += increment
        reported = joint.pulley_position((true * gear - lowest) % TURN + lowest)
        expected = increment + misjudged * joint.turn
        followed = unwrapped(followed, reported, expected, joint.turn)
        assert followed == pytest.approx(true, abs=1e-9)


def test_an_encoder_that_counts_on_is_left_alone() -> None:
    assert unwrapped(1000.0, 1003.0, 2.0, TURN) == 1003.0
    assert unwrapped(1000.0, 1040.0, 39.0, TURN) == 1040.0


def test_across_a_gap_the_turns_are_those_expected() -> None:
    assert unwrapped(3.0, -3.0, 100.0, TURN) == pytest.approx(-3.0 + 17 * TURN)


@pytest.mark.parametrize(
    ("previous", "present", "expected", "turn"),
    [
        (math.nan, 1.0, 0.1, TURN),
        (math.inf, 1.0, 0.1, TURN),
        (0.0, 1.0, math.nan, TURN),
        (0.0, 1.0, -math.inf, TURN),
        (0.0, 1.0, 1e300, TURN),
        (0.0, 1e300, 0.1, TURN),
        (1e300, 1e300, 0.1, TURN),
        (0.0, 1.0, 0.1, 0.0),
        (0.0, 1.0, 0.1, math.nan),
    ],
)
def test_where_turns_cannot_be_told_the_position_is_taken_as_reported(
    previous, present, expected, turn
) -> None:
    assert unwrapped(previous, present, expected, turn) == present


def test_a_missing_position_stays_missing() -> None:
    assert math.isnan(unwrapped(0.0, math.nan, 0.1, TURN))


@REPEATABLE
@given(
    st.lists(st.sampled_from(["motor", "roller", ""]), max_size=4),
    st.lists(st.floats(), max_size=4),
    st.lists(st.floats(), max_size=4),
    st.lists(st.floats(), max_size=4),
)
def test_no_joint_state_raises(names, velocities, efforts, positions) -> None:
    found = measurement_from_joints(GEARED, DRIVEN, 0, names, velocities, efforts, positions)
    assert isinstance(found, Measurement | Rejection | None)
    assert (found is None) == (len(names) > 0 and not {GEARED.name, DRIVEN.name} & set(names))
    if isinstance(found, Measurement):
        check_measurement(found, LIMITS)
