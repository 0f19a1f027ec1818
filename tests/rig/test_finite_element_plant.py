"""The finite element plant: same scenario, sensors and truth as the rig's."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from belt_ros.mechanics import Tensioning, solve_equilibrium, torque_capacity
from belt_ros.mechanics.finite_element_mesh import Discretisation
from belt_ros.rig import ScenarioError, simulate_finite_elements
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.settings import load_settings

CONFIG = Path(__file__).parents[2] / "config"
SETTINGS = load_settings(CONFIG / "paper_drive.yaml")
COARSE = Discretisation(elements_per_half_pulley=30)


def scenario(**changed: object):
    values = {
        "duration": 0.5,
        "sample_rate": 1000.0,
        "speed": [[0.0, 60.0], [0.1, 120.0]],
        "load": [[0.0, 5.0], [0.1, 30.0]],
        "condition.tension": 430.0,
        "condition.friction_stiffness": 5e7,
    }
    return scenario_from_mapping(values | changed, SETTINGS)


@pytest.fixture(scope="module")
def samples():
    return list(simulate_finite_elements(SETTINGS, scenario(duration=1.5), COARSE))


def test_there_is_a_sample_at_every_stamp(samples) -> None:
    assert [sample.stamp_ns for sample in samples] == [n * 1_000_000 for n in range(1501)]


def smooth_change(duration: float, before: float, after: float) -> list[list[float]]:
    """Points [time, value] of a change that leaves the pulleys not swinging on the spans."""
    share = np.linspace(0.0, 1.0, 41)
    done = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    return np.stack([duration * share, before + (after - before) * done], axis=-1).tolist()


def test_truth_settles_in_the_equilibrium_between_fixed_centres() -> None:
    script = scenario(
        duration=1.5, speed=smooth_change(0.7, 60.0, 120.0), load=smooth_change(0.7, 5.0, 30.0)
    )
    drive = dataclasses.replace(SETTINGS.drive, tensioning=Tensioning.FIXED_CENTRES)
    drive = dataclasses.replace(
        drive,
        driven=dataclasses.replace(drive.driven, friction_stiffness=5e7),
        driver=dataclasses.replace(drive.driver, friction_stiffness=5e7),
    )
    expected = solve_equilibrium(drive, 30.0, 430.0, 120.0)
    last = list(simulate_finite_elements(SETTINGS, script, COARSE))[-300:]
    for name, tolerance in (("tight_tension", 1e-3), ("slack_tension", 2e-3), ("slip", 0.015)):
        mean = np.mean([getattr(sample.truth, name) for sample in last])
        assert mean == pytest.approx(float(getattr(expected, name)), rel=tolerance)
    torque = np.mean([sample.truth.transmitted_torque for sample in last])
    assert torque == pytest.approx(30.0, rel=2e-3)


def test_soft_contact_near_its_capacity_creeps_as_in_equilibrium() -> None:
    """Where friction of sliding arcs feeds axial waves if the belt is not damped."""
    kf, tension, speed = 1e7, 435.0, 120.0
    settings = dataclasses.replace(
        SETTINGS, drive=dataclasses.replace(SETTINGS.drive, tensioning=Tensioning.FIXED_CENTRES)
    )
    drive = dataclasses.replace(
        settings.drive,
        driven=dataclasses.replace(settings.drive.driven, friction_stiffness=kf),
        driver=dataclasses.replace(settings.drive.driver, friction_stiffness=kf),
    )
    load = 0.9 * float(torque_capacity(drive, tension, speed))
    values = {
        "duration": 0.9,
        "speed": speed,
        "load": [[0.0, 0.0], [0.3, load]],
        "condition.tension": tension,
        "condition.friction_stiffness": kf,
    }
    script = scenario_from_mapping(values, settings)
    late = [sample.truth for sample in simulate_finite_elements(settings, script)][-20:]
    expected = solve_equilibrium(drive, load, tension, speed)
    assert np.std([truth.slip for truth in late]) < 1e-5
    assert late[-1].slip == pytest.approx(float(expected.slip), rel=5e-3)
    assert late[-1].slack_tension == pytest.approx(float(expected.slack_tension), rel=0.01)


def test_sensors_say_the_truth_but_for_their_noise(samples) -> None:
    speeds = np.array([sample.joints.velocities for sample in samples])
    truth = np.array([(s.truth.driver_speed, s.truth.driven_speed) for s in samples])
    assert np.abs(speeds - truth).max() < 0.1
    turned = np.array([sample.joints.positions for sample in samples])
    assert turned[-1, 0] == pytest.approx(np.trapezoid(truth[:, 0], dx=1e-3), abs=1e-3)
    slipped = samples[-1].truth.accumulated_slip
    radius = SETTINGS.drive.driver.radius
    assert slipped == pytest.approx(radius * (turned[-1, 0] - turned[-1, 1]), abs=1e-4)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"events": [{"at": 0.2, "tension": 300.0}]}, "tension changes between 300 and 430"),
        ({"events": [{"at": 0.2, "friction_coefficient": 0.5}]}, "friction_coefficient changes"),
        ({"condition.creep_error": 0.02}, r"condition\.creep_error is 0\.02"),
        ({"condition.undeveloped_creep": 1.0}, r"condition\.undeveloped_creep is 1"),
        ({"condition.ratio_bias": 1e-4}, r"condition\.ratio_bias is 0\.0001"),
    ],
)
def test_what_cannot_change_in_the_simulator_is_refused(
    changed: dict[str, object], message: str
) -> None:
    with pytest.raises(ScenarioError, match=message):
        simulate_finite_elements(SETTINGS, scenario(**changed), COARSE)


def test_progress_ends_with_the_whole_duration() -> None:
    seen: list[tuple[float, float]] = []
    simulate_finite_elements(
        SETTINGS,
        scenario(duration=0.02, speed=60.0, load=5.0),
        COARSE,
        progress=lambda done, all_: seen.append((done, all_)),
    )
    assert seen[-1] == pytest.approx((0.02, 0.02))
    assert math.isfinite(seen[0][0])
