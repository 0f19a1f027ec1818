"""What is read off a state is a number, however far from any drive the state has strayed."""

import math

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

from belt_ros.estimation.bank import UnscentedBank
from belt_ros.estimation.state import STATES, Index, propagate, read
from belt_ros.mechanics import Belt, BeltDrive, Pulley, Tensioning
from belt_ros.mechanics.constants import drive_constants

DRIVEN, DRIVER = (
    Pulley(radius, wrap, 0.5, 2e7, inertia)
    for radius, wrap, inertia in ((0.03, 3.477, 0.03), (0.01, 2.806, 2e-4))
)
TENSIONINGS = list(Tensioning)
LOGARITHMS = st.floats(-150.0, 150.0)


def drive(tensioning: Tensioning, axial_stiffness: float) -> BeltDrive:
    return BeltDrive(
        Belt(axial_stiffness, mass_per_length=0.015), DRIVER, DRIVEN, 0.118, tensioning=tensioning
    )


def state(pull: float, tension: float, stiffness: float, friction: float) -> np.ndarray:
    row = np.zeros(STATES)
    row[[Index.DRIVER_SPEED, Index.DRIVEN_SPEED, Index.PULL]] = 40.0, 13.0, pull
    row[[Index.LOG_TENSION, Index.LOG_STIFFNESS, Index.LOG_FRICTION]] = tension, stiffness, friction
    return row


@given(
    st.sampled_from(TENSIONINGS),
    st.sampled_from([134.0, 1.2e4, 1.4e11, 1e12]),
    st.floats(-1e4, 1e4),
    LOGARITHMS,
    LOGARITHMS,
    LOGARITHMS,
)
@example(Tensioning.FIXED_CENTRES, 1.2e4, 7.0, 6.4, -103.6, -0.7)  # kf lost: no length was left
@example(Tensioning.FIXED_CENTRES, 1e12, 101.8, 4.3, 15.0, -0.7)  # strain drowns in rounding
@example(Tensioning.FIXED_CENTRES, 134.0, -101.8, -17.9, 15.0, -0.7)  # no tension to speak of
@example(Tensioning.CONSTANT_SLACK, 1.2e4, 10.0, 6.0, 15.0, 6.0)  # capacity beyond all bounds
@settings(max_examples=300, deadline=None)
def test_readings_and_motion_of_any_state_are_numbers(
    tensioning: Tensioning,
    axial_stiffness: float,
    pull: float,
    tension: float,
    stiffness: float,
    friction: float,
) -> None:
    constants = drive_constants(drive(tensioning, axial_stiffness))
    rows = np.stack([state(pull, tension, stiffness, friction), state(0.0, 6.0, 17.0, -0.7)])
    for order in (rows, rows[::-1].copy()):
        assert np.all(np.isfinite(read(constants, order, 0.02)))
        assert np.all(np.isfinite(propagate(constants, order, 0.01)))


@given(st.sampled_from(TENSIONINGS), LOGARITHMS, LOGARITHMS, LOGARITHMS)
@settings(max_examples=100, deadline=None)
def test_deviations_of_what_is_read_are_numbers_and_squares_of_them_too(
    tensioning: Tensioning, tension: float, stiffness: float, friction: float
) -> None:
    bank = UnscentedBank(drive_constants(drive(tensioning, 1.2e4)), np.zeros(STATES))
    bank.x = state(10.0, tension, stiffness, friction)[None]
    bank.P = np.eye(STATES)[None]
    means, deviations = bank.read(np.arange(1), 0.02)
    assert np.all(np.isfinite(means))
    assert np.all(deviations >= 0.0)
    assert math.isfinite(float(np.sum(deviations**2)))
