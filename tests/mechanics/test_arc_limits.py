"""An arc at its limits: where sliding begins, where friction is rigid, unloaded and at capacity."""

import numpy as np
import pytest
from arcs import REPEATABLE, Arc, arcs
from drawing import spread
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.mechanics import Role
from belt_ros.mechanics.arc_state import arc_state


def boundary_load(arc: Arc) -> float:
    """Share of mu phi at which sliding first appears, found on the solution itself."""
    low, high = 0.0, 1.0 - 1e-12
    for _ in range(60):
        middle = 0.5 * (low + high)
        elastic = bool(with_load(arc, middle).solve().elastic_only)
        low, high = (middle, high) if elastic else (low, middle)
    return 0.5 * (low + high)


def with_load(arc: Arc, load: float) -> Arc:
    return Arc(**{**arc.__dict__, "load": load})


@given(arcs(growth=spread(5e-2, 10.0)))
@settings(REPEATABLE, max_examples=100)
def test_gradient_is_continuous_where_sliding_begins(arc: Arc) -> None:
    boundary = boundary_load(arc)
    below, above = (with_load(arc, boundary * (1.0 + step)) for step in (-1e-9, 1e-9))
    assert below.solve().elastic_only
    assert not above.solve().elastic_only
    jump = above.gradient(above.solve()) / below.gradient(below.solve()) - 1.0
    assert 0.0 <= jump < 1e-6


@given(arcs(role=st.just(1), growth=spread(1.05, 10.0)))
@settings(REPEATABLE, max_examples=100)
def test_solution_is_continuous_where_the_third_zone_leaves_the_arc(arc: Arc) -> None:
    low = boundary_load(arc) * (1.0 + 1e-9)
    if np.isnan(with_load(arc, low).solve().restick_angle):
        return  # sliding begins at the outlet: there is never a third zone
    high = 1.0 - 1e-4
    if not np.isnan(with_load(arc, high).solve().restick_angle):
        return
    for _ in range(60):
        middle = 0.5 * (low + high)
        stuck = not np.isnan(with_load(arc, middle).solve().restick_angle)
        low, high = (middle, high) if stuck else (low, middle)
    below, above = (with_load(arc, low * (1.0 + step)) for step in (-1e-9, 1e-9))
    before, after = below.solve(), above.solve()
    assert float(before.restick_angle) == pytest.approx(arc.wrap, rel=1e-5)
    assert above.gradient(after) == pytest.approx(below.gradient(before), rel=1e-4)
    assert above.gradient(after) >= below.gradient(before)
    assert float(after.transition_angle) == pytest.approx(float(before.transition_angle), rel=1e-4)


@given(arcs(growth=st.just(1.0), load=st.floats(1e-3, 0.99)))
@settings(REPEATABLE, max_examples=100)
def test_solution_is_continuous_where_limit_and_spring_grow_alike(arc: Arc) -> None:
    solutions = []
    for growth in (1.0 - 1e-9, 1.0 - 1e-15, 1.0, 1.0 + 1e-15, 1.0 + 1e-9):
        near = Arc(**{**arc.__dict__, "growth": growth})
        solutions.append((near.gradient(near.solve()), float(near.solve().transition_angle)))
    gradients, angles = np.array(solutions).T
    np.testing.assert_allclose(gradients, gradients[2], rtol=1e-6)
    np.testing.assert_allclose(angles, angles[2], rtol=1e-6)


@given(
    st.sampled_from([1, -1]),
    spread(1e-6, 1e6),
    st.floats(0.01, 2.0),
    st.floats(1e-3, 6.2),
    st.floats(1e-6, 1.0 - 1e-9),
)
@REPEATABLE
def test_any_stiffness_of_friction_gives_finite_numbers(
    role: int, b: float, friction: float, wrap: float, load: float
) -> None:
    arc = Arc(role, friction / b, friction, wrap, load)
    with np.errstate(all="raise", under="ignore"):
        solution = arc.solve()
    assert np.isfinite(solution.inlet_strain_gradient)
    assert role * solution.inlet_strain_gradient >= 0.0
    assert 0.0 < solution.transition_angle <= wrap
    assert np.isnan(solution.restick_angle) or solution.restick_angle <= wrap


def test_rigid_friction_gives_the_capstan_slip_arc_and_no_inlet_gradient() -> None:
    arc = Arc(role=1, growth=1e-6, friction=0.5, wrap=3.0, load=0.4)
    solution = arc.solve()
    assert float(solution.transition_angle) == pytest.approx(0.6 * 3.0, rel=1e-5)
    assert float(solution.inlet_strain_gradient) == 0.0


def test_gradient_grows_without_bound_towards_capacity() -> None:
    for role in Role:
        gradients = [
            abs(float(with_load(arc, 1.0 - gap).solve().inlet_strain_gradient))
            for arc in [Arc(role, 0.2, 0.8, 3.0, 0.5), Arc(role, 2.0, 0.8, 3.0, 0.5)]
            for gap in (1e-3, 1e-5, 1e-7)
        ]
        for stiff in (gradients[:3], gradients[3:]):
            assert stiff[1] / stiff[0] == pytest.approx(100.0, rel=0.05)
            assert stiff[2] / stiff[1] == pytest.approx(100.0, rel=0.05)


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9, 1e-11])
@pytest.mark.parametrize(("growth", "role"), [(0.5, 1), (1.0, 1), (3.0, 1), (0.5, -1), (3.0, -1)])
def test_slope_follows_the_asymptote_at_capacity(growth: float, role: int, gap: float) -> None:
    # D is inversely proportional to what is left of the traction, so D' = D / rest.
    limit = 2.4
    traction = limit - gap
    state = arc_state(traction, growth, limit / growth, role)
    assert state.slope == pytest.approx(state.gradient / (limit - traction), rel=0.05)


@pytest.mark.parametrize("growth", [0.2, 1.0, 3.0])
@pytest.mark.parametrize("role", list(Role))
def test_equal_tensions_leave_the_belt_unstretched(role: Role, growth: float) -> None:
    arc = Arc(role, growth, 0.8, 3.0, 0.0)
    solution = arc.solve()
    assert float(solution.inlet_strain_gradient) == 0.0
    assert bool(solution.elastic_only)
    assert float(solution.transition_angle) == arc.wrap
