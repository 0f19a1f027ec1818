"""Round any loop, torques and tensions balance, friction makes up power, and belt is kept."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import example, given
from loops import REPEATABLE, Case, cases, serpentine, solved
from numpy.typing import NDArray

from belt_ros.mechanics import Belt, Kinematics, Pulley, Role, solve_arc
from belt_ros.mechanics.loop import BeltLoop, FixedCentres, HeldSpan, HubLoad, LoopPulley
from belt_ros.mechanics.loop_equilibrium import LoopEquilibrium, solve_loop

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


def resticking() -> Case:
    """A soft driven pulley near its capacity, on which the belt ends to slide before it leaves."""
    pulleys = tuple(
        LoopPulley(name, Pulley(0.1, wrap, friction, 1e4 * (0.5 / 0.1) ** 2), 0.3)
        for name, wrap, friction in (("a", 5.0, 1.6), ("b", 3.5, 1.2), ("c", 1.0, 0.5))
    )
    loop = BeltLoop(Belt(1e4, 0.05), pulleys, "a")
    return Case(loop, loop.torques({"b": 16.4}), 100.0, 50.0)  # 17.2 N m is the most it carries


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
