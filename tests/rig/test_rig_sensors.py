"""Encoders count, drives round and add noise; what the node reads back is what was there."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from belt_ros.estimation import Joint, Measurement, SensorNoise, measurement_from_joints
from belt_ros.rig import RigSample
from belt_ros.rig.sensors import SensorErrors, Sensors, counted, joint_values, rounded
from belt_ros.settings import DriveSettings

Run = Callable[..., list[RigSample]]


def test_encoder_counts_up_to_the_angle() -> None:
    quarter = 0.5 * np.pi
    assert counted(0.9 * quarter, 4.0) == 0.0
    assert counted(1.1 * quarter, 4.0) == pytest.approx(quarter)
    assert counted(-0.1 * quarter, 4.0) == pytest.approx(-quarter)


def test_speed_comes_in_steps_of_the_resolution(run: Run) -> None:
    samples = run(duration=1.0, speed=[[0.0, 0.0], [1.0, 10.0]], sensors__speed_resolution=0.25)

    steps = np.array([sample.joints.velocities for sample in samples]) / 0.25
    np.testing.assert_array_equal(steps, np.round(steps))
    assert rounded(1.234, 0.0) == 1.234


def test_exact_sensors_report_the_truth(run: Run) -> None:
    for sample in run(duration=0.5, speed=100.0, load=30.0):
        truth, joints = sample.truth, sample.joints
        assert joints.velocities == (truth.driver_speed, truth.driven_speed)
        assert joints.efforts == (truth.driver_torque, truth.driven_torque)


def test_position_is_the_integral_of_speed(run: Run) -> None:
    samples = run(duration=2.0, speed=100.0, load=30.0)

    first, last = samples[0], samples[-1]
    for pulley in (0, 1):
        turned = last.joints.positions[pulley] - first.joints.positions[pulley]
        assert turned == pytest.approx(2.0 * last.joints.velocities[pulley], rel=1e-6)


def test_noise_is_that_of_the_drive_description_unless_told(
    run: Run, settings: DriveSettings
) -> None:
    noise = settings.noise
    samples = run(
        duration=20.0,
        speed=100.0,
        load=30.0,
        sensors__speed_relative=noise.speed_relative,
        sensors__speed_absolute=noise.speed_absolute,
        sensors__torque_absolute=0.7,
    )

    speed = [sample.joints.velocities[0] - sample.truth.driver_speed for sample in samples]
    torque = [sample.joints.efforts[1] - sample.truth.driven_torque for sample in samples]
    expected = np.hypot(100.0 * noise.speed_relative, noise.speed_absolute)
    assert np.std(speed) == pytest.approx(expected, rel=0.1)
    assert np.std(torque) == pytest.approx(0.7, rel=0.1)
    assert {field.name for field in dataclasses.fields(SensorNoise)} <= {
        field.name for field in dataclasses.fields(SensorErrors)
    }


def test_joint_is_read_back_through_gear_sign_and_scale() -> None:
    driver = Joint("a", gear_ratio=7.0, sign=-1.0, torque_scale=0.3, torque_offset=2.0)
    driven = Joint("b")
    _, velocity, effort = joint_values(driver, 1.0, 12.0, -34.0)
    _, other_velocity, other_effort = joint_values(driven, 1.0, 11.0, 5.0)

    measured = measurement_from_joints(
        driver, driven, 0, ["a", "b"], [velocity, other_velocity], [effort, other_effort]
    )

    assert isinstance(measured, Measurement)
    assert measured.driver_speed == pytest.approx(12.0)
    assert measured.driver_torque == pytest.approx(-34.0)
    assert measured.driven_torque == pytest.approx(5.0)


def test_joint_without_a_torque_scale_is_refused() -> None:
    random = np.random.default_rng(1)
    with pytest.raises(ValueError, match=r"driver\.torque_scale is 0"):
        Sensors(Joint("a", torque_scale=0.0), Joint("b"), SensorErrors(), random)
