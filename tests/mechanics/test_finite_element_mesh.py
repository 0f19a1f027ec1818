"""Nodes and elements of the belt: closed at the start, friction on the pulleys only, no push."""

import math

import numpy as np
import pytest
from finite_elements import COARSE, INSTALLED, SPEED, TORQUE, make_drive
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.mechanics.finite_element_kernel import Mesh, Profile, State, advance
from belt_ros.mechanics.finite_element_mesh import (
    Discretisation,
    build_mesh,
    initial_state,
    open_belt,
)


@settings(derandomize=True, deadline=None)
@given(
    r1=st.floats(0.01, 0.5),
    r2=st.floats(0.01, 0.5),
    gap=st.floats(0.01, 2.0),
)
def test_open_belt_is_tangent_and_closes(r1: float, r2: float, gap: float) -> None:
    distance = r1 + r2 + gap
    wrap1, wrap2, span = open_belt(r1, r2, distance)
    assert wrap1 + wrap2 == pytest.approx(2.0 * math.pi)
    normal = math.pi - 0.5 * wrap1
    outlet = np.array([r1 * math.cos(normal), r1 * math.sin(normal)])
    inlet = np.array([distance + r2 * math.cos(normal), r2 * math.sin(normal)])
    assert math.hypot(*(inlet - outlet)) == pytest.approx(span)
    assert (inlet - outlet) @ outlet == pytest.approx(0.0, abs=1e-9)


def test_belt_starts_closed_and_evenly_tensioned() -> None:
    drive = make_drive(r1=0.1, r2=0.06)
    mesh = build_mesh(drive, INSTALLED, Discretisation(60))
    state = initial_state(drive, mesh, INSTALLED, SPEED)
    lengths = np.hypot(np.diff(state.x), np.diff(state.y))
    strain = INSTALLED / drive.belt.axial_stiffness
    assert lengths / mesh.rest_length - 1.0 == pytest.approx(strain, abs=0.1 * strain)
    assert np.hypot(state.vx, state.vy) == pytest.approx(SPEED * 0.06)
    assert state.driven_speed[0] * 0.1 == pytest.approx(SPEED * 0.06)


def advance_freely(mesh: Mesh, state: State, steps: int) -> None:
    """Constant speed and torque, nothing observed."""
    idle = Profile(*(np.empty(0) for _ in Profile._fields))
    advance(mesh, state, np.full(steps, SPEED), np.full(steps, TORQUE), 8, idle, idle)


def nodes_held(mesh: Mesh, state: State) -> np.ndarray:
    x, y = state.x[:-1], state.y[:-1]
    on_driven = np.hypot(x, y) < mesh.driven.radius
    return on_driven | (np.hypot(x - mesh.driver.centre, y) < mesh.driver.radius)


def test_friction_springs_are_relaxed_off_the_pulleys() -> None:
    mesh = build_mesh(make_drive(), INSTALLED, COARSE)
    state = initial_state(make_drive(), mesh, INSTALLED, SPEED)
    state.stretch[:] = 1e-6
    advance_freely(mesh, state, 8)
    held = nodes_held(mesh, state)
    assert 50 < np.count_nonzero(held) < 70
    assert np.all(state.stretch[held] != 0.0)
    for values in (state.stretch, state.normal, state.friction):
        assert np.all(values[~held] == 0.0)


def test_friction_keeps_within_coulombs_limit() -> None:
    drive = make_drive()
    mesh = build_mesh(drive, INSTALLED, COARSE)
    state = initial_state(drive, mesh, INSTALLED, SPEED)
    advance_freely(mesh, state, 16_000)
    limit = drive.driven.friction_coefficient * state.normal
    share = np.abs(state.friction[nodes_held(mesh, state)]) / limit[nodes_held(mesh, state)]
    assert np.max(share) == pytest.approx(1.0, rel=1e-12)
    assert np.min(share) < 0.01


def test_slack_element_does_not_push() -> None:
    mesh = build_mesh(make_drive(), INSTALLED, COARSE)
    state = initial_state(make_drive(), mesh, INSTALLED, 0.0)
    on_span = int(np.argmin(np.abs(state.x - 0.5 * mesh.driver.centre)))
    state.x[on_span] += 0.5 * (state.x[on_span + 1] - state.x[on_span])
    advance_freely(mesh, state, 8)
    assert np.min(state.tension) == 0.0
