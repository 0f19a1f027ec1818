"""The drive in motion comes to rest in equilibrium."""

import pytest
from moving_drive import TENSION, balanced, make_drive, run, slip_of

from belt_ros.mechanics import BeltDrive, solve_equilibrium, torque_capacity
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.creep import creep
from belt_ros.mechanics.motion import Motion, predicted_slip


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
