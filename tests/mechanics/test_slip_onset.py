"""kf_min: the boundary between creep alone and creep with sliding."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.mechanics import Role, slip_onset_stiffness, solve_arc

REPEATABLE = settings(derandomize=True, deadline=None, max_examples=150)
EA = 80068.0


def test_table_2_driven_pulley_begins_to_slide_at_the_papers_least_stiffness() -> None:
    onset = slip_onset_stiffness(Role.DRIVEN, 0.08125, math.pi, 1.2, EA, 0.0, 0.0, 156.2, 712.2)
    assert float(onset) == pytest.approx(2.7678e7, rel=2e-5)
    with_inertia = slip_onset_stiffness(
        Role.DRIVEN, 0.08125, math.pi, 1.2, EA, 0.1036, 9.75, 156.2, 712.2
    )
    assert float(with_inertia) < float(onset)


@given(st.sampled_from(Role), st.floats(0.3, 6.0), st.floats(0.1, 1.5), st.floats(0.02, 0.98))
@REPEATABLE
def test_an_arc_creeps_below_the_onset_and_slides_above_it(
    role: Role, wrap: float, friction: float, load: float
) -> None:
    outlet = 200.0 * math.exp(role * load * friction * wrap)
    onset = float(slip_onset_stiffness(role, 0.1, wrap, friction, EA, 0.0, 0.0, 200.0, outlet))
    if onset == 0.0:
        softness = np.geomspace(1e-6, 1e16, 300)
        state = (EA, 0.0, 0.0, 200.0, outlet)
        assert not np.any(solve_arc(role, 0.1, wrap, friction, softness, *state).elastic_only)
        return
    below, above = solve_arc(
        role, 0.1, wrap, friction, onset * np.array([0.999, 1.001]), EA, 0.0, 0.0, 200.0, outlet
    ).elastic_only
    assert below
    assert not above


def test_a_contact_softer_than_the_onset_still_carries_the_torque() -> None:
    # The paper's conclusion says so of small torques, its Eqs. 57-60 are read otherwise.
    arc = solve_arc(Role.DRIVEN, 0.08125, math.pi, 1.2, 1e7, EA, 0.0, 0.0, 156.2, 712.2)
    assert arc.elastic_only
    assert float(arc.inlet_strain_gradient) > 0.0


def test_near_capacity_no_contact_is_soft_enough_not_to_slide() -> None:
    limit = 200.0 * math.exp(1.2 * math.pi)
    for role in Role:
        ends = (200.0, 0.9 * limit) if role is Role.DRIVEN else (0.9 * limit, 200.0)
        assert slip_onset_stiffness(role, 0.08125, math.pi, 1.2, EA, 0.0, 0.0, *ends) == 0.0
        softest = solve_arc(role, 0.08125, math.pi, 1.2, 1e-3, EA, 0.0, 0.0, *ends)
        assert not softest.elastic_only


def test_without_a_change_of_tension_nothing_slides() -> None:
    assert slip_onset_stiffness(1, 0.1, 3.0, 0.5, EA, 0.0, 0.0, 200.0, 200.0) == math.inf


def test_a_soft_contact_can_slide_where_a_stiffer_one_does_not() -> None:
    # a > 1: the limit is met inside the arc. There are two boundaries; kf_min is the upper one.
    outlet = 150.0 * math.exp(2.75)
    onset = float(
        slip_onset_stiffness(Role.DRIVEN, 0.08125, math.pi, 1.2, EA, 0.0, 0.0, 150.0, outlet)
    )
    kf = np.array([1e5, 1e6, 0.999 * onset, 1.001 * onset])
    arc = solve_arc(Role.DRIVEN, 0.08125, math.pi, 1.2, kf, EA, 0.0, 0.0, 150.0, outlet)
    np.testing.assert_array_equal(arc.elastic_only, [False, True, True, False])


@pytest.mark.parametrize("role", list(Role))
@pytest.mark.parametrize("traction", [1e-9, 1e-6])
def test_small_loads_begin_to_slide_at_stiffness_that_grows_with_their_inverse_square(
    role: Role, traction: float
) -> None:
    outlet = 200.0 * (1.0 + role * traction)
    onset = slip_onset_stiffness(role, 0.1, 3.0, 0.5, EA, 0.0, 0.0, 200.0, outlet)
    stretch = 0.5 / (0.1 * traction)  # 1/lambda where mu/(R lambda) = traction
    assert float(onset) == pytest.approx(EA * stretch**2, rel=1e-5)
