import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from belt_ros.estimation import Joint, Measurement, Rejection, SensorLimits
from belt_ros.estimation.measurement import check_measurement, measurement_from_joints

DRIVER, DRIVEN = Joint(name="motor"), Joint(name="roller")
LIMITS = SensorLimits(greatest_speed=1000.0, greatest_torque=500.0)


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ((10.0, 9.9, 1.0, -1.0), Rejection.NONE),
        ((10.0, 9.9, math.nan, math.nan), Rejection.NONE),
        ((math.nan, 9.9, 1.0, -1.0), Rejection.NOT_FINITE),
        ((10.0, -math.inf, 1.0, -1.0), Rejection.NOT_FINITE),
        ((10.0, 9.9, math.inf, -1.0), Rejection.NOT_FINITE),
        ((1001.0, 9.9, 1.0, -1.0), Rejection.OUT_OF_RANGE),
        ((10.0, 9.9, 1.0, -501.0), Rejection.OUT_OF_RANGE),
    ],
)
def test_a_measurement_is_judged_by_its_values(values, reason) -> None:
    assert check_measurement(Measurement(0, *values), LIMITS) is reason


@pytest.mark.parametrize(
    ("names", "velocities", "efforts", "reason"),
    [
        ((), (), (), Rejection.MALFORMED),
        (("motor", "roller"), (1.0,), (), Rejection.MALFORMED),
        (("motor", "roller"), (1.0, 2.0), (1.0,), Rejection.MALFORMED),
        (("motor", "roller"), (), (), Rejection.INCOMPLETE),
        (("motor", "other"), (1.0, 2.0), (), Rejection.INCOMPLETE),
    ],
)
def test_a_joint_state_that_cannot_be_read_says_why(names, velocities, efforts, reason) -> None:
    assert measurement_from_joints(DRIVER, DRIVEN, 0, names, velocities, efforts) is reason


def test_joints_are_found_by_name_and_missing_efforts_are_nan() -> None:
    found = measurement_from_joints(DRIVER, DRIVEN, 7, ["a", "roller", "motor"], [1, 2, 3], [])
    assert isinstance(found, Measurement)
    assert (found.stamp_ns, found.driver_speed, found.driven_speed) == (7, 3.0, 2.0)
    assert math.isnan(found.driver_torque)


def test_sign_gear_ratio_and_torque_scale_lead_from_joint_to_pulley() -> None:
    geared = Joint("motor", gear_ratio=5.0, sign=-1.0, torque_scale=0.2, torque_offset=0.5)
    found = measurement_from_joints(
        geared, DRIVEN, 0, ["motor", "roller"], [-50.0, 9.0], [-2.5, 1.0]
    )
    assert isinstance(found, Measurement)
    assert found.driver_speed == pytest.approx(10.0)
    assert found.driver_torque == pytest.approx(3.0)


@given(
    st.lists(st.sampled_from(["motor", "roller", ""]), max_size=4),
    st.lists(st.floats(), max_size=4),
    st.lists(st.floats(), max_size=4),
)
def test_no_joint_state_raises(names, velocities, efforts) -> None:
    found = measurement_from_joints(DRIVER, DRIVEN, 0, names, velocities, efforts)
    assert isinstance(found, Measurement | Rejection)
