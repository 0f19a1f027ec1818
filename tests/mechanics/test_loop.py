"""Belts on any number of pulleys: against the two-pulley drive, and what every loop must obey."""

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from layouts import serpentines
from numpy.typing import NDArray

from belt_ros.mechanics import (
    Belt,
    BeltDrive,
    DriveError,
    Kinematics,
    Pulley,
    Role,
    Tensioning,
    margin,
    solve_arc,
    solve_equilibrium,
)
from belt_ros.mechanics.layout import Disc, Layout, Side, trace
from belt_ros.mechanics.loop import (
    BeltLoop,
    FixedCentres,
    HeldSpan,
    HubLoad,
    LoopPulley,
    loop_pulleys,
)
from belt_ros.mechanics.loop_equilibrium import LoopEquilibrium, loop_margin, solve_loop

REPEATABLE = settings(derandomize=True, deadline=None, max_examples=100)
NAMES = "abcdef"
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


def spread(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(math.log(low), math.log(high)).map(math.exp)


class Case(NamedTuple):
    """A loop, the state asked of it, and where it came from."""

    loop: BeltLoop
    torque: NDArray[np.float64]
    held: float
    speed: float

    def solve(self) -> LoopEquilibrium:
        return solve_loop(self.loop, self.torque, self.held, self.speed)


def tensionings(names: list[str]) -> st.SearchStrategy[Any]:
    name = st.sampled_from(names)
    return st.one_of(
        st.builds(FixedCentres),
        st.builds(HeldSpan, name),
        st.builds(HubLoad, name, st.floats(-0.6, 0.6)),
    )


def scale_of(margin: Any) -> float:
    """By how much all torques may grow."""
    return 1.0 / (1.0 - float(margin)) if float(margin) < 1.0 else math.inf


@st.composite
def given_wraps(draw: st.DrawFn, axial: float) -> tuple[LoopPulley, ...]:
    """Pulleys with random wraps and spans, without a layout that has them."""
    soft = draw(st.booleans())  # so that the belt re-sticks
    grips, frictions = ((0.3, 0.7), (0.9, 1.6)) if soft else ((0.1, 40.0), (0.2, 1.5))
    wraps = (2.5, 5.0) if soft else (0.3, 5.0)

    def pulley() -> Pulley:
        radius = draw(spread(0.02, 0.3))
        stiffness = axial * (draw(spread(*grips)) / radius) ** 2
        return Pulley(radius, draw(st.floats(*wraps)), draw(st.floats(*frictions)), stiffness)

    names = NAMES[: draw(st.integers(3, 6))]
    return tuple(LoopPulley(name, pulley(), draw(spread(0.05, 2.0))) for name in names)


@st.composite
def cases(
    draw: st.DrawFn,
    *,
    massless: bool = False,
    tensioning: Any = None,
    kinematics: Kinematics | None = None,
) -> Case:
    """A random loop of 3 to 6 pulleys, loaded up to a share of its capacity."""
    axial = draw(spread(3e3, 3e6))
    tension = axial * draw(spread(1e-4, 3e-2))
    pulleys = draw(given_wraps(axial))
    driver = draw(st.sampled_from(pulleys))
    speed = draw(spread(0.1, 500.0)) * draw(st.sampled_from([1.0, -1.0]))
    lift = 0.0 if massless else draw(spread(1e-3, 0.8)) * tension
    loop = BeltLoop(
        Belt(axial, lift / (speed * driver.pulley.radius) ** 2),
        pulleys,
        driver.name,
        kinematics or draw(st.sampled_from(Kinematics)),
        tensioning or draw(tensionings([p.name for p in pulleys])),
    )
    held = tension
    if isinstance(loop.tensioning, HubLoad):
        wrap = loop.pulleys[loop.index(loop.tensioning.on)].pulley.wrap_angle
        held = 2.0 * tension * math.sin(0.5 * wrap) * math.cos(loop.tensioning.angle)
    pull = st.sampled_from([-1.0, -0.3, 0.0, 0.3, 1.0])
    torque = np.array([draw(pull) * tension * p.pulley.radius for p in pulleys])
    torque[pulleys.index(driver)] = 0.0
    scale = scale_of(loop_margin(loop, torque, held, speed))
    load = draw(st.one_of(st.floats(0.01, 0.97), st.floats(0.9, 0.97)))
    return Case(loop, torque * min(scale * load, 3.0), held, speed)


def resticking() -> Case:
    """A soft driven pulley near its capacity, on which the belt ends to slide before it leaves."""
    pulleys = tuple(
        LoopPulley(name, Pulley(0.1, wrap, friction, 1e4 * (0.5 / 0.1) ** 2), 0.3)
        for name, wrap, friction in (("a", 5.0, 1.6), ("b", 3.5, 1.2), ("c", 1.0, 0.5))
    )
    loop = BeltLoop(Belt(1e4, 0.05), pulleys, "a")
    torque = loop.torques({"b": 1.0})
    return Case(loop, torque * 0.95 * scale_of(loop_margin(loop, torque, 100.0, 50.0)), 100.0, 50.0)


def solved(case: Case) -> LoopEquilibrium:
    """Solution; discards the rare loops that would have to turn backwards."""
    try:
        return case.solve()
    except DriveError as error:
        assume("turn backwards" not in str(error))
        raise


def inlet(values: NDArray[np.float64], speed: float) -> NDArray[np.float64]:
    """Values of the spans that enter the pulleys."""
    return np.roll(values, 1) if speed >= 0.0 else values


def outlet(values: NDArray[np.float64], speed: float) -> NDArray[np.float64]:
    return values if speed >= 0.0 else np.roll(values, 1)


def lift(case: Case) -> float:
    radius = case.loop.pulleys[case.loop.index(case.loop.driver)].pulley.radius
    return case.loop.belt.mass_per_length * (case.speed * radius) ** 2


def test_the_random_loops_reach_every_regime() -> None:
    seen = set()

    @given(cases())
    @example(resticking())
    @REPEATABLE
    def collect(case: Case) -> None:
        state = solved(case)
        seen.add(len(case.loop.pulleys))
        seen.add(type(case.loop.tensioning))
        for i, placed in enumerate(case.loop.pulleys):
            wrap = placed.pulley.wrap_angle
            begin, end = zones(state, i, wrap)
            role = np.sign(state.inlet_gradient[i])
            seen.add((role, "elastic" if begin >= wrap else "slip" if end >= wrap else "re-stick"))

    collect()
    wanted = {(role, zone) for role in (1.0, -1.0) for zone in ("elastic", "slip")}
    wanted |= {(0.0, "elastic"), (1.0, "re-stick"), FixedCentres, HeldSpan, HubLoad, 3, 4, 5, 6}
    assert wanted <= seen


# --- An arc by itself, from what the solution says of it --------------------------------------


class Profile(NamedTuple):
    """Points along an arc for quadrature."""

    weight: NDArray[np.float64]  # [m]
    tension: NDArray[np.float64]  # effective, w [N]
    friction: NDArray[np.float64]  # dw/ds [N/m]


def zones(state: LoopEquilibrium, i: int, wrap: float) -> tuple[float, float]:
    """Where sliding begins and ends [rad]."""
    begin, end = float(state.transition_angle[i]), float(state.restick_angle[i])
    return begin, wrap if math.isnan(end) or end > wrap else end


def profile(case: Case, state: LoopEquilibrium, i: int) -> Profile:
    """Effective tension and friction along arc i by the friction law of each zone."""
    pulley, net = case.loop.pulleys[i].pulley, case.loop.belt.axial_stiffness - lift(case)
    rate = math.sqrt(pulley.friction_stiffness / net)
    w_in = float(inlet(state.effective_tension, case.speed)[i])
    gradient = net * float(state.inlet_gradient[i])
    slope = math.copysign(pulley.friction_coefficient / pulley.radius, gradient)
    begin, end = (angle * pulley.radius for angle in zones(state, i, pulley.wrap_angle))
    w_begin = w_in + 2.0 * gradient * math.sinh(0.5 * rate * begin) ** 2
    w_end = w_begin * math.exp(slope * (end - begin))
    bounds = [(0.0, begin), (begin, end), (end, pulley.radius * pulley.wrap_angle)]
    pieces = []
    for zone, (low, high) in enumerate(bounds):
        edges = np.linspace(low, high, 41)
        s = (edges[:-1, None] + 0.5 * np.diff(edges)[:, None] * (1.0 + _NODES)).ravel()
        weight = (0.5 * np.diff(edges)[:, None] * _WEIGHTS).ravel()
        if zone == 0:
            w = w_in + 2.0 * gradient * np.sinh(0.5 * rate * s) ** 2
            friction = gradient * rate * np.sinh(rate * s)
        elif zone == 1:
            w = w_begin * np.exp(slope * (s - begin))
            friction = slope * w
        else:  # the spring goes on from the limit, by what the belt moves
            y = rate * (s - end)
            rest = w_end - w_in + gradient
            w = w_in - gradient + rest * np.cosh(y) + slope * w_end / rate * np.sinh(y)
            friction = rate * rest * np.sinh(y) + slope * w_end * np.cosh(y)
        pieces.append(Profile(weight, w, friction))
    return Profile(*(np.concatenate(column) for column in zip(*pieces, strict=True)))


def belt_tension(case: Case, state: LoopEquilibrium, i: int, w: Any) -> Any:
    """Tension T where the effective tension on arc i is w."""
    ea = case.loop.belt.axial_stiffness
    t_in = float(inlet(state.span_tension, case.speed)[i])
    w_in = float(inlet(state.effective_tension, case.speed)[i])
    return t_in + ea / (ea - lift(case)) * (w - w_in)


@given(cases())
@example(resticking())
@REPEATABLE
def test_friction_along_every_arc_makes_up_the_change_of_tension(case: Case) -> None:
    state = solved(case)
    for i, placed in enumerate(case.loop.pulleys):
        points = profile(case, state, i)
        w_in = float(inlet(state.effective_tension, case.speed)[i])
        change = float(outlet(state.effective_tension, case.speed)[i]) - w_in
        assert points.weight @ points.friction == pytest.approx(change, rel=1e-8, abs=1e-9 * w_in)
        limit = placed.pulley.friction_coefficient * points.tension / placed.pulley.radius
        assert np.all(np.abs(points.friction) <= limit * (1.0 + 1e-7))


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


# --- Balances ---------------------------------------------------------------------------------


@given(cases())
@REPEATABLE
def test_torques_tensions_and_effective_tensions_balance(case: Case) -> None:
    state = solved(case)
    radius = np.array([p.pulley.radius for p in case.loop.pulleys])
    pull = state.torque / radius
    size = float(np.max(state.effective_tension))
    assert np.sum(pull) == pytest.approx(0.0, abs=1e-14 * size)
    given_ones = np.arange(radius.size) != case.loop.index(case.loop.driver)
    np.testing.assert_allclose(state.torque[given_ones], case.torque[given_ones], rtol=1e-15)
    jump = state.effective_tension - np.roll(state.effective_tension, 1)
    np.testing.assert_allclose(jump, pull, atol=1e-14 * size)
    ea = case.loop.belt.axial_stiffness
    tension_jump = state.span_tension - np.roll(state.span_tension, 1)
    np.testing.assert_allclose(
        tension_jump, pull * ea / (ea - lift(case)), atol=1e-13 * np.max(state.span_tension)
    )
    slackest = int(np.argmin(state.span_tension))
    assert float(state.span_tension[slackest]) == pytest.approx(
        float(state.effective_tension[slackest]) + lift(case), rel=1e-14
    )


@given(cases(kinematics=Kinematics.EXACT))
@example(resticking())
@REPEATABLE
def test_power_lost_is_friction_times_sliding_and_never_negative(case: Case) -> None:
    state = solved(case)
    ea = case.loop.belt.axial_stiffness
    loss = 0.0
    for i, placed in enumerate(case.loop.pulleys):
        points = profile(case, state, i)
        rim = abs(float(state.speed[i])) * placed.pulley.radius
        strain = belt_tension(case, state, i, points.tension) / ea
        strain_in = float(inlet(state.span_tension, case.speed)[i]) / ea
        u = float(state.inlet_gradient[i])
        # v(s) - rim speed, with v_in = rim / (1 - u'(0)) and v in proportion to 1 + strain.
        sliding = rim / (1.0 - u) * (u + (strain - strain_in) / (1.0 + strain_in))
        power = points.friction * sliding
        assert np.all(power >= 0.0)
        loss += float(points.weight @ power)
    assert float(state.friction_loss) == pytest.approx(loss, rel=1e-7)
    turning = math.copysign(1.0, case.speed)
    powers = state.torque * state.speed
    digits = 1e-14 * np.sum(np.abs(powers))
    assert float(state.friction_loss) == pytest.approx(-np.sum(powers), rel=0.0, abs=digits)
    assert np.all(np.sign(state.speed) == turning)


def test_an_idle_loop_loses_nothing() -> None:
    state = solve_loop(serpentine(), np.zeros(4), 400.0, 100.0)
    assert float(state.friction_loss) == 0.0
    np.testing.assert_array_equal(state.slip, 0.0)
    np.testing.assert_array_equal(state.span_tension, 400.0)
    assert float(state.margin) == 1.0
    assert int(state.first_to_slip) == -1


@given(cases(tensioning=FixedCentres()))
@example(resticking())
@REPEATABLE
def test_fixed_centres_keep_the_belts_length(case: Case) -> None:
    state = solved(case)
    ea = case.loop.belt.axial_stiffness
    exact = case.loop.kinematics is Kinematics.EXACT

    def held(tension: Any) -> Any:
        return 1.0 / (1.0 + tension / ea) if exact else 1.0 - tension / ea

    spans = np.array([p.span_length for p in case.loop.pulleys])
    length = float(spans @ held(state.span_tension))
    for i in range(spans.size):
        points = profile(case, state, i)
        length += float(points.weight @ held(belt_tension(case, state, i, points.tension)))
    path = float(
        sum(p.span_length + p.pulley.radius * p.pulley.wrap_angle for p in case.loop.pulleys)
    )
    error = (length / path - float(held(case.held))) * ea  # as a tension [N]
    assert error == pytest.approx(0.0, abs=1e-8 * case.held + 1e-14 * ea)


@given(cases(kinematics=Kinematics.EXACT))
@REPEATABLE
def test_mass_is_conserved_round_the_loop(case: Case) -> None:
    state = solved(case)
    rim = state.speed * [p.pulley.radius for p in case.loop.pulleys]
    strain = inlet(state.span_tension, case.speed) / case.loop.belt.axial_stiffness
    flow = rim / (1.0 - state.inlet_gradient) / (1.0 + strain)
    np.testing.assert_allclose(flow, flow[0], rtol=1e-12)


@given(cases(kinematics=Kinematics.LINEAR))
@REPEATABLE
def test_linear_kinematics_counts_strain_from_the_slackest_span(case: Case) -> None:
    state = solved(case)
    rim = state.speed * [p.pulley.radius for p in case.loop.pulleys]
    excess = inlet(state.span_tension, case.speed) - np.min(state.span_tension)
    flow = rim / (1.0 - state.inlet_gradient)
    flow /= 1.0 + excess / case.loop.belt.axial_stiffness
    np.testing.assert_allclose(flow, flow[0], rtol=1e-12)


@given(cases(massless=True))
@REPEATABLE
def test_every_arc_is_that_of_the_single_pulley(case: Case) -> None:
    state = solved(case)
    for i, placed in enumerate(case.loop.pulleys):
        p = placed.pulley
        t_in = float(inlet(state.span_tension, case.speed)[i])
        t_out = float(outlet(state.span_tension, case.speed)[i])
        arc = solve_arc(
            Role.DRIVEN if t_out >= t_in else Role.DRIVER,
            p.radius, p.wrap_angle, p.friction_coefficient, p.friction_stiffness,
            case.loop.belt.axial_stiffness, 0.0, 0.0, t_in, t_out,
        )  # fmt: skip
        close = {"rtol": 1e-7, "atol": 1e-13}  # the tensions' difference has fewer digits
        np.testing.assert_allclose(state.transition_angle[i], arc.transition_angle, **close)
        np.testing.assert_allclose(state.inlet_gradient[i], arc.inlet_strain_gradient, **close)
        traction = abs(math.log(t_out / t_in)) / p.traction_limit
        assert float(state.utilisation[i]) == pytest.approx(traction, rel=1e-12, abs=1e-12)


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


# --- Arrays, names and errors -----------------------------------------------------------------


def serpentine(**changed: Any) -> BeltLoop:
    """A crank, an idler on the belt's back, an alternator and a small pump."""
    layout = trace(
        [
            Disc(0.0, 0.0, 0.09),
            Disc(0.25, 0.03, 0.03, Side.CLOCKWISE),
            Disc(0.4, 0.2, 0.04),
            Disc(0.05, 0.35, 0.05),
        ]
    )
    names = ("crank", "idler", "alternator", "pump")
    pulleys = loop_pulleys(layout, names, [0.8, 0.5, 0.8, 0.2], 4e7)
    return replace(BeltLoop(Belt(6e4, 0.08), pulleys, "crank"), **changed)


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


def test_standstill_is_the_limit_of_slow_travel() -> None:
    torque = [0.0, 0.0, 5.0, 1.0]
    still = solve_loop(serpentine(), torque, 400.0, 0.0)
    slow = solve_loop(serpentine(), torque, 400.0, 1e-9)
    np.testing.assert_allclose(still.slip, slow.slip, rtol=1e-9, atol=1e-16)
    np.testing.assert_array_equal(still.speed, 0.0)
    assert float(still.friction_loss) == 0.0


def test_a_pulley_that_drives_beside_the_driver_turns_faster_than_it() -> None:
    state = solve_loop(serpentine(), [0.0, 0.0, -5.0, 0.0], 400.0, 100.0)
    assert float(state.torque[0]) == pytest.approx(5.0 * 0.09 / 0.04)
    assert float(state.slip[2]) < 0.0
    assert float(state.friction_loss) > 0.0


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
