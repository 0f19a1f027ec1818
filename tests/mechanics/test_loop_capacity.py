"""What holds a loop's tension, and the load at which the first of its pulleys slips."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from layouts import serpentines
from loops import NAMES, REPEATABLE, Case, cases, scale_of, serpentine, solved

from belt_ros.mechanics import Belt, DriveError, Pulley
from belt_ros.mechanics.layout import Layout
from belt_ros.mechanics.loop import BeltLoop, HeldSpan, HubLoad, LoopPulley, loop_pulleys
from belt_ros.mechanics.loop_equilibrium import loop_margin, solve_loop

# --- Tensioning -------------------------------------------------------------------------------


@given(cases(), st.data())
@REPEATABLE
def test_a_held_span_has_the_tension_asked_for(case: Case, data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(case.loop.names))
    loop = replace(case.loop, tensioning=HeldSpan(name))
    tension = float(np.max(solved(case).span_tension)) * 3.0
    assume(float(loop_margin(loop, case.torque, tension, case.speed)) > 0.01)
    state = solved(case._replace(loop=loop, held=tension))
    assert float(state.span_tension[loop.index(name)]) == pytest.approx(tension, rel=1e-14)


@given(serpentines(), st.data())
@settings(REPEATABLE, max_examples=50)
def test_a_hub_load_is_the_force_of_both_spans_along_its_direction(
    layout: Layout, data: st.DataObject
) -> None:
    names = NAMES[: len(layout.discs)]
    index = data.draw(st.integers(0, len(names) - 1))
    spans = layout.direction
    along = spans[index] - spans[index - 1]
    direction = math.atan2(along[1], along[0]) + data.draw(st.floats(-0.5, 0.5))
    loop = BeltLoop(
        Belt(1e5, 0.1),
        loop_pulleys(layout, names, 0.8, 1e8),
        names[0],
        tensioning=HubLoad(names[index], layout.hub_angle(index, direction)),
    )
    load = 200.0 * float(np.hypot(*along))
    torque = loop.torques({names[1]: 1.0})
    torque *= 0.5 * min(scale_of(loop_margin(loop, torque, load, 10.0)), 10.0)
    found = solve_loop(loop, torque, load, 10.0).effective_tension
    force = found[index] * spans[index] - found[index - 1] * spans[index - 1]
    assert force @ [math.cos(direction), math.sin(direction)] == pytest.approx(load, rel=1e-12)


def test_a_pivoted_motor_that_wedges_the_belt_tight_never_lets_it_slip() -> None:
    pulleys = (
        LoopPulley("fan", Pulley(0.1, 3.6, 0.6, 1e8), 0.3),
        LoopPulley("motor", Pulley(0.05, 2.6, 0.6, 1e8), 0.3),
    )
    loop = BeltLoop(Belt(1e5), pulleys, "motor", tensioning=HubLoad("motor", 1.4))
    state = solve_loop(loop, [[1.0, 0.0], [10.0, 0.0], [100.0, 0.0], [-1.0, 0.0]], 30.0, 100.0)
    np.testing.assert_array_equal(state.margin[:3], 1.0)
    np.testing.assert_array_equal(state.first_to_slip[:3], -1)
    assert np.all(np.diff(state.utilisation[:3, 1]) > 0.0)
    assert np.all(state.utilisation < 1.0)
    assert float(state.margin[3]) < 0.9
    assert int(state.first_to_slip[3]) == 1


# --- Capacity ---------------------------------------------------------------------------------


@given(cases())
@REPEATABLE
def test_margin_is_the_load_at_which_the_first_pulley_slips(case: Case) -> None:
    reserve = float(loop_margin(case.loop, case.torque, case.held, case.speed))
    assume(reserve < 0.999)
    state = solved(case)
    assert float(state.margin) == pytest.approx(reserve, rel=1e-12)
    scale = scale_of(reserve)
    first = int(state.first_to_slip)
    near = loop_margin(case.loop, case.torque * scale, case.held, case.speed)
    assert float(near) == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(DriveError, match=f"pulley '{case.loop.names[first]}' slips"):
        case._replace(torque=case.torque * scale * (1.0 + 1e-8)).solve()
    edge = solved(case._replace(torque=case.torque * scale * (1.0 - 1e-8)))
    assert float(edge.utilisation[first]) == pytest.approx(1.0, abs=1e-4)
    assert np.max(edge.utilisation) == edge.utilisation[first]


@given(cases())
@settings(REPEATABLE, max_examples=50)
def test_margin_falls_with_the_load_and_past_zero_beyond_capacity(case: Case) -> None:
    share = np.array([0.1, 0.5, 1.0, 3.0, 30.0])
    margins = loop_margin(case.loop, share[:, None] * case.torque, case.held, case.speed)
    finite = margins < 1.0 - 1e-12
    assume(np.all(finite))
    assert np.all(np.diff(margins) < 0.0)
    # All torques reach the limit together, so the reserve is their share of it.
    np.testing.assert_allclose((1.0 - margins) / share, 1.0 - margins[2], rtol=1e-9)


def test_the_first_to_slip_under_more_load_need_not_be_the_one_used_most() -> None:
    loop, torque = serpentine(), np.array([0.0, 0.0, 6.0, 3.0])
    state = solve_loop(loop, torque, 400.0, 100.0)
    assert loop.names[int(np.argmax(state.utilisation))] == "pump"
    assert loop.names[int(state.first_to_slip)] == "crank"
    scale = scale_of(state.margin)
    edge = solve_loop(loop, torque * scale * (1.0 - 1e-6), 400.0, 100.0)
    assert loop.names[int(np.argmax(edge.utilisation))] == "crank"
