"""Friction along an arc keeps the law of every zone, and more load makes more of it slide."""

import math

import numpy as np
import pytest
from arcs import REPEATABLE, Arc, Floats, arcs
from drawing import spread
from hypothesis import given
from hypothesis import strategies as st

from belt_ros.mechanics import Role, solve_arc
from belt_ros.mechanics.arc_state import arc_state


def friction_and_tension(
    arc: Arc, d: float, transition: float, restick: float, x: Floats
) -> tuple[Floats, Floats]:
    """Friction over lambda w_in and W along an arc, integrated by hand zone by zone."""
    sigma, a = arc.role, arc.growth

    def stretch(y: Floats) -> tuple[Floats, Floats]:
        """D sinh y and D (cosh y - 1), without overflow."""
        rising = np.exp(math.log(d) + y) if d > 0.0 else 0.0 * y
        return -0.5 * rising * np.expm1(-2.0 * y), 0.5 * rising * np.expm1(-y) ** 2

    friction, gain = stretch(x)
    w = 1.0 + sigma * gain
    sliding = x > transition
    if not np.any(sliding):
        return friction, w
    w1 = 1.0 + sigma * stretch(np.array(transition))[1]
    w = np.where(sliding, w1 * np.exp(sigma * a * (np.where(sliding, x, 0.0) - transition)), w)
    friction = np.where(sliding, a * w, friction)
    if not math.isnan(restick):
        w2 = float(w1 * np.exp(a * (restick - transition)))
        y = np.where(x > restick, x - restick, 0.0)
        stuck = (w2 + d - 1.0) * np.cosh(y) + a * w2 * np.sinh(y) - (d - 1.0)
        spring = (w2 + d - 1.0) * np.sinh(y) + a * w2 * np.cosh(y)
        w = np.where(x > restick, stuck, w)
        friction = np.where(x > restick, spring, friction)
    return friction, w


def outlet_ratio(arc: Arc, d: float) -> float:
    """W at the outlet for an inlet gradient, its zones found by bisection along the arc."""
    sigma, a, end = arc.role, arc.growth, arc.lengths

    def excess(x: float) -> float:
        return d * math.sinh(x) - a * (1.0 + sigma * d * (math.cosh(x) - 1.0))

    peak = math.atanh(1.0 / a) if sigma > 0 and a > 1.0 else end
    low, high = 0.0, min(peak, end)
    if excess(high) <= 0.0:
        transition = end
    else:
        for _ in range(200):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if excess(middle) <= 0.0 else (low, middle)
        transition = 0.5 * (low + high)
    restick = math.nan
    if sigma > 0 and a > 1.0 and transition < end:
        w1 = 1.0 + d * (math.cosh(transition) - 1.0)
        x2 = transition + math.log(max((d - 1.0) / (a * a - 1.0) / w1, 1.0)) / a
        restick = x2 if x2 < end else math.nan
    return float(friction_and_tension(arc, d, transition, restick, np.array(end))[1])


@given(arcs())
@REPEATABLE
def test_friction_stays_within_the_coulomb_limit_and_ends_at_the_outlet_tension(arc: Arc) -> None:
    solution = arc.solve()
    d = arc.gradient(solution)
    per_angle = arc.b
    transition = float(solution.transition_angle) * per_angle
    restick = float(solution.restick_angle) * per_angle
    marks = [transition, arc.lengths] + ([] if math.isnan(restick) else [restick])
    x = np.unique(np.append(np.linspace(0.0, arc.lengths, 800), marks).clip(0.0, arc.lengths))
    friction, w = friction_and_tension(arc, d, transition, restick, x)
    assert np.all(friction >= 0.0)
    assert np.max(friction / (arc.growth * w)) <= 1.0 + 1e-9
    assert arc.role * math.log(w[-1]) == pytest.approx(arc.traction, rel=0, abs=4 * arc.rounding)
    if not solution.elastic_only:
        at_limit, tension = friction_and_tension(
            arc, d, math.inf, math.nan, np.array(min(transition, arc.lengths))
        )
        assert at_limit == pytest.approx(arc.growth * tension, rel=1e-9)


@given(arcs())
@REPEATABLE
def test_gradient_to_outlet_tension_and_back_returns_the_gradient(arc: Arc) -> None:
    d = arc.gradient(arc.solve())
    ratio = outlet_ratio(arc, d)
    again = arc.gradient(arc.solve(outlet=arc.outlet_at(ratio - 1.0)))
    change = abs(math.log(outlet_ratio(arc, d * (1.0 + 1e-6)) / ratio))
    sensitivity = 1e-6 / max(change, 1e-18)
    assert again == pytest.approx(d, rel=4 * arc.rounding * max(sensitivity, 1.0))


@given(arcs(load=st.floats(0.01, 0.9999)))
@REPEATABLE
def test_gradient_rises_strictly_with_the_tension_change(arc: Arc) -> None:
    change = np.linspace(0.0, 1.0, 60) * (arc.outlet_tension - arc.inlet_tension)
    gradients = np.abs(arc.solve(outlet=arc.inlet_tension + change).inlet_strain_gradient)
    assert gradients[0] == 0.0
    assert np.all(np.diff(gradients) > 0.0)


@given(arcs(load=st.floats(0.01, 0.99)))
@REPEATABLE
def test_slope_is_the_derivative_of_the_gradient(arc: Arc) -> None:
    step = 1e-6 * arc.traction
    low, here, high = (
        arc_state(arc.traction + shift, arc.growth, arc.lengths, arc.role)
        for shift in (-step, 0.0, step)
    )
    # At a regime's boundary the slope may jump, between the slopes on both sides.
    least, most = sorted((low.slope, high.slope))
    quotient = (high.gradient - low.gradient) / (2.0 * step)
    assert least * (1.0 - 1e-3) <= here.slope <= most * (1.0 + 1e-3)
    assert least * (1.0 - 1e-3) <= quotient <= most * (1.0 + 1e-3)


@given(arcs(load=st.floats(0.01, 0.9999)))
@REPEATABLE
def test_sliding_spreads_from_the_outlet_as_the_tension_change_rises(arc: Arc) -> None:
    change = np.linspace(0.0, 1.0, 60) * (arc.outlet_tension - arc.inlet_tension)
    solution = arc.solve(outlet=arc.inlet_tension + change)
    angles = solution.transition_angle
    assert np.all(np.diff(angles) <= 1e-12)
    assert np.all((angles > 0.0) & (angles <= arc.wrap))
    assert np.all(angles[solution.elastic_only] >= arc.wrap * (1.0 - 1e-15))
    sliding_ends = solution.restick_angle[~np.isnan(solution.restick_angle)]
    assert np.all(np.diff(sliding_ends) >= -1e-12)
    assert np.all(sliding_ends <= arc.wrap)


@given(arcs(growth=spread(0.5, 30.0), load=st.floats(1e-3, 0.1)))
@REPEATABLE
def test_transition_angle_is_the_wrap_angle_exactly_where_nothing_slides(arc: Arc) -> None:
    solution = arc.solve()
    if solution.elastic_only:
        assert float(solution.transition_angle) == arc.wrap


@given(arcs(role=st.just(-1)))
@REPEATABLE
def test_driver_arc_never_resticks(arc: Arc) -> None:
    assert np.isnan(arc.solve().restick_angle)


@given(arcs(growth=spread(2e-2, 1.0)))
@REPEATABLE
def test_no_arc_resticks_where_the_limit_grows_slower_than_the_spring(arc: Arc) -> None:
    assert np.isnan(arc.solve().restick_angle)


def test_inertia_acts_only_through_effective_tension_and_net_stiffness() -> None:
    heavy = Arc(role=1, growth=0.4, friction=0.7, wrap=2.8, load=0.6, lift=0.7, strain=0.08)
    w_in = heavy.inlet_tension - heavy.lifted
    w_out = w_in * math.exp(heavy.traction)
    light = solve_arc(
        Role.DRIVEN,
        heavy.radius,
        heavy.wrap,
        heavy.friction,
        heavy.net * (heavy.b / heavy.radius) ** 2,
        heavy.net,
        0.0,
        0.0,
        w_in,
        w_out,
    )
    solution = heavy.solve()
    np.testing.assert_allclose(
        float(solution.inlet_strain_gradient), light.inlet_strain_gradient, rtol=1e-12
    )
    np.testing.assert_allclose(solution.transition_angle, light.transition_angle, rtol=1e-12)
