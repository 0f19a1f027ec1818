"""Encoders count, drives round and add noise; what the node reads back is what was there."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from belt_ros.estimation import Joint, Measurement, SensorNoise, measurement_from_joints
from belt_ros.rig import RigSample, measured
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.rig.sensors import SensorErrors, Sensors, counted, joint_values, rounded
from belt_ros.rig.truth import Truth
from belt_ros.settings import DriveSettings

Run = Callable[..., list[RigSample]]
LOADED = {"duration": 1.0, "speed": 100.0, "load": 30.0}


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


def measurements(
    settings: DriveSettings, *, loads: bool = False, **values: float
) -> list[tuple[Measurement, Truth]]:
    named = {f"sensors.{name}": value for name, value in values.items()}
    scenario = scenario_from_mapping({**LOADED, **named}, settings)
    return list(measured(settings, scenario, loads=loads))


def test_a_quantum_makes_the_steps_coarser_and_never_finer() -> None:
    assert SensorErrors(speed_resolution=0.01, speed_quantum=0.5).speed_step == 0.5
    assert SensorErrors(speed_resolution=0.01, speed_quantum=0.001).speed_step == 0.01
    assert SensorErrors(counts_per_turn=1000.0).counts == 1000.0
    assert SensorErrors(counts_per_turn=1000.0, position_quantum=0.1).counts == 20.0 * np.pi
    assert SensorErrors(counts_per_turn=1000.0, position_quantum=1e-6).counts == 1000.0


def test_speed_and_position_come_in_the_steps_of_the_drive_description(
    settings: DriveSettings,
) -> None:
    noise = dataclasses.replace(settings.noise, speed_quantum=0.25, position_quantum=0.01)
    coarse = dataclasses.replace(settings, noise=noise)
    found = np.array([m.values() for m, _ in measurements(coarse)])
    speeds, positions = found[:, :2] / 0.25, found[:, 4:6] / 0.01
    np.testing.assert_allclose(speeds, np.round(speeds), atol=1e-6)
    np.testing.assert_allclose(positions, np.round(positions), atol=1e-6)


def test_positions_are_measured_and_only_noisy_when_told(settings: DriveSettings) -> None:
    exact, noisy = measurements(settings), measurements(settings, position_absolute=0.02)
    of = {
        name: np.array([[getattr(m, f"{name}s") for m, _ in run] for run in (exact, noisy)])
        for name in ("speed", "torque", "position")
    }
    np.testing.assert_array_equal(of["speed"][0], of["speed"][1])
    np.testing.assert_array_equal(of["torque"][0], of["torque"][1])
    assert np.std(of["position"][1] - of["position"][0]) == pytest.approx(0.02, rel=0.15)
    assert exact[-1][0].driver_position == pytest.approx(100.0, rel=1e-3)


def test_load_sensors_are_read_when_asked_and_leave_all_else_alone(settings: DriveSettings) -> None:
    without, with_loads = measurements(settings), measurements(settings, loads=True)
    for (plain, truth), (full, same) in zip(without, with_loads, strict=True):
        assert truth == same
        np.testing.assert_array_equal(plain.values()[:6], full.values()[:6])
        assert np.all(np.isnan(plain.loads))
        assert np.all(np.isfinite(full.loads))


def test_exact_load_sensors_read_the_tensions_less_what_turns_the_belt(
    settings: DriveSettings,
) -> None:
    for measurement, truth in measurements(
        settings, loads=True, load_relative=0.0, load_absolute=0.0
    ):
        lift = settings.drive.belt.mass_per_length * (truth.driver_speed * 0.08125) ** 2
        hub = 2.0 * (truth.mean_tension - lift)
        assert measurement.driver_hub_load == pytest.approx(hub, rel=1e-4)
        assert measurement.driven_hub_load == pytest.approx(hub, rel=1e-4)
        assert measurement.span_tension == pytest.approx(truth.tight_tension - lift, rel=1e-4)


def test_load_noise_is_as_stated(settings: DriveSettings) -> None:
    exact = measurements(settings, loads=True, load_relative=0.0, load_absolute=0.0)
    noisy = measurements(settings, loads=True, load_relative=0.02, load_absolute=5.0)
    loads = np.array([m.loads for m, _ in exact])
    error = np.array([m.loads for m, _ in noisy]) - loads
    stddev = np.hypot(0.02 * loads, 5.0)
    np.testing.assert_allclose(np.std(error / stddev, axis=0), 1.0, atol=0.25)


def test_bearing_drag_is_in_the_effort_and_taken_off_again(
    run: Run, settings: DriveSettings
) -> None:
    driver = dataclasses.replace(settings.driver, drag_torque=0.7, drag_damping=0.01)
    dragged = dataclasses.replace(settings, driver=driver)
    for sample in run(dragged, duration=0.5, speed=-100.0, load=30.0):
        truth, joints = sample.truth, sample.joints
        assert joints.efforts[0] == pytest.approx(
            truth.driver_torque - 0.7 + 0.01 * truth.driver_speed
        )
        assert driver.pulley_torque(joints.efforts[0], joints.velocities[0]) == pytest.approx(
            truth.driver_torque
        )
