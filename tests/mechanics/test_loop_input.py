"""Loops take layouts, names and arrays; what cannot run is refused by the pulley's name."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from loops import serpentine

from belt_ros.mechanics import Belt, DriveError, Pulley
from belt_ros.mechanics.layout import Disc, trace
from belt_ros.mechanics.loop import (
    BeltLoop,
    FixedCentres,
    HeldSpan,
    HubLoad,
    LoopPulley,
    loop_pulleys,
)
from belt_ros.mechanics.loop_equilibrium import loop_margin, solve_loop


def test_pulleys_of_a_layout_take_its_wraps_and_spans() -> None:
    layout = trace([Disc(0.0, 0.0, 0.1), Disc(1.0, 0.0, 0.2)])
    one, other = loop_pulleys(layout, "ab", [0.5, 0.6], 1e8, [0.01, 0.02])
    assert one == LoopPulley(
        "a", Pulley(0.1, float(layout.wrap_angle[0]), 0.5, 1e8, 0.01), float(layout.span_length[0])
    )
    assert other.pulley == Pulley(0.2, float(layout.wrap_angle[1]), 0.6, 1e8, 0.02)


def test_torques_by_name_fill_the_rest_with_zero() -> None:
    torque = serpentine().torques({"pump": [1.0, 2.0, 3.0], "alternator": 5.0})
    expected = [[0.0, 0.0, 5.0, pump] for pump in (1.0, 2.0, 3.0)]
    np.testing.assert_array_equal(torque, expected)
    with pytest.raises(DriveError, match=r"^no pulley is called 'fan'; there are crank, idler,"):
        serpentine().torques({"fan": 1.0})


@pytest.mark.parametrize(
    ("tensioning", "held"),
    [(FixedCentres(), 400.0), (HeldSpan("idler"), 400.0), (HubLoad("idler", 0.1), 300.0)],
)
def test_arrays_equal_their_scalars(tensioning: Any, held: float) -> None:
    loop = serpentine(tensioning=tensioning)
    torque = loop.torques({"alternator": [-4.0, 0.0, 5.0], "pump": [1.0, 0.0, -1.0]})[:, None]
    tension = np.array([held, 1.5 * held])
    speed = np.array([120.0, -30.0, 0.0])[:, None, None]
    many = solve_loop(loop, torque, tension, speed)
    margins = loop_margin(loop, torque, tension, speed)
    assert many.span_tension.shape == (3, 3, 2, 4)
    assert many.margin.shape == margins.shape == (3, 3, 2)
    for k, j, i in np.ndindex(3, 3, 2):
        one = solve_loop(loop, torque[j, 0], tension[i], speed[k, 0, 0])
        for field, value in zip(many, one, strict=True):
            np.testing.assert_array_equal(field[k, j, i], value)
        assert margins[k, j, i] == one.margin


def test_a_torque_beyond_capacity_is_refused_with_the_pulley_and_both_numbers() -> None:
    loop = serpentine()
    scale = 1.0 / (1.0 - float(loop_margin(loop, [0.0, 0.0, 0.0, 50.0], 400.0, 100.0)))
    message = (
        rf"^pulley 'pump' slips: its torque of 50 N m is not within its capacity of "
        rf"{50.0 * scale:g} N m, which {scale:g} times all torques use up; tension the belt more"
    )
    with pytest.raises(DriveError, match=message):
        solve_loop(loop, [0.0, 0.0, 0.0, 50.0], 400.0, 100.0)


def test_a_driver_that_slips_first_is_named() -> None:
    pulleys = tuple(
        replace(
            p, pulley=replace(p.pulley, friction_coefficient=0.05 if p.name == "crank" else 2.0)
        )
        for p in serpentine().pulleys
    )
    with pytest.raises(DriveError, match=r"^pulley 'crank' slips: its torque of -45 N m"):
        solve_loop(serpentine(pulleys=pulleys), [0.0, 0.0, 20.0, 0.0], 400.0, 100.0)


def test_a_span_that_the_load_would_lift_off_is_refused_by_name() -> None:
    loop = serpentine(tensioning=HeldSpan("alternator"))
    message = (
        r"^the belt lifts off in the span that leaves 'crank': its effective tension would be -"
    )
    with pytest.raises(DriveError, match=message):
        solve_loop(loop, [0.0, 0.0, 40.0, 0.0], 400.0, 100.0)


@pytest.mark.parametrize("tensioning", [FixedCentres(), HeldSpan("pump")])
@pytest.mark.parametrize("function", [solve_loop, loop_margin])
def test_tension_below_inertia_is_refused(function: Any, tensioning: Any) -> None:
    message = r"^the belt lifts off: tension 400 N is not above m v\^2 = 648 N; tension it more"
    with pytest.raises(DriveError, match=message):
        function(serpentine(tensioning=tensioning), np.zeros(4), 400.0, -1000.0)


@pytest.mark.parametrize("load", [0.0, -5.0])
def test_a_hub_load_that_does_not_pull_is_refused(load: float) -> None:
    with pytest.raises(DriveError, match=rf"^hub load is {load:g} N; it must be > 0$"):
        solve_loop(serpentine(tensioning=HubLoad("idler")), np.zeros(4), load, 100.0)


@pytest.mark.parametrize("function", [solve_loop, loop_margin])
def test_a_belt_above_its_critical_speed_is_refused(function: Any) -> None:
    with pytest.raises(
        DriveError, match=r"^belt speed 900 m/s is not below the critical speed 866"
    ):
        function(serpentine(), np.zeros(4), 1e6, 10000.0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize("function", [solve_loop, loop_margin])
def test_a_state_that_is_not_finite_is_refused(function: Any, place: int, bad: float) -> None:
    state: list[Any] = [[0.0, 0.0, 1.0, 0.0], 400.0, 100.0]
    state[place] = [0.0, 0.0, bad, 0.0] if place == 0 else bad
    with pytest.raises(DriveError, match="contains NaN or infinity"):
        function(serpentine(), *state)


@pytest.mark.parametrize(("torque", "shape"), [(1.0, "()"), ([1.0, 2.0], "(2,)")])
def test_torques_for_another_number_of_pulleys_are_refused(torque: Any, shape: str) -> None:
    with pytest.raises(DriveError) as caught:
        solve_loop(serpentine(), torque, 400.0, 100.0)
    assert str(caught.value) == f"torque has shape {shape}; it must be (..., 4)"


def test_states_that_do_not_broadcast_are_refused() -> None:
    with pytest.raises(DriveError, match=r"^torque \(3, 4\), tension \(2,\) and speed \(\) do not"):
        solve_loop(serpentine(), np.zeros((3, 4)), [400.0, 500.0], 100.0)


def test_a_torque_on_the_driver_is_refused() -> None:
    with pytest.raises(
        DriveError, match=r"^the driver 'crank' is given -3 N m; its torque follows"
    ):
        solve_loop(serpentine(), [-3.0, 0.0, 3.0, 0.0], 400.0, 100.0)


def test_a_pulley_that_would_be_pushed_backwards_is_refused() -> None:
    pulley = Pulley(0.05, 3.0, 1.2, 2e5)
    pulleys = (LoopPulley("fan", pulley, 0.3), LoopPulley("motor", pulley, 0.3))
    loop = BeltLoop(Belt(2e3), pulleys, "motor", tensioning=HeldSpan("motor"))
    scale = 1.0 / (1.0 - float(loop_margin(loop, [1.0, 0.0], 100.0, 50.0)))
    message = r"^pulley 'fan' would have to turn backwards: its strain gradient u'\(0\) is "
    with pytest.raises(DriveError, match=message):
        solve_loop(loop, [0.9999 * scale, 0.0], 100.0, 50.0)


PULLEY = LoopPulley("a", Pulley(0.1, 3.0, 0.5, 1e8), 0.5)


def test_a_loop_of_one_pulley_is_refused() -> None:
    with pytest.raises(DriveError, match=r"^the belt runs on 1 pulleys; it needs at least 2$"):
        BeltLoop(Belt(1e5), (PULLEY,), "a")


def test_two_pulleys_of_one_name_are_refused() -> None:
    with pytest.raises(DriveError, match=r"^pulleys a, a: every name must be its own$"):
        BeltLoop(Belt(1e5), (PULLEY, PULLEY), "a")


@pytest.mark.parametrize(
    ("driver", "tensioning"),
    [("x", FixedCentres()), ("a", HeldSpan("x")), ("a", HubLoad("x"))],
)
def test_a_name_that_no_pulley_has_is_refused(driver: str, tensioning: Any) -> None:
    with pytest.raises(DriveError, match=r"^no pulley is called 'x'; there are a, b$"):
        BeltLoop(Belt(1e5), (PULLEY, replace(PULLEY, name="b")), driver, tensioning=tensioning)


@pytest.mark.parametrize("angle", [0.5 * math.pi, -2.0, math.nan])
def test_a_hub_load_that_does_not_tension_the_belt_is_refused(angle: float) -> None:
    with pytest.raises(DriveError, match=r"^hub load acts at .* rad to the bisector"):
        HubLoad("a", angle)


@pytest.mark.parametrize("length", [0.0, -1.0, math.nan, math.inf])
def test_a_span_without_length_is_refused(length: float) -> None:
    with pytest.raises(DriveError, match=r"^span length is"):
        replace(PULLEY, span_length=length)


def test_more_wrap_than_a_turn_is_refused() -> None:
    with pytest.raises(DriveError, match="a belt wraps less than a turn"):
        replace(PULLEY.pulley, wrap_angle=2.0 * math.pi)


def test_names_and_values_must_be_as_many_as_the_pulleys() -> None:
    layout = trace([Disc(0.0, 0.0, 0.1), Disc(1.0, 0.0, 0.2)])
    with pytest.raises(DriveError, match=r"^3 names for 2 pulleys$"):
        loop_pulleys(layout, "abc", 0.5, 1e8)
    with pytest.raises(DriveError, match=r"^kf has shape \(3,\); it must be one or \(2,\)$"):
        loop_pulleys(layout, "ab", 0.5, [1e8, 1e8, 1e8])
