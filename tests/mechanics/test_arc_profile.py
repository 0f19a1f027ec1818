"""Profiles along scaled arcs and their integrals, against integration of the equations."""

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from belt_ros.mechanics.arc_profile import (
    ScaledArc,
    excess,
    point_state,
    relaxed_length,
    scaled_arc,
)

REPEATABLE = settings(derandomize=True, deadline=None, max_examples=150)
NET = 1e5


def made(growth: float, friction: float, wrap: float, load: float, role: int) -> ScaledArc:
    """An arc of radius 0.1 m by its group a, mu, wrap angle and share of the traction limit."""
    unit = 0.1 * growth / friction
    return scaled_arc(load * friction * wrap, 0.1, wrap, friction, NET / unit**2, NET, role)


def arcs(
    least_growth: float = 0.03, role: st.SearchStrategy[int] | None = None
) -> st.SearchStrategy[ScaledArc]:
    return st.builds(
        made,
        growth=st.floats(math.log(least_growth), math.log(10.0)).map(math.exp),
        friction=st.floats(0.1, 1.5),
        wrap=st.floats(0.5, 5.5),
        load=st.floats(0.01, 0.999),
        role=role or st.sampled_from([1, -1]),
    )


def integral(arc: ScaledArc, function: Callable[[float], float]) -> float:
    """Quadrature zone by zone, split where an exponential layer may sit."""
    ends = [0.0, arc.begin, arc.end, arc.wrap]
    cuts = {*ends, *(x - back for x in ends for back in (1.0, 3.0, 10.0, 30.0))}
    points = sorted(x for x in cuts if 0.0 <= x <= arc.wrap)
    parts = itertools.pairwise(points)
    return math.fsum(
        quad(function, *ends, epsabs=1e-13 * arc.wrap, epsrel=1e-11)[0] for ends in parts
    )


GROUPS = {
    "growth": st.floats(-3.0, 2.3).map(math.exp),
    "friction": st.floats(0.1, 1.5),
    "wrap": st.floats(0.5, 5.5),
    "load": st.floats(0.05, 0.99),
    "role": st.sampled_from([1, -1]),
}


@given(**GROUPS)
@REPEATABLE
def test_tension_ends_at_the_traction_that_was_asked_for(
    growth: float, friction: float, wrap: float, load: float, role: int
) -> None:
    arc = made(growth, friction, wrap, load, role)
    assert point_state(arc, 0.0).tension == 1.0
    outlet = point_state(arc, arc.wrap).tension
    assert outlet == pytest.approx(math.exp(role * load * friction * wrap), rel=1e-12)


@given(arcs(least_growth=0.2))
@REPEATABLE
def test_profile_solves_the_belts_equation_with_a_spring_and_slider(arc: ScaledArc) -> None:
    # W' = +-q; the spring follows the belt's displacement until it meets the Coulomb limit.
    d, role, a = arc.state.gradient, arc.role, arc.growth

    def spring(_: float, state: list[float]) -> list[float]:
        rise, stretch = state  # of tension above 1: as a difference it would be lost in rounding
        return [role * stretch, d + role * rise]

    elastic = solve_ivp(
        spring, (0.0, arc.begin), [0.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-24
    )
    here = point_state(arc, arc.begin)
    assert here.tension == pytest.approx(1.0 + elastic.y[0, -1], rel=1e-8)
    assert here.stretch == pytest.approx(elastic.y[1, -1], rel=1e-7, abs=1e-12)
    slid = point_state(arc, arc.end)
    assert slid.tension == pytest.approx(
        here.tension * math.exp(role * a * (arc.end - arc.begin)), rel=1e-12
    )
    if arc.end < arc.wrap:
        start = [slid.tension - 1.0, a * slid.tension]
        stuck = solve_ivp(
            spring, (arc.end, arc.wrap), start, method="DOP853", rtol=1e-13, atol=1e-24
        )
        outlet = point_state(arc, arc.wrap)
        assert outlet.tension == pytest.approx(1.0 + stuck.y[0, -1], rel=1e-8)
        assert outlet.stretch == pytest.approx(stuck.y[1, -1], rel=1e-8)


@given(arcs(), st.floats(0.01, 0.99))
@REPEATABLE
def test_friction_never_exceeds_the_coulomb_limit_and_strain_never_changes_sign(
    arc: ScaledArc, where: float
) -> None:
    point = point_state(arc, where * arc.wrap)
    assert 0.0 <= point.stretch <= arc.growth * point.tension * (1.0 + 1e-9)
    assert point.gradient >= 0.0
    assert point.displacement >= point.stretch * (1.0 - 1e-9)


@given(arcs())
@REPEATABLE
def test_excess_is_the_integral_of_the_tensions_rise(arc: ScaledArc) -> None:
    expected = integral(arc, lambda x: point_state(arc, x).tension - 1.0)
    rounding = 1e-14 * arc.wrap
    assert excess(arc)[0] == pytest.approx(expected, rel=1e-10, abs=rounding)


@given(**GROUPS)
@REPEATABLE
def test_slope_of_the_excess_is_its_derivative_in_the_traction(
    growth: float, friction: float, wrap: float, load: float, role: int
) -> None:
    step = 1e-4 * min(load, 1.0 - load)
    low, arc, high = (
        made(growth, friction, wrap, load + shift, role) for shift in (-step, 0.0, step)
    )
    kinds = {(part.begin < part.wrap, part.end < part.wrap) for part in (low, arc, high)}
    assume(len(kinds) == 1)  # a corner of the slope lies between
    derivative = (excess(high)[0] - excess(low)[0]) / (2.0 * step * friction * wrap)
    assert excess(arc)[1] == pytest.approx(derivative, rel=1e-5)


@given(arcs(), st.floats(1e-5, 0.2), st.floats(1.0, 1.5))
@REPEATABLE
def test_relaxed_length_is_the_integral_of_the_unstretched_belt(
    arc: ScaledArc, grip: float, lifted: float
) -> None:
    grip /= max(1.0, point_state(arc, arc.wrap).tension)
    strain = lifted * grip

    def relaxed(x: float) -> float:
        return 1.0 / (1.0 + strain + grip * (point_state(arc, x).tension - 1.0))

    assert relaxed_length(arc, strain, grip) == pytest.approx(integral(arc, relaxed), rel=1e-13)


@pytest.mark.parametrize("role", [1, -1])
def test_a_wholly_sliding_arc_follows_the_capstan_law(role: int) -> None:
    arc = scaled_arc(3.0, 0.1, 2.0, 1.0, 1e7, NET, role)
    half = point_state(arc, 0.5 * arc.wrap)
    assert half.tension == pytest.approx(math.exp(role * 1.0), rel=1e-12)
    assert half.stretch == pytest.approx(arc.growth * half.tension, rel=1e-12)
    expected = role * math.expm1(role * 2.0) / arc.growth - arc.wrap
    assert excess(arc)[0] == pytest.approx(expected, rel=1e-12)
    assert math.isfinite(relaxed_length(arc, 0.02, 0.01))


@pytest.mark.parametrize("stiffness", [1e12, 1e16, 1e20])
def test_stiff_friction_overflows_nothing(stiffness: float) -> None:
    for role in (1, -1):
        arc = scaled_arc(1.0, 0.1, 3.0, 0.8, stiffness, NET, role)
        values = [value for x in np.linspace(0.0, arc.wrap, 7) for value in point_state(arc, x)]
        assert all(math.isfinite(value) for value in (*values, *excess(arc)))
        length = relaxed_length(arc, 0.01, 0.009) * arc.unit
        assert 0.29 < length < 0.3
