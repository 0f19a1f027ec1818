"""The law of motion: its steps however long, in gross slip, at standstill and in reverse."""

from typing import Any

import numpy as np
import pytest
from moving_drive import TENSION, balanced, make_condition, make_drive, run, slip_of
from scipy.integrate import solve_ivp

from belt_ros.mechanics import solve_equilibrium, torque_capacity
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.creep import creep, pull_capacity
from belt_ros.mechanics.motion import Motion, step_motion


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
