"""The same loop, told otherwise, has the same solution; on two pulleys it is that of the drive."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from drawing import spread
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from layouts import serpentines
from loops import NAMES, REPEATABLE, Case, cases, scale_of, solved

from belt_ros.mechanics import (
    Belt,
    BeltDrive,
    DriveError,
    Kinematics,
    Pulley,
    Tensioning,
    margin,
    solve_equilibrium,
)
from belt_ros.mechanics.layout import Layout, Side, trace
from belt_ros.mechanics.loop import (
    BeltLoop,
    FixedCentres,
    HeldSpan,
    HubLoad,
    LoopPulley,
    loop_pulleys,
)
from belt_ros.mechanics.loop_equilibrium import LoopEquilibrium, solve_loop

# --- Two pulleys ------------------------------------------------------------------------------


@st.composite
def drives(draw: st.DrawFn, tensioning: Tensioning) -> tuple[BeltDrive, float, float, float]:
    """A drive, its torque, what it holds and its speed."""
    axial = draw(spread(3e3, 3e6))
    tension = axial * draw(spread(1e-4, 3e-2))

    def pulley() -> Pulley:
        radius = draw(spread(0.02, 0.5))
        stiffness = axial * (draw(spread(0.05, 50.0)) / radius) ** 2
        return Pulley(radius, draw(st.floats(0.5, 6.0)), draw(st.floats(0.1, 1.5)), stiffness)

    driven, driver = pulley(), pulley()
    speed = draw(spread(0.1, 500.0)) * draw(st.sampled_from([1.0, -1.0]))
    mass = draw(st.floats(0.0, 0.8)) * tension / (speed * driver.radius) ** 2
    drive = BeltDrive(
        Belt(axial, mass),
        driven,
        driver,
        span_length=draw(spread(0.1, 5.0)),
        kinematics=draw(st.sampled_from(Kinematics)),
        tensioning=tensioning,
    )
    unit = draw(st.sampled_from([1.0, -1.0])) * tension * driven.radius
    load = draw(st.floats(0.01, 0.95))
    return drive, load * scale_of(margin(drive, unit, tension, speed)) * unit, tension, speed


def as_loop(drive: BeltDrive, tensioning: Any) -> BeltLoop:
    pulleys = (
        LoopPulley("driven", drive.driven, drive.span_length),
        LoopPulley("driver", drive.driver, drive.span_length),
    )
    return BeltLoop(drive.belt, pulleys, "driver", drive.kinematics, tensioning)


def assert_same(
    drive: BeltDrive,
    torque: float,
    held: float,
    speed: float,
    tensioning: Any,
    asked: float,
    tension_error: float = 1e-12,
    error: float = 1e-12,
) -> None:
    """The loop's solution is the drive's."""
    state = two_pulley_state(drive, torque, held, speed)
    found = solve_loop(as_loop(drive, tensioning), [torque, 0.0], asked, speed)

    def same(one: Any, other: Any, rtol: float = error, atol: float = 0.0) -> None:
        np.testing.assert_allclose(one, other, rtol=rtol, atol=atol)

    tensions = [state.tight_tension, state.slack_tension]
    same(found.span_tension, tensions if torque >= 0.0 else tensions[::-1], tension_error)
    same(found.slip, [state.slip, 0.0])
    same(found.speed, [state.driven_speed, speed])
    same(found.transition_angle, [state.driven_transition_angle, state.driver_transition_angle])
    same(found.inlet_gradient, [state.driven_inlet_gradient, state.driver_inlet_gradient])
    same(found.restick_angle, [state.driven_restick_angle, state.driver_restick_angle])
    same(found.friction_loss, state.friction_loss)
    if not isinstance(tensioning, HeldSpan) or drive.tensioning is Tensioning.CONSTANT_SLACK:
        same(found.margin, state.margin, 0.0, 10.0 * tension_error)


def two_pulley_state(drive: BeltDrive, torque: float, held: float, speed: float) -> Any:
    try:
        state = solve_equilibrium(drive, torque, held, speed)
    except DriveError as error:
        assume("slip beyond 100 %" not in str(error))
        raise
    assume(float(state.driven_inlet_gradient) < 1.0)
    assume(float(state.driver_inlet_gradient) < 1.0)
    return state


def slack_span(torque: float) -> HeldSpan:
    return HeldSpan("driver" if torque >= 0.0 else "driven")


@given(drives(Tensioning.CONSTANT_SLACK))
@REPEATABLE
def test_two_pulleys_with_a_held_slack_span_are_the_drive(given_drive: Any) -> None:
    drive, torque, held, speed = given_drive
    assert_same(drive, torque, held, speed, slack_span(torque), held)


@given(drives(Tensioning.CONSTANT_MEAN))
@REPEATABLE
def test_two_pulleys_with_a_held_mean_tension_are_the_drive(given_drive: Any) -> None:
    drive, torque, held, speed = given_drive
    slack = float(two_pulley_state(drive, torque, held, speed).slack_tension)
    assert_same(drive, torque, held, speed, slack_span(torque), slack)


@given(drives(Tensioning.CONSTANT_HUB_LOAD), st.sampled_from(["driven", "driver"]))
@REPEATABLE
def test_two_pulleys_with_a_hub_load_are_the_drive(given_drive: Any, name: str) -> None:
    drive, torque, held, speed = given_drive
    pulley = drive.driven if name == "driven" else drive.driver
    load = 2.0 * held * math.sin(0.5 * pulley.wrap_angle)
    assert_same(drive, torque, held, speed, HubLoad(name), load)


@given(drives(Tensioning.FIXED_CENTRES))
@REPEATABLE
def test_two_pulleys_with_fixed_centres_are_the_drive(given_drive: Any) -> None:
    drive, torque, held, speed = given_drive
    # The drive's two nested iterations leave some 1e-11 of its tension, the loop's one 1e-15 EA.
    assert_same(drive, torque, held, speed, FixedCentres(), held, 1e-10, 1e-8)


# --- Symmetries -------------------------------------------------------------------------------


@given(cases(), st.integers(1, 5))
@REPEATABLE
def test_the_starting_pulley_does_not_matter(case: Case, shift: int) -> None:
    shift %= len(case.loop.pulleys)
    one = solved(case)
    pulleys = case.loop.pulleys[shift:] + case.loop.pulleys[:shift]
    loop = replace(case.loop, pulleys=pulleys)
    other = solve_loop(loop, np.roll(case.torque, -shift), case.held, case.speed)
    assert_equal_states(loop, other, one, lambda values: np.roll(values, -shift))
    first = int(one.first_to_slip)
    if first >= 0 and distinct_limits(one):
        assert loop.names[int(other.first_to_slip)] == case.loop.names[first]


def distinct_limits(state: LoopEquilibrium) -> bool:
    used = np.sort(state.utilisation)
    return bool(used[-1] > used[-2] * 1.001)


def assert_equal_states(
    loop: BeltLoop, one: LoopEquilibrium, other: LoopEquilibrium, moved: Any = np.asarray
) -> None:
    """Tensions are equal to rounding, and what hangs on them.

    A length is known to some 1e-16 of itself, and the tension that fixed centres make of it to that
    share of EA.
    """
    rounding = 1e-14 * float(np.max(one.span_tension))
    if isinstance(loop.tensioning, FixedCentres):
        rounding += 2e-15 * loop.belt.axial_stiffness
    np.testing.assert_allclose(one.span_tension, moved(other.span_tension), rtol=0.0, atol=rounding)
    np.testing.assert_allclose(one.slip, moved(other.slip), rtol=1e-8, atol=1e-12)
    np.testing.assert_allclose(one.speed, moved(other.speed), rtol=1e-10)
    for name in ("transition_angle", "restick_angle", "utilisation"):
        np.testing.assert_allclose(
            getattr(one, name), moved(getattr(other, name)), rtol=1e-7, atol=1e-9
        )
    assert float(one.margin) == pytest.approx(float(other.margin), abs=1e-9)


@given(cases())
@REPEATABLE
def test_the_list_backwards_is_the_same_loop_in_reverse(case: Case) -> None:
    one = solved(case)
    pulleys = case.loop.pulleys[::-1]
    spans = [p.span_length for p in case.loop.pulleys]
    spans = spans[-2::-1] + spans[-1:]
    tensioning = case.loop.tensioning
    if isinstance(tensioning, HubLoad):
        tensioning = HubLoad(tensioning.on, -tensioning.angle)
    if isinstance(tensioning, HeldSpan):
        after = (case.loop.index(tensioning.after) + 1) % len(pulleys)
        tensioning = HeldSpan(case.loop.names[after])
    loop = replace(
        case.loop,
        pulleys=tuple(replace(p, span_length=s) for p, s in zip(pulleys, spans, strict=True)),
        tensioning=tensioning,
    )
    other = solve_loop(loop, -case.torque[::-1], case.held, -case.speed)
    moved = other._replace(
        span_tension=np.roll(other.span_tension[::-1], -1),
        slip=other.slip[::-1],
        speed=-other.speed[::-1],
        transition_angle=other.transition_angle[::-1],
        restick_angle=other.restick_angle[::-1],
        utilisation=other.utilisation[::-1],
    )
    assert_equal_states(loop, moved, one)


@given(serpentines())
@settings(REPEATABLE, max_examples=50)
def test_a_mirrored_layout_has_the_same_solution(layout: Layout) -> None:
    mirrored = trace([replace(d, x=-d.x, side=Side(-d.side)) for d in layout.discs])
    names = NAMES[: len(layout.discs)]
    loops = [
        BeltLoop(Belt(1e5), loop_pulleys(place, names, 0.8, 1e8), names[0])
        for place in (layout, mirrored)
    ]
    torque = loops[0].torques({names[1]: 0.5 * layout.discs[1].radius})
    one, other = (solve_loop(loop, torque, 400.0, 50.0) for loop in loops)
    assert_equal_states(loops[0], other, one)


def with_idler(loop: BeltLoop, place: int, idler: Pulley) -> BeltLoop:
    """Loop with an idler in the span after pulley `place`, on the same length of path."""
    rest = loop.pulleys[place].span_length - idler.radius * idler.wrap_angle
    before = replace(loop.pulleys[place], span_length=0.4 * rest)
    pulleys = (
        *loop.pulleys[:place],
        before,
        LoopPulley("idler", idler, 0.6 * rest),
        *loop.pulleys[place + 1 :],
    )
    return replace(loop, pulleys=pulleys)


@given(cases(), st.data())
@REPEATABLE
def test_an_idler_without_torque_changes_nothing(case: Case, data: st.DataObject) -> None:
    place = data.draw(st.integers(0, len(case.loop.pulleys) - 1))
    idler = Pulley(0.1 * case.loop.pulleys[place].span_length, 1.0, 0.3, 1e7)
    loop = with_idler(case.loop, place, idler)
    one = solved(case)
    both = solve_loop(loop, np.insert(case.torque, place + 1, 0.0), case.held, case.speed)
    per_pulley = [name for name in one._fields if getattr(one, name).ndim]
    others = both._replace(**{n: np.delete(getattr(both, n), place + 1) for n in per_pulley})
    assert_equal_states(loop, others, one)
    assert float(both.span_tension[place + 1]) == float(both.span_tension[place])
    assert float(both.torque[place + 1]) == 0.0
    assert float(both.inlet_gradient[place + 1]) == 0.0
    assert float(both.transition_angle[place + 1]) == idler.wrap_angle
    assert float(both.utilisation[place + 1]) == 0.0
