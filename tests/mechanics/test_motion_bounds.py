"""The drive in motion makes no energy, and no input breaks it."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from moving_drive import TENSION, balanced, make_condition, make_drive, run

from belt_ros.mechanics import BeltDrive, torque_capacity
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.motion import (
    Condition,
    Motion,
    condition_capacity,
    predicted_slip,
    step_motion,
)

REPEATABLE = settings(derandomize=True, deadline=None, max_examples=200)

# --- Energy ----------------------------------------------------------------------------------


def energy(drive: BeltDrive, state: Motion) -> float:
    """Kinetic energy of the pulleys and strain energy of both spans' change of tension [J]."""
    compliance = drive.span_length / (2.0 * drive.belt.axial_stiffness)
    return 0.5 * (
        drive.driver.inertia * state.driver_speed**2
        + drive.driven.inertia * state.driven_speed**2
        + compliance * state.pull**2
    )


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("dt", [1e-4, 2e-3, 0.05])
def test_no_history_creates_energy(seed: int, dt: float) -> None:
    rng = np.random.default_rng(seed)
    drive = make_drive(stiffness=10.0 ** rng.uniform(5.0, 9.0))
    c = drive_constants(drive)
    state = Motion(rng.uniform(-80.0, 80.0), rng.uniform(-60.0, 60.0), rng.uniform(-500.0, 500.0))
    work_in, lost, first = 0.0, 0.0, energy(drive, state)
    condition = make_condition(drive, 0.0, 0.0)
    for step in range(1000):
        if step % 25 == 0:
            driver_torque, driven_torque = rng.normal(0.0, 60.0, 2)
            condition = make_condition(
                drive,
                driver_torque,
                driven_torque,
                tension=rng.uniform(5.0, 900.0),
                friction=rng.uniform(0.2, 1.5),
            )
        after = step_motion(c, state, condition, dt)
        work = dt * (
            condition.driver_torque * after.driver_speed
            + condition.driven_torque * after.driven_speed
        )
        before = energy(drive, state)
        loss = work - (energy(drive, after) - before)
        assert loss >= -1e-12 * (abs(work) + before + energy(drive, after))
        work_in, lost, state = work_in + work, lost + loss, after
    assert lost > 0.0
    assert work_in == pytest.approx(energy(drive, state) - first + lost, rel=1e-9)


def test_steady_loss_is_the_pull_times_the_sliding_speed() -> None:
    drive = make_drive(stiffness=1e6)
    c = drive_constants(drive)
    torque = 0.8 * float(torque_capacity(drive, TENSION, 100.0))
    condition = balanced(drive, torque)
    state = run(c, Motion(100.0, 73.0, 0.0), condition, 0.01, 4000)
    power = condition.driver_torque * state.driver_speed
    power += condition.driven_torque * state.driven_speed
    slip = predicted_slip(c, state, condition)
    assert power == pytest.approx(state.pull * 0.06 * state.driver_speed * slip, rel=1e-6)
    assert slip > 1e-3


# --- Any input -------------------------------------------------------------------------------


SPEED = st.floats(-1e4, 1e4)
TORQUE = st.floats(-1e6, 1e6)
RANGES = {
    "state": st.builds(Motion, SPEED, SPEED, st.floats(-1e6, 1e6)),
    "condition": st.builds(
        Condition,
        driver_torque=TORQUE,
        driven_torque=TORQUE,
        tension=st.floats(-1e3, 1e6),
        friction=st.floats(-5.0, 1.0).map(lambda power: 10.0**power),
        stiffness=st.floats(0.0, 20.0).map(lambda power: 10.0**power),
        ratio_bias=st.floats(-0.1, 0.1),
        creep_error=st.floats(-0.99, 5.0),
        undeveloped=st.floats(-0.5, 0.5),
    ),
    "dt": st.floats(-9.0, 6.0).map(lambda power: 10.0**power),
    "mass": st.sampled_from([0.0, 0.1, 5.0]),
}
STOPPED = Motion(0.0, 0.0, 0.0)
LIFTED = Condition(1.0, -1.0, 5.0, 1.2, 1e7, 0.0, 0.0)


@given(**RANGES)
@example(state=Motion(120.0, 90.0, 50.0), condition=LIFTED, dt=0.01, mass=5.0)
@example(state=STOPPED, condition=LIFTED._replace(tension=-1.0), dt=0.01, mass=0.1)
@example(state=STOPPED, condition=LIFTED._replace(stiffness=1e20), dt=0.01, mass=0.0)
@example(state=STOPPED, condition=LIFTED._replace(stiffness=1.0), dt=0.01, mass=0.0)
@settings(REPEATABLE, max_examples=1500)
def test_any_finite_input_gives_a_finite_motion_within_capacity(
    state: Motion, condition: Condition, dt: float, mass: float
) -> None:
    c = drive_constants(make_drive(mass))
    after = step_motion(c, state, condition, dt)
    assert all(math.isfinite(value) for value in after)
    rim = abs(c.driver_radius * state.driver_speed)
    assert abs(after.pull) <= condition_capacity(c, condition, rim, True)


@given(**RANGES)
@settings(REPEATABLE, max_examples=1000)
def test_any_finite_input_gives_a_finite_prediction_of_slip(
    state: Motion, condition: Condition, dt: float, mass: float
) -> None:
    slip = predicted_slip(drive_constants(make_drive(mass)), state, condition)
    assert math.isfinite(slip)
    assert slip <= 0.9


@pytest.mark.parametrize("tension", [5.0, 0.0, -100.0])
def test_a_belt_that_lifts_off_pulls_nothing(tension: float) -> None:
    drive = make_drive()
    c = drive_constants(drive)
    condition = make_condition(drive, 10.0, -20.0, tension=tension)
    state = step_motion(c, Motion(150.0, 110.0, 200.0), condition, 0.01)
    assert state.pull == 0.0
    assert state.driver_speed == pytest.approx(150.0 + 0.01 * 10.0 / 0.02)
    assert state.driven_speed == pytest.approx(110.0 - 0.01 * 20.0 / 0.05)
