"""What a load does within a step: the law of motion takes that of the step's end for all of it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from runs import ROOT, Run, Runner

from belt_ros.estimation import Phase
from belt_ros.estimation.load import Activity
from belt_ros.estimation.process import Process, drift_processes, drift_wander, prior_state
from belt_ros.estimation.state import Index
from belt_ros.mechanics import torque_capacity
from belt_ros.mechanics.constants import DriveConstants, drive_constants
from belt_ros.settings import DriveSettings, load_settings

STEADY = (0.01, 0.0, 0.0)  # of the creep
MOVED = [Index.DRIVER_SPEED, Index.DRIVEN_SPEED, Index.DRIVER_TORQUE, Index.DRIVEN_TORQUE]
LEVELS = (0.6, 0.2, 0.7, 0.1, 0.5, 0.3)  # of the capacity
HOLD = 0.7  # [s]
LOST = {"demo_drive": 0.01, "conveyor_drive": 0.15}  # of the time, at most; were 0.15 and 0.56


def process(
    settings: DriveSettings, taken: tuple[float, float], shown: tuple[float, float], dt: float
) -> tuple[DriveConstants, float, Process]:
    """Return the drive, the greatest wander of its load [N/sqrt(s)], and what a step adds."""
    c = drive_constants(settings.drive)
    _, spread = prior_state(settings.prior, settings.drive)
    wander = drift_wander(settings.drift, spread, settings.prior.tension)
    activity = Activity(taken, shown)
    return c, wander.load, drift_processes(wander, c, activity, STEADY, dt, dt)[0]


def geared() -> DriveSettings:
    larger = {"driven.radius": 0.3, "driven.inertia": 0.2, "span_length": 1.0}
    return load_settings(ROOT / "config" / "demo_drive.yaml", larger)


def test_speeds_lack_what_a_walking_load_has_not_yet_given_them() -> None:
    """Drawn: walks of both torques, and what two pulleys on one rigid belt gain by them."""
    settings, dt, count, fine = geared(), 0.02, 100_000, 100
    paces = (1.0, 0.3)
    c, load, added = process(settings, paces, paces, dt)
    radii = np.array([c.driver_radius, c.driven_radius])
    mass = c.driver_inertia / radii[0] ** 2 + c.driven_inertia / radii[1] ** 2
    random = np.random.default_rng(0)
    end, lacking = np.zeros((count, 2)), np.zeros(count)
    for k in range(fine):
        moved = np.array(paces) * load * math.sqrt(dt / fine) * random.standard_normal((count, 2))
        end += moved
        lacking -= moved.sum(axis=1) * dt * k / fine / mass  # it was not there from the begin
    drawn = np.column_stack([lacking / radii[0], lacking / radii[1], end * radii])
    expected = added.covariance_before[np.ix_(MOVED, MOVED)]
    scale = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(
        np.cov(drawn.T) / np.outer(scale, scale), expected / np.outer(scale, scale), atol=0.03
    )


@given(
    taken=st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)),
    jumps=st.floats(1.0, 1e3),
    dt=st.floats(1e-4, 1.0),
)
@hypothesis_settings(deadline=None, max_examples=100)
def test_what_is_added_is_a_covariance(taken, jumps: float, dt: float) -> None:
    shown = taken[0] * jumps, 0.5 * taken[1]
    taken = shown[0], taken[1]
    _, _, added = process(geared(), taken, shown, dt)
    covariance = added.covariance_before
    np.testing.assert_array_equal(covariance, covariance.T)
    scale = np.sqrt(np.diag(covariance))
    scale[scale == 0.0] = 1.0
    assert np.min(np.linalg.eigvalsh(covariance / np.outer(scale, scale))) > -1e-12


def test_a_torque_that_its_sensor_shows_to_be_calm_lets_no_speed_be_another() -> None:
    _, _, added = process(geared(), (1.0, 1.0), (0.0, 0.0), 0.01)
    among = added.covariance_before[np.ix_(MOVED, MOVED)]
    assert np.all(among[:2] == 0.0)
    assert np.all(np.diag(among)[2:] > 0.0)


def test_when_a_load_has_jumped_is_left_open_as_in_the_liveliest_walk() -> None:
    def open_speed(shown: float) -> float:
        """Variance of the driver's speed where its torque at the end is known."""
        _, _, added = process(geared(), (shown, 0.0), (shown, 0.0), 0.01)
        among = added.covariance_before[np.ix_(MOVED, MOVED)]
        return float(among[0, 0] - among[0, 2] ** 2 / among[2, 2])

    assert open_speed(0.5) == pytest.approx(0.25 * open_speed(1.0))
    assert open_speed(30.0) == pytest.approx(open_speed(1.0), rel=1e-9)


def test_a_load_that_has_jumped_without_its_sensor_leaves_speeds_as_they_are() -> None:
    calm = Activity((0.3, 0.001), (0.002, 0.001))
    jumping = calm.jumping()
    np.testing.assert_array_equal(jumping.taken, 1.0)
    np.testing.assert_array_equal(jumping.shown, calm.shown)
    raised = calm.at_least(Activity((9.0, 0.5), (9.0, 0.2)))
    np.testing.assert_array_equal(raised.taken, [1.0, 0.5])
    np.testing.assert_array_equal(raised.shown, [1.0, 0.2])


@pytest.fixture(scope="module", params=list(LOST))
def stepped(run: Runner, request: pytest.FixtureRequest) -> list[Run]:
    """Runs at 20 Hz of a load that steps within a sample, again and again."""
    drive = load_settings(ROOT / "config" / f"{request.param}.yaml")
    capacity = float(torque_capacity(drive.drive, drive.prior.tension, 60.0))
    load, now = [[2.0, 0.0]], 2.0
    for level in LEVELS:
        load += [[now + 0.05, level * capacity], [now + 0.05 + HOLD, level * capacity]]
        now += 0.05 + HOLD
    return [
        run(
            drive=drive,
            duration=now,
            sample_rate=20.0,
            seed=seed,
            speed=[[0.0, 0.0], [1.5, 60.0]],
            load=load,
        )
        for seed in range(2)
    ]


def test_a_load_that_steps_between_slow_samples_is_seldom_taken_for_a_sensors_fault(
    stepped, request: pytest.FixtureRequest
) -> None:
    phases = [output.estimate.phase for run in stepped for output in run.outputs[40:]]
    most = LOST[request.node.callspec.params["stepped"]]
    assert np.mean([phase is Phase.LOST for phase in phases]) < most


def test_speeds_are_as_uncertain_as_said_while_the_load_steps(stepped) -> None:
    for name in ("driver_speed", "driven_speed"):
        off = []
        for run in stepped:
            for output, truth in zip(run.outputs[40:], run.truths[40:], strict=True):
                value, stddev = getattr(output.estimate, name)
                off.append((value - getattr(truth, name)) / stddev)
        assert 0.6 < math.sqrt(np.mean(np.square(off))) < 1.3
