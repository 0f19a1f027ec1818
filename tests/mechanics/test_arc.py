"""One pulley arc: against boundary value solutions, and for what the friction law demands of it."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from belt_ros.mechanics import ArcSolution, DriveError, Role, solve_arc
from belt_ros.mechanics.arc_state import arc_state

Floats = NDArray[np.float64]

REPOSITORY = Path(__file__).resolve().parents[2]
OWN = REPOSITORY / "tests" / "data" / "epp_reference.csv"
SHARED = REPOSITORY.parent / "shared" / "reference"
REPEATABLE = settings(derandomize=True, deadline=None, max_examples=200)


@dataclass(frozen=True)
class Arc:
    """An arc by its dimensionless groups, its size and its load."""

    role: int
    growth: float  # a = mu / (R lambda)
    friction: float
    wrap: float
    load: float  # share of mu phi
    radius: float = 0.1
    axial: float = 1e5
    strain: float = 5e-3  # at the inlet
    lift: float = 0.0  # share of the inlet tension that inertia takes up
    speed: float = 10.0

    @property
    def b(self) -> float:
        return self.friction / self.growth

    @property
    def lengths(self) -> float:
        return self.b * self.wrap

    @property
    def inlet_tension(self) -> float:
        return self.axial * self.strain

    @property
    def lifted(self) -> float:
        return self.lift * self.inlet_tension

    @property
    def net(self) -> float:
        return self.axial - self.lifted

    @property
    def traction(self) -> float:
        return self.load * self.friction * self.wrap

    @property
    def outlet_tension(self) -> float:
        return self.outlet_at(math.expm1(self.role * self.traction))

    def outlet_at(self, rise: float) -> float:
        """Outlet tension where W has risen by `rise` along the arc."""
        w_in = self.inlet_tension - self.lifted
        return self.inlet_tension + rise * w_in * self.axial / self.net

    @property
    def rounding(self) -> float:
        """Error of the traction from rounding of the tensions it is computed from."""
        least = min(1.0, math.exp(self.role * self.traction)) * (1.0 - self.lift)
        return 1e-15 * max(1.0, self.outlet_tension / self.inlet_tension * least) / least

    def solve(
        self, inlet: float | Floats | None = None, outlet: float | Floats | None = None
    ) -> ArcSolution:
        return solve_arc(
            self.role,
            self.radius,
            self.wrap,
            self.friction,
            self.net * (self.b / self.radius) ** 2,
            self.axial,
            self.lifted / self.speed**2,
            self.speed,
            self.inlet_tension if inlet is None else inlet,
            self.outlet_tension if outlet is None else outlet,
        )

    def gradient(self, solution: ArcSolution) -> float:
        """D = K |u'(0)| / w_in."""
        w_in = self.inlet_tension - self.lifted
        return abs(float(solution.inlet_strain_gradient)) * self.net / w_in


def spread(low: float, high: float) -> st.SearchStrategy[float]:
    """Floats whose logarithm is spread over the range."""
    return st.floats(math.log(low), math.log(high)).map(math.exp)


EITHER = st.sampled_from([1, -1])
GROWTHS = spread(2e-2, 30.0) | st.floats(0.999, 1.001)
LOADS = st.floats(1e-3, 0.999)


def arcs(
    role: st.SearchStrategy[int] = EITHER,
    growth: st.SearchStrategy[float] = GROWTHS,
    load: st.SearchStrategy[float] = LOADS,
) -> st.SearchStrategy[Arc]:
    return st.builds(
        Arc,
        role=role,
        growth=growth,
        friction=st.floats(0.05, 2.0),
        wrap=st.floats(0.1, 6.2),
        load=load,
        radius=spread(5e-3, 1.0),
        axial=spread(1e3, 1e7),
        strain=spread(1e-5, 0.1),
        lift=st.floats(0.0, 0.8),
    )


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


# --- Reference solutions ---------------------------------------------------------------------


def read(path: Path) -> dict[str, list[str]]:
    if not path.exists():
        pytest.skip(f"{path.name} is not beside this clone")
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: [row[name] for row in rows] for name in rows[0]}


def numbers(table: dict[str, list[str]], name: str) -> Floats:
    return np.array([float(value) for value in table[name]])


def solved_table(table: dict[str, list[str]], columns: list[str]) -> ArcSolution:
    roles = [Role.DRIVEN if role == "driven" else Role.DRIVER for role in table[columns[0]]]
    return solve_arc(roles, *(numbers(table, name) for name in columns[1:]))


SHARED_COLUMNS = [
    "role",
    "radius_m",
    "wrap_rad",
    "friction_coefficient",
    "kf_n_per_m2",
    "axial_stiffness_n",
    "mass_per_length_kg_per_m",
    "inlet_speed_m_per_s",
    "inlet_tension_n",
    "outlet_tension_n",
]


def test_agrees_with_own_boundary_value_solutions_to_the_digits_written() -> None:
    # Twelve digits are written, so 5e-12 is rounding; 4.6e-12 in u'(0) was reached.
    table = read(OWN)
    solution = solved_table(table, list(table)[:10])
    zones = numbers(table, "zones")
    assert len(zones) == 75
    np.testing.assert_allclose(
        solution.inlet_strain_gradient, numbers(table, "inlet_gradient"), rtol=1e-11
    )
    np.testing.assert_allclose(
        solution.transition_angle, numbers(table, "slide_from_rad"), rtol=1e-11
    )
    np.testing.assert_allclose(
        solution.restick_angle, numbers(table, "restick_from_rad"), rtol=1e-11
    )
    np.testing.assert_array_equal(solution.elastic_only, zones == 1)
    np.testing.assert_array_equal(np.isnan(solution.restick_angle), zones < 3)


def test_agrees_with_shared_boundary_value_solutions() -> None:
    table = read(SHARED / "epp_single_pulley.csv")
    solution = solved_table(table, SHARED_COLUMNS)
    np.testing.assert_allclose(
        solution.inlet_strain_gradient, numbers(table, "inlet_strain_gradient"), rtol=1e-8
    )
    np.testing.assert_allclose(
        solution.transition_angle, numbers(table, "transition_angle_rad"), rtol=0, atol=1e-9
    )
    np.testing.assert_array_equal(solution.elastic_only, numbers(table, "elastic_only") == 1)


def test_agrees_with_shared_integrations_that_restick() -> None:
    table = read(SHARED / "epp_restick.csv")
    solution = solved_table(table, SHARED_COLUMNS)
    np.testing.assert_allclose(
        solution.inlet_strain_gradient, numbers(table, "inlet_strain_gradient"), rtol=1e-8
    )
    for angle, name in (
        (solution.transition_angle, "transition_angle_rad"),
        (solution.restick_angle, "restick_angle_rad"),
    ):
        np.testing.assert_allclose(angle, numbers(table, name), rtol=0, atol=1e-9)


# --- What holds for every arc ----------------------------------------------------------------


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


def test_arrays_broadcast_and_equal_their_scalars() -> None:
    stiffness = np.geomspace(1e5, 1e9, 7)[:, None]
    outlet = np.linspace(210.0, 900.0, 5)
    fixed = (0.08, 3.0, 0.9)
    belt = (8e4, 0.1, 9.0, 200.0)
    many = solve_arc(Role.DRIVEN, *fixed, stiffness, *belt, outlet)
    assert many.inlet_strain_gradient.shape == (7, 5)
    assert many.elastic_only.shape == (7, 5)
    for i in range(7):
        for j in range(5):
            one = solve_arc(Role.DRIVEN, *fixed, stiffness[i, 0], *belt, outlet[j])
            for field, value in zip(many, one, strict=True):
                np.testing.assert_array_equal(field[i, j], value)


@pytest.mark.parametrize("growth", [0.2, 1.0, 3.0])
@pytest.mark.parametrize("role", list(Role))
def test_equal_tensions_leave_the_belt_unstretched(role: Role, growth: float) -> None:
    arc = Arc(role, growth, 0.8, 3.0, 0.0)
    solution = arc.solve()
    assert float(solution.inlet_strain_gradient) == 0.0
    assert bool(solution.elastic_only)
    assert float(solution.transition_angle) == arc.wrap


# --- The paper's limits ----------------------------------------------------------------------


def paper_arc(role: Role, tight: float) -> ArcSolution:
    tensions = (200.0, tight) if role is Role.DRIVEN else (tight, 200.0)
    return solve_arc(role, 0.08125, math.pi, 1.2, 8.1e7, 80068.0, 0.0, 9.75, *tensions)


@pytest.mark.parametrize(("role", "limit"), [(Role.DRIVEN, 373.0), (Role.DRIVER, 293.0)])
def test_figure_10_elastic_creep_alone_up_to_its_limit(role: Role, limit: float) -> None:
    assert paper_arc(role, limit - 0.5).elastic_only
    assert not paper_arc(role, limit + 0.5).elastic_only


@pytest.mark.parametrize("role", list(Role))
def test_figure_10_full_slip_at_8675_newton(role: Role) -> None:
    assert float(paper_arc(role, 8675.0).transition_angle) < 1e-3
    with pytest.raises(DriveError, match="gross slip"):
        paper_arc(role, 8676.0)


# --- What cannot be --------------------------------------------------------------------------


GOOD: dict[str, Any] = {
    "role": Role.DRIVEN,
    "radius": 0.1,
    "wrap_angle": 3.0,
    "friction_coefficient": 0.5,
    "friction_stiffness": 1e7,
    "axial_stiffness": 1e5,
    "mass_per_length": 0.1,
    "inlet_speed": 30.0,
    "inlet_tension": 200.0,
    "outlet_tension": 300.0,
}


@pytest.mark.parametrize("bad", [0.0, -2.5, math.nan, math.inf])
@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("radius", "radius"),
        ("wrap_angle", "wrap angle"),
        ("friction_coefficient", "friction coefficient mu"),
        ("friction_stiffness", "friction stiffness kf"),
        ("axial_stiffness", "axial stiffness EA"),
    ],
)
def test_refuses_a_parameter_that_is_not_positive(name: str, text: str, bad: float) -> None:
    with pytest.raises(DriveError, match=rf"^{text} is {bad:g}; it must be finite and > 0$"):
        solve_arc(**{**GOOD, name: bad})


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (
            {"inlet_tension": 90.0},
            r"the belt lifts off: tension 90 N is not above m v\^2 90 N",
        ),
        (
            {"inlet_tension": 50.0},
            r"the belt lifts off: tension 50 N is not above m v\^2 90 N",
        ),
        (
            {"role": Role.DRIVER, "outlet_tension": 80.0},
            r"the belt lifts off: tension 80 N is not above m v\^2 90 N",
        ),
        (
            {"inlet_speed": 1000.0},
            "belt speed 1000 m/s is not below the critical speed 1000 m/s",
        ),
        (
            {"inlet_speed": -1200.0},
            "belt speed -?1200 m/s is not below the critical speed 1000 m/s",
        ),
        (
            {"outlet_tension": 600.0},
            r"effective tension ratio 4.6\d+ is not below exp\(mu phi\) = 4.48169: gross slip",
        ),
        (
            {"role": Role.DRIVER, "inlet_tension": 600.0, "outlet_tension": 200.0},
            r"effective tension ratio 4.6\d+ is not below exp\(mu phi\) = 4.48169: gross slip",
        ),
        (
            {"outlet_tension": 150.0},
            "tensions 200 -> 150 N run against the arc's role",
        ),
        (
            {"role": Role.DRIVER},
            "tensions 200 -> 300 N run against the arc's role",
        ),
    ],
)
def test_refuses_a_state_that_cannot_exist(changed: dict[str, float], message: str) -> None:
    with pytest.raises(DriveError, match=f"^{message}$"):
        solve_arc(**{**GOOD, **changed})


@pytest.mark.parametrize("mass", [-0.1, math.nan])
def test_refuses_a_mass_that_is_not_one(mass: float) -> None:
    with pytest.raises(DriveError, match="mass"):
        solve_arc(**{**GOOD, "mass_per_length": mass})


@pytest.mark.parametrize("role", [0.0, 2.0, -0.5, math.nan])
def test_refuses_a_role_that_is_neither_driven_nor_driver(role: float) -> None:
    with pytest.raises(DriveError, match="role"):
        solve_arc(**{**GOOD, "role": role, "outlet_tension": 200.0 + math.copysign(5.0, role)})


def test_names_the_first_bad_value_of_an_array() -> None:
    with pytest.raises(DriveError, match=r"^friction coefficient mu is -1; "):
        solve_arc(**{**GOOD, "friction_coefficient": [0.5, -1.0, -2.0]})
