"""The drive in motion: its rest in equilibrium, its energy, and what no input may break."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from belt_ros.mechanics import Belt, BeltDrive, Pulley, solve_equilibrium, torque_capacity
from belt_ros.mechanics.constants import DriveConstants, drive_constants
from belt_ros.mechanics.creep import creep, pull_capacity
from belt_ros.mechanics.motion import (
    Condition,
    Motion,
    condition_capacity,
    predicted_slip,
    step_motion,
)

REPEATABLE = settings(derandomize=True, deadline=None, max_examples=200)
TENSION = 435.0


def make_drive(mass: float = 0.1036, stiffness: float = 8.1e7) -> BeltDrive:
    driven = Pulley(0.08125, math.pi, 1.2, stiffness, inertia=0.05)
    driver = Pulley(0.06, 2.8, 1.25, 1.5 * stiffness, inertia=0.02)
    return BeltDrive(Belt(80068.0, mass), driven, driver, span_length=0.51)


def make_condition(
    drive: BeltDrive, driver_torque: float, driven_torque: float, **changed: float
) -> Condition:
    given_condition = Condition(
        driver_torque=driver_torque,
        driven_torque=driven_torque,
        tension=TENSION,
        friction=drive.driven.friction_coefficient,
        stiffness=drive.driven.friction_stiffness,
        ratio_bias=0.0,
        creep_error=0.0,
    )
    return given_condition._replace(**changed)


def balanced(drive: BeltDrive, torque: float) -> Condition:
    """Outside torques that a steady pull of torque/R1 balances."""
    return make_condition(drive, torque * drive.driver.radius / drive.driven.radius, -torque)


def run(c: DriveConstants, state: Motion, condition: Condition, dt: float, steps: int) -> Motion:
    for _ in range(steps):
        state = step_motion(c, state, condition, dt)
    return state


def slip_of(drive: BeltDrive, state: Motion) -> float:
    rims = drive.driven.radius * state.driven_speed, drive.driver.radius * state.driver_speed
    return 1.0 - rims[0] / rims[1]


# --- Rest is the equilibrium -----------------------------------------------------------------


def settle(drive: BeltDrive, load: float, speed: float) -> tuple[Motion, float]:
    """Let the drive come to rest at a share of its capacity; its motion and torque."""
    torque = load * float(torque_capacity(drive, TENSION, speed))
    start = Motion(speed, speed * drive.driver.radius / drive.driven.radius, 0.0)
    return run(drive_constants(drive), start, balanced(drive, torque), 0.05, 1500), torque


LOADS = pytest.mark.parametrize("load", [-0.9, -0.4, 0.3, 0.9])
SPEEDS = pytest.mark.parametrize("speed", [150.0, -150.0])


@pytest.mark.parametrize("stiffness", [1e6, 2.8e7, 8.1e9])
@LOADS
@SPEEDS
def test_motion_settles_in_the_equilibrium(stiffness: float, load: float, speed: float) -> None:
    drive = make_drive(0.0, stiffness)
    state, torque = settle(drive, load, speed)
    expected = solve_equilibrium(drive, torque, TENSION, state.driver_speed)
    assert state.pull == pytest.approx(torque / drive.driven.radius, rel=1e-9)
    assert slip_of(drive, state) == pytest.approx(float(expected.slip), rel=1e-8)
    assert state.driven_speed == pytest.approx(float(expected.driven_speed), rel=1e-9)


@pytest.mark.parametrize("stiffness", [1e6, 2.8e7, 8.1e9])
@LOADS
@SPEEDS
def test_a_heavy_belt_settles_with_its_inertia_at_the_drivers_rim_speed(
    stiffness: float, load: float, speed: float
) -> None:
    drive = make_drive(stiffness=stiffness)
    state, torque = settle(drive, load, speed)
    forward = torque * speed > 0.0
    pull = abs(torque) / drive.driven.radius
    rim = abs(state.driver_speed) * drive.driver.radius
    received = creep(drive_constants(drive), pull, TENSION, 1.2, stiffness, rim, forward).slip
    expected = received if forward else received / (received - 1.0)
    assert slip_of(drive, state) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("load", [-0.9, -0.4, 0.3, 0.6])
@SPEEDS
def test_a_heavy_belt_settles_in_the_equilibrium(load: float, speed: float) -> None:
    # The equilibrium takes inertia at the belt's own speed, which is slower by creep.
    drive = make_drive()
    state, torque = settle(drive, load, speed)
    expected = solve_equilibrium(drive, torque, TENSION, state.driver_speed)
    assert state.driven_speed == pytest.approx(float(expected.driven_speed), rel=1e-6)


@pytest.mark.parametrize("load", [-0.9, 0.9])
def test_predicted_slip_is_the_equilibrium_slip_at_the_present_pull(load: float) -> None:
    drive = make_drive(mass=0.0)
    torque = load * float(torque_capacity(drive, TENSION))
    expected = solve_equilibrium(drive, torque, TENSION, 100.0)
    state = Motion(100.0, float(expected.driven_speed), torque / drive.driven.radius)
    condition = balanced(drive, torque)
    c = drive_constants(drive)
    assert predicted_slip(c, state, condition) == pytest.approx(float(expected.slip), rel=1e-12)
    mirrored = Motion(*(-value for value in state))
    assert predicted_slip(c, mirrored, condition) == pytest.approx(float(expected.slip), rel=1e-12)


@pytest.mark.parametrize("load", [-0.5, 0.8])
def test_creep_error_and_ratio_bias_act_as_their_names_say(load: float) -> None:
    drive = make_drive(mass=0.0)
    torque = load * float(torque_capacity(drive, TENSION))
    bias = 2e-3
    condition = balanced(drive, torque)._replace(ratio_bias=bias, creep_error=0.1)
    state = run(drive_constants(drive), Motion(100.0, 70.0, 0.0), condition, 0.05, 1500)
    true_ratio = (1.0 - slip_of(drive, state)) * (1.0 + bias)
    slip = float(solve_equilibrium(drive, torque, TENSION, 100.0).slip)
    received = slip if slip > 0.0 else slip / (slip - 1.0)
    expected = 1.0 - 1.1 * received if slip > 0.0 else 1.0 / (1.0 - 1.1 * received)
    assert true_ratio == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("undeveloped", [2e-3, -2e-3])
def test_undeveloped_creep_adds_to_the_slip_of_equilibrium(undeveloped: float) -> None:
    drive = make_drive(mass=0.0)
    torque = 0.6 * float(torque_capacity(drive, TENSION))
    condition = balanced(drive, torque)._replace(undeveloped=undeveloped)
    state = run(drive_constants(drive), Motion(100.0, 70.0, 0.0), condition, 0.05, 1500)
    slip = float(solve_equilibrium(drive, torque, TENSION, 100.0).slip)
    assert slip_of(drive, state) == pytest.approx(slip + undeveloped, rel=1e-9)


def test_rotation_reversal_mirrors_the_motion() -> None:
    drive = make_drive()
    c = drive_constants(drive)
    one, other = Motion(80.0, 60.0, 50.0), Motion(-80.0, -60.0, -50.0)
    condition = make_condition(drive, 30.0, -25.0)
    mirror = make_condition(drive, -30.0, 25.0)
    for _ in range(200):
        one = step_motion(c, one, condition, 2e-3)
        other = step_motion(c, other, mirror, 2e-3)
        assert tuple(other) == tuple(-value for value in one)


# --- The law itself --------------------------------------------------------------------------


def test_steps_converge_to_the_differential_equation_at_first_order() -> None:
    drive = make_drive(mass=0.05, stiffness=1e6)
    c = drive_constants(drive)
    condition = make_condition(drive, 28.0, -30.0)
    start = Motion(100.0, 73.0, 100.0)

    def rates(_: float, y: Any) -> list[float]:
        v2, v1 = 0.06 * y[0], 0.08125 * y[1]
        forward = y[2] >= 0.0
        slip = creep(c, abs(y[2]), TENSION, 1.2, 1e6, abs(v2), forward).slip
        relaxation = max(abs(v1), abs(v2)) * slip * (1.0 if forward else -1.0)
        return [
            (28.0 - 0.06 * y[2]) / 0.02,
            (-30.0 + 0.08125 * y[2]) / 0.05,
            (v2 - v1 - relaxation) * 2.0 * 80068.0 / 0.51,
        ]

    exact = solve_ivp(rates, (0.0, 0.02), list(start), rtol=1e-11, atol=1e-9).y[:, -1]
    errors = [
        np.abs(np.array(run(c, start, condition, 0.02 / steps, steps)) - exact)
        for steps in (4000, 8000)
    ]
    np.testing.assert_allclose(errors[0] / errors[1], 2.0, rtol=0.05)
    np.testing.assert_allclose(errors[1] / np.abs(exact), 0.0, atol=2e-3)


@pytest.mark.parametrize("turning", [1.0, -1.0])
@pytest.mark.parametrize(
    ("motor", "load"), [(60.0, 18.0), (22.0, 48.0)], ids=["speeding up", "slowing down"]
)
def test_a_long_step_of_a_drive_that_gains_speed_has_the_slip_of_its_end(
    motor: float, load: float, turning: float
) -> None:
    """Its speed changes by more than 6 % in the step; slip is to be right to 2 % of its value."""
    drive = make_drive(stiffness=1e6)
    c = drive_constants(drive)
    condition = make_condition(drive, turning * motor, -turning * load)
    start = run(c, Motion(turning * 80.0, turning * 59.0, 0.0), condition, 1e-4, 500)
    end = run(c, start, condition, 1e-4, 200)
    slip = slip_of(drive, end)
    assert abs(end.driver_speed / start.driver_speed - 1.0) > 0.06
    assert abs(slip) > 3e-3
    assert slip_of(drive, step_motion(c, start, condition, 0.02)) == pytest.approx(slip, rel=0.02)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("stiffness", "shortfall"), [(1e5, 0.03), (8.1e7, 1e-4)])
def test_gross_slip_holds_the_pull_at_capacity_and_stalls_the_driven_pulley(
    sign: float, stiffness: float, shortfall: float
) -> None:
    drive = make_drive(stiffness=stiffness)
    c = drive_constants(drive)
    capacity = pull_capacity(c, TENSION, 1.2, stiffness, 0.06 * 100.0, True)
    overload = make_condition(
        drive, sign * capacity * 0.06, -sign * 1.3 * capacity * drive.driven.radius
    )
    state = Motion(sign * 100.0, sign * 100.0 * 0.06 / 0.08125, 0.0)
    state = run(c, state, overload, 1e-3, 100)
    for _ in range(100):
        before, state = state, step_motion(c, state, overload, 1e-3)
        capacity = pull_capacity(c, TENSION, 1.2, stiffness, 0.06 * abs(before.driver_speed), True)
        assert (1.0 - shortfall) * capacity < sign * state.pull < capacity
        slip = 1.0 - 0.08125 * before.driven_speed / (0.06 * before.driver_speed)
        if slip < 0.9:  # the pull is the one that belongs to the slip: just how far short it falls
            rim = 0.06 * abs(before.driver_speed)
            steady = creep(c, abs(state.pull), TENSION, 1.2, stiffness, rim, True)
            assert steady.slip == pytest.approx(slip, rel=0.02)
        fall = sign * (state.driven_speed - before.driven_speed) / 1e-3
        assert fall < -0.29 * capacity * drive.driven.radius / drive.driven.inertia
    assert sign * state.driven_speed < 0.0


@pytest.mark.parametrize("stiffness", [1e5, 1e6, 8.1e7])
def test_drive_recovers_from_gross_slip_when_the_load_goes(stiffness: float) -> None:
    drive = make_drive(mass=0.0, stiffness=stiffness)
    c = drive_constants(drive)
    capacity = pull_capacity(c, TENSION, 1.2, stiffness, 0.0, True)
    overload = make_condition(drive, capacity * 0.06, -2.0 * capacity * drive.driven.radius)
    state = run(c, Motion(100.0, 73.0, 0.0), overload, 1e-3, 60)
    assert state.pull > 0.99 * capacity
    torque = 0.2 * capacity * drive.driven.radius
    state = run(c, state, balanced(drive, torque), 0.01, 3000)
    expected = solve_equilibrium(drive, torque, TENSION, state.driver_speed)
    assert state.pull == pytest.approx(0.2 * capacity, rel=1e-9)
    assert slip_of(drive, state) == pytest.approx(float(expected.slip), rel=1e-7)


def test_standstill_does_not_creep_and_holds_its_wind_up() -> None:
    drive = make_drive()
    c = drive_constants(drive)
    pull = 300.0
    condition = make_condition(drive, 0.06 * pull, -0.08125 * pull)
    state = run(c, Motion(0.0, 0.0, pull), condition, 0.01, 2000)
    assert state.pull == pytest.approx(pull, rel=1e-12)
    assert state.driver_speed == pytest.approx(0.0, abs=1e-12)
    assert state.driven_speed == pytest.approx(0.0, abs=1e-12)


def test_standstill_cannot_hold_more_than_the_capacity() -> None:
    drive = make_drive()
    c = drive_constants(drive)
    capacity = pull_capacity(c, TENSION, 1.2, drive.driven.friction_stiffness, 0.0, True)
    condition = make_condition(drive, 0.06 * 2.0 * capacity, -0.08125 * 2.0 * capacity)
    state = step_motion(c, Motion(0.0, 0.0, capacity), condition, 0.01)
    assert state.pull == pytest.approx(capacity, rel=1e-8)
    assert state.driver_speed > 0.0 > state.driven_speed


@pytest.mark.parametrize("dt", [1.0, 1e3, 1e6])
def test_a_step_of_any_length_is_stable(dt: float) -> None:
    drive = make_drive(mass=0.0)
    c = drive_constants(drive)
    torque = 0.5 * float(torque_capacity(drive, TENSION))
    condition = balanced(drive, torque)
    state = run(c, Motion(100.0, 50.0, -200.0), condition, dt, 50)
    expected = solve_equilibrium(drive, torque, TENSION, state.driver_speed)
    assert state.pull == pytest.approx(torque / drive.driven.radius, rel=1e-9)
    assert slip_of(drive, state) == pytest.approx(float(expected.slip), rel=1e-4)


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
