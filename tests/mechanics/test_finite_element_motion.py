"""The finite element drive in motion: standing, reversed, overloaded, and how it is sampled."""

import math

import numpy as np
import pytest
from finite_elements import (
    COARSE,
    INSTALLED,
    RADIUS,
    SPEED,
    TORQUE,
    equilibrium_speed,
    make_drive,
    ramp,
    tail,
    tensions,
)

from belt_ros.mechanics.finite_element import ArcDistribution, FiniteElementRun, History, simulate
from belt_ros.mechanics.finite_element_mesh import build_mesh


@pytest.fixture(scope="module")
def coarse_run() -> FiniteElementRun:
    return simulate(make_drive(), ramp(0.6, TORQUE), INSTALLED, COARSE)


def test_friction_torques_balance_load_and_each_other(coarse_run: FiniteElementRun) -> None:
    assert tail(coarse_run.driven_torque) == pytest.approx(TORQUE, rel=1e-3)
    assert tail(coarse_run.driver_torque) == pytest.approx(TORQUE, rel=1e-3)


def test_friction_of_the_distribution_is_the_torque(coarse_run: FiniteElementRun) -> None:
    arc = coarse_run.driven_arc
    total = np.mean(arc.friction) * math.pi * RADIUS
    assert total * RADIUS == pytest.approx(TORQUE, rel=0.01)


def test_standstill_holds_tension_and_is_quiet() -> None:
    still = History([0.0, 0.1], [0.0, 0.0], [0.0, 0.0])
    run = simulate(make_drive(), still, INSTALLED, COARSE)
    settled = run.time > 0.02
    for tension in (run.to_driver_tension, run.to_driven_tension):
        assert tension[settled] == pytest.approx(INSTALLED, rel=1e-3)
    assert np.max(np.abs(run.driven_speed)) < 1e-3
    assert np.max(np.abs(run.driver_torque[settled])) < 0.01
    assert run.driven_arc.normal[2:-2] == pytest.approx(INSTALLED / RADIUS, rel=1e-3)


def test_reversed_torque_swaps_the_roles(coarse_run: FiniteElementRun) -> None:
    drive = make_drive()
    run = simulate(drive, ramp(0.6, -TORQUE), INSTALLED, COARSE)
    tight, slack = tensions(run)
    assert tail(run.to_driven_tension) == tight
    assert (tight, slack) == pytest.approx(tensions(coarse_run), rel=0.01)
    expected = SPEED**2 / equilibrium_speed(drive, tight, slack)
    assert tail(run.driven_speed) == pytest.approx(expected, abs=0.02)
    assert tail(run.driver_torque) == pytest.approx(-TORQUE, rel=1e-3)
    assert np.mean(run.driven_arc.friction) < 0.0 < np.mean(run.driver_arc.friction)


def test_reversed_rotation_mirrors_the_drive(coarse_run: FiniteElementRun) -> None:
    run = simulate(make_drive(), ramp(0.6, -TORQUE, -SPEED), INSTALLED, COARSE)
    assert run.driven_speed == pytest.approx(-coarse_run.driven_speed, abs=1e-6)
    assert run.to_driven_tension == pytest.approx(coarse_run.to_driver_tension, rel=1e-6)
    for mirrored, arc in (
        (run.driven_arc, coarse_run.driven_arc),
        (run.driver_arc, coarse_run.driver_arc),
    ):
        peak = np.max(np.abs(arc.friction))
        assert mirrored.friction == pytest.approx(arc.friction, abs=1e-6 * peak)


def test_reversal_on_the_run_leaves_no_memory() -> None:
    there_and_back = History(
        [0.0, 0.1, 0.35, 0.65], [60.0, 60.0, -60.0, -60.0], [20.0, 20.0, -20.0, -20.0]
    )
    only_back = History([0.0, 0.3], [-60.0, -60.0], [-20.0, -20.0])
    turned = simulate(make_drive(), there_and_back, INSTALLED, COARSE)
    straight = simulate(make_drive(), only_back, INSTALLED, COARSE)
    assert tail(turned.driven_speed) == pytest.approx(tail(straight.driven_speed), abs=0.05)
    assert tensions(turned) == pytest.approx(tensions(straight), rel=0.01)


def test_overload_slips_and_saturates_at_the_capacity() -> None:
    """On fixed centres T_H + T_L has risen by then, and with it the capacity, to 78 N m."""
    drive = make_drive()
    run = simulate(drive, ramp(0.45, 90.0, rise=0.2), INSTALLED, COARSE, average_over=0.02)
    sliding = (run.driven_speed < 100.0) & (run.time > 0.2)
    assert np.any(sliding)
    assert run.driven_speed[-1] < 0.0
    lift = drive.belt.mass_per_length * (SPEED * RADIUS) ** 2
    tight, slack = np.mean(run.tight_tension[sliding]), np.mean(run.slack_tension[sliding])
    mean = 0.5 * (tight + slack) - lift
    capacity = 2.0 * mean * math.tanh(0.5 * drive.driven.traction_limit)
    assert tight - slack == pytest.approx(capacity, rel=0.02)


def test_start_at_speed_ends_where_a_ramp_does(coarse_run: FiniteElementRun) -> None:
    loaded = ramp(0.5, TORQUE)
    flying = History(loaded.time, np.full(np.size(loaded.time), SPEED), loaded.load_torque)
    run = simulate(make_drive(), flying, INSTALLED, COARSE)
    assert run.driven_speed[0] == pytest.approx(SPEED, rel=1e-3)
    assert tail(run.driven_speed) == pytest.approx(tail(coarse_run.driven_speed), abs=0.03)


def test_series_and_distributions_have_their_shapes() -> None:
    done = []
    run = simulate(
        make_drive(),
        History([1.0, 1.05], [SPEED, SPEED], [0.0, 10.0]),
        INSTALLED,
        COARSE,
        sampling_interval=0.005,
        progress=lambda now, total: done.append((now, total)),
    )
    assert run.time == pytest.approx(1.0 + 0.005 * (np.arange(10) + 0.5))
    assert run.driver_speed == pytest.approx(SPEED)
    assert run.tight_tension == pytest.approx(
        np.maximum(run.to_driver_tension, run.to_driven_tension)
    )
    assert len(done) == 10
    assert done[-1] == pytest.approx((0.05, 0.05))
    assert run.elements == 180
    for arc in (run.driven_arc, run.driver_arc):
        assert isinstance(arc, ArcDistribution)
        assert all(np.all(np.isfinite(values)) for values in arc)
        assert 0.0 < arc.angle[0] < arc.angle[-1] < math.pi
        assert 25 <= arc.angle.size <= 30


def test_result_does_not_depend_on_how_it_is_sampled() -> None:
    history = History([0.0, 0.04], [SPEED, SPEED], [0.0, TORQUE])
    mesh = build_mesh(make_drive(), INSTALLED, COARSE)
    interval = 80.0 * mesh.time_step
    runs = [
        simulate(make_drive(), history, INSTALLED, COARSE, sampling_interval=k * interval)
        for k in (1, 4)
    ]
    seldom = runs[1].driven_speed
    often = runs[0].driven_speed[: 4 * seldom.size].reshape(-1, 4).mean(axis=1)
    assert seldom == pytest.approx(often, rel=1e-9)
