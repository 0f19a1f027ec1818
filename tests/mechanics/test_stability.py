"""Natural modes of an arc: against textbooks, the equations themselves and two other routes."""

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import eigvals

from belt_ros.mechanics.arc import Role, solve_arc
from belt_ros.mechanics.drive import Belt, BeltDrive, DriveError, Pulley, Tensioning
from belt_ros.mechanics.equilibrium import solve_equilibrium, torque_capacity
from belt_ros.mechanics.stability import Modes, arc_modes, drive_modes

REPEATABLE = settings(derandomize=True, deadline=None, max_examples=100)
Complex = NDArray[np.complex128]


class Arc(NamedTuple):
    """Arguments of `arc_modes`, without the count."""

    role: Role = Role.DRIVEN
    radius: float = 0.08125
    wrap_angle: float = math.pi
    transition_angle: float = math.pi
    friction_coefficient: float = 1.2
    friction_stiffness: float = 8.1e7
    axial_stiffness: float = 80068.0
    mass_per_length: float = 0.1036
    speed: float = 9.75
    restick_angle: float = math.nan

    def modes(self, count: int = 3) -> Modes:
        return arc_modes(*self[:-1], count=count, restick_angle=self.restick_angle)

    @property
    def critical_speed(self) -> float:
        return math.sqrt(self.axial_stiffness / self.mass_per_length)

    @property
    def net(self) -> float:
        return self.axial_stiffness - self.mass_per_length * self.speed**2

    @property
    def zones(self) -> list[tuple[float, bool]]:
        """Length [m] of every zone and whether it slides."""
        end = self.wrap_angle if math.isnan(self.restick_angle) else self.restick_angle
        angles = (
            (self.transition_angle, False),
            (end - self.transition_angle, True),
            (self.wrap_angle - end, False),
        )
        return [(self.radius * angle, slides) for angle, slides in angles if angle > 0.0]

    def terms(self, omega: Any, slides: bool) -> tuple[Any, Any]:
        """First and zeroth coefficient of Eqs. 63-64, the second being -(EA - m v^2)."""
        m, v = self.mass_per_length, self.speed
        first, zeroth = 2j * omega * m * v, -m * omega**2
        if slides:
            friction = self.role * self.friction_coefficient / self.radius
            return first + friction * self.net, zeroth - 1j * omega * friction * m * v
        return first, zeroth + self.friction_stiffness


def spread(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(math.log(low), math.log(high)).map(math.exp)


def restuck(speed: float) -> Arc:
    """A driven arc, compliant and near its capacity, that slides and re-sticks."""
    arc = Arc(friction_stiffness=2e6, speed=speed)
    lift = arc.mass_per_length * speed**2
    tensions = lift + 100.0, lift + 100.0 + 100.0 * math.expm1(3.5) * 80068.0 / arc.net
    found = solve_arc(*arc[:3], *arc[4:8], speed, *tensions)
    assert found.transition_angle < found.restick_angle < arc.wrap_angle
    return arc._replace(
        transition_angle=float(found.transition_angle), restick_angle=float(found.restick_angle)
    )


ARCS = {
    "elastic": Arc(),
    "elastic, compliant": Arc(friction_stiffness=1e5, speed=400.0),
    "driven": Arc(transition_angle=2.158),
    "driver": Arc(role=Role.DRIVER, transition_angle=2.082),
    "driven, fast": Arc(transition_angle=1.0, speed=800.0),
    "driver, overdamped": Arc(role=Role.DRIVER, transition_angle=1.0, speed=700.0),
    "driver, near critical": Arc(role=Role.DRIVER, transition_angle=2.0, speed=870.0),
    "standstill": Arc(transition_angle=2.0, speed=0.0),
    "sliding all over": Arc(transition_angle=0.0, speed=100.0),
    "re-stuck": restuck(9.75),
    "re-stuck, fast": restuck(400.0),
}
every_arc = pytest.mark.parametrize("arc", ARCS.values(), ids=ARCS.keys())


@st.composite
def arcs(draw: st.DrawFn) -> Arc:
    """Arcs of any kind, stiffness and speed; a sliding zone of any length."""
    arc = Arc(
        role=draw(st.sampled_from(Role)),
        radius=draw(spread(0.02, 0.5)),
        wrap_angle=draw(st.floats(0.5, 6.0)),
        friction_coefficient=draw(st.floats(0.1, 1.5)),
        friction_stiffness=draw(spread(1e5, 1e11)),
        axial_stiffness=draw(spread(3e3, 3e6)),
        mass_per_length=draw(spread(1e-6, 3.0)),
    )
    ratio = draw(st.one_of(st.just(0.0), st.floats(0.0, 0.99), spread(1e-6, 1e-1)))
    part = draw(st.one_of(st.just(1.0), st.floats(0.0, 1.0)))
    arc = arc._replace(speed=ratio * arc.critical_speed, transition_angle=part * arc.wrap_angle)
    compliant = arc.friction_coefficient**2 > arc.friction_stiffness * arc.radius**2 / arc.net
    if arc.role is Role.DRIVEN and compliant and part < 1.0:
        again = draw(st.floats(0.01, 1.0))
        arc = arc._replace(
            restick_angle=arc.transition_angle + again * (1.0 - part) * arc.wrap_angle
        )
    return arc


# --- Textbook and limits -------------------------------------------------------------------------


@pytest.mark.parametrize("stiffness", [1e5, 8.1e7, 1e11])
def test_a_sprung_arc_at_standstill_has_the_frequencies_of_a_sprung_rod(stiffness: float) -> None:
    arc = Arc(friction_stiffness=stiffness, speed=0.0)
    waves = (np.arange(20) + 0.5) / arc.radius  # (n - 1/2) pi / L with L = pi R
    expected = np.sqrt((stiffness + arc.axial_stiffness * waves**2) / arc.mass_per_length)
    modes = arc.modes(20)
    np.testing.assert_allclose(modes.frequencies.real, expected, rtol=1e-12)
    np.testing.assert_allclose(modes.frequencies.imag, 0.0, atol=1e-12 * expected[0])
    angles = np.linspace(0.0, math.pi, 50)
    np.testing.assert_allclose(
        modes.shapes(angles), np.sin(waves[:, None] * arc.radius * angles), atol=1e-7
    )


def test_a_travelling_rod_without_friction_decays_at_its_outlet() -> None:
    # Eq. 63 with kf -> 0: z = -artanh(v/v_cr) + i pi (n - 1/2).
    arc = Arc(friction_stiffness=1e-9, speed=500.0)
    beta = 500.0 / arc.critical_speed
    unit = (1.0 - beta**2) * arc.critical_speed / (arc.radius * arc.wrap_angle)
    expected = unit * (math.pi * (np.arange(20) + 0.5) + 1j * math.atanh(beta))
    np.testing.assert_allclose(arc.modes(20).frequencies, expected, rtol=1e-12)


@pytest.mark.parametrize("role", Role)
def test_a_rigid_contact_leaves_the_sliding_zone_to_itself(role: Role) -> None:
    arc = Arc(role=role, transition_angle=2.0, friction_stiffness=1e17, speed=200.0)
    alone = arc._replace(wrap_angle=math.pi - 2.0, transition_angle=0.0)
    np.testing.assert_allclose(arc.modes().frequencies, alone.modes().frequencies, rtol=1e-4)


def test_a_fast_driver_arc_lets_the_sliding_belt_creep_at_mu_v_over_r() -> None:
    arc = Arc(role=Role.DRIVER, transition_angle=2.0, speed=878.0)
    rate = arc.friction_coefficient * arc.speed / arc.radius  # Eq. 64 with u constant
    assert np.abs(arc.modes(20).frequencies / (1j * rate) - 1.0).min() < 1e-3


def test_frequencies_go_with_one_over_the_root_of_mass() -> None:
    heavy = Arc(role=Role.DRIVER, transition_angle=2.0, speed=0.0)
    light = heavy._replace(mass_per_length=1e-8 * heavy.mass_per_length)
    np.testing.assert_allclose(light.modes().frequencies, 1e4 * heavy.modes().frequencies, 1e-12)


# --- The equations themselves --------------------------------------------------------------------


def differentiation(length: float, points: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Chebyshev points on [0, length] and the derivative at them."""
    turn = math.pi * np.arange(points) / (points - 1)
    nodes = -np.cos(turn)
    # -cos a + cos b without cancellation
    apart = 2.0 * np.sin(0.5 * (turn[:, None] + turn)) * np.sin(0.5 * (turn[:, None] - turn))
    np.fill_diagonal(apart, 1.0)
    sign = (-1.0) ** np.arange(points) / np.where(np.isin(np.arange(points), (0, points - 1)), 2, 1)
    slopes = sign / sign[:, None] / apart
    np.fill_diagonal(slopes, 0.0)
    np.fill_diagonal(slopes, -slopes.sum(axis=1))
    return 0.5 * length * (nodes + 1.0), slopes * (2.0 / length)


@every_arc
def test_modes_satisfy_the_equations_and_their_ends(arc: Arc) -> None:
    modes = arc.modes(5)
    omega = modes.frequencies[:, None]
    points = 80 if arc.speed > 0.95 * arc.critical_speed else 36  # thin layers
    start, slopes, sizes, residuals = 0.0, [], [], []
    for length, slides in arc.zones:
        s, d = differentiation(length, points)
        phi = modes.shapes(np.minimum((start + s) / arc.radius, arc.wrap_angle))
        slope = phi @ d.T
        first, zeroth = arc.terms(omega, slides)
        terms = np.stack([-arc.net * slope @ d.T, first * slope, zeroth * phi])
        residuals.append(np.abs(terms.sum(axis=0)).max(axis=-1))
        sizes.append(np.abs(terms).max(axis=(0, -1)))
        slopes.append(slope)
        start += length
    assert np.all(np.max(residuals, axis=0) < 1e-8 * np.max(sizes, axis=0))
    steepest = np.abs(slopes).max(axis=(0, -1))
    for before, after in pairwise(slopes):
        assert np.all(np.abs(before[:, -1] - after[:, 0]) < 1e-8 * steepest)
    assert np.all(np.abs(slopes[-1][:, -1]) < 1e-8 * steepest)
    np.testing.assert_allclose(modes.shapes(0.0), 0.0, atol=1e-15)


def collocated(arc: Arc, points: int) -> Complex:
    """Frequencies of Eqs. 63-68 by collocation in the physical variables, spurious ones among."""
    slopes = [differentiation(length, points)[1] for length, _ in arc.zones]
    size = points * len(slopes)
    powers = np.zeros((3, size, size), dtype=complex)  # of omega
    stiffness = arc.net / (arc.radius * arc.wrap_angle) ** 2
    inertia = -arc.mass_per_length
    for index, (d, (_, slides)) in enumerate(zip(slopes, arc.zones, strict=True)):
        here = slice(index * points, (index + 1) * points)
        still, turning = arc.terms(0.0, slides), arc.terms(1.0, slides)
        unit = np.eye(points)
        powers[0, here, here] = still[1] * unit + still[0] * d - arc.net * d @ d
        powers[1, here, here] = (turning[1] - still[1] - inertia) * unit
        powers[1, here, here] += (turning[0] - still[0]) * d
        powers[2, here, here] = inertia * unit
    powers /= stiffness
    joints = range(points, size, points)
    powers[:, [0, *joints, *(joint - 1 for joint in joints), -1]] = 0.0
    powers[0, 0, 0] = 1.0
    for index, joint in enumerate(joints):
        powers[0, joint, joint - 1 : joint + 1] = 1.0, -1.0
        powers[0, joint - 1, joint - points : joint] = slopes[index][-1]
        powers[0, joint - 1, joint : joint + points] = -slopes[index + 1][0]
    powers[0, -1, -points:] = slopes[-1][-1]
    scale = arc.critical_speed / (arc.radius * arc.wrap_angle)
    unit, nothing = np.eye(size), np.zeros((size, size))
    left = np.block([[nothing, unit], [-powers[0], -powers[1] * scale]])
    right = np.block([[unit, nothing], [nothing, powers[2] * scale**2]])
    found = eigvals(left, right)
    return scale * found[np.isfinite(found)]


@every_arc
def test_collocation_in_the_physical_variables_finds_the_same_frequencies(arc: Arc) -> None:
    frequencies = arc.modes(5).frequencies
    found = collocated(arc, 72 if arc.speed > 0.95 * arc.critical_speed else 32)
    distance = np.abs(found[:, None] - frequencies).min(axis=0)
    np.testing.assert_array_less(distance, 5e-7 * np.abs(frequencies))


# --- None missed, none invented ------------------------------------------------------------------


def determinant(arc: Arc, omega: Complex) -> Complex:
    """u'(s_f) from u = 0, u' = 1 at the inlet, by the exponentials of Eqs. 63-64; entire in omega.

    Over a positive factor, different for each omega.
    """
    u, slope = np.zeros_like(omega), np.ones_like(omega)
    for length, slides in arc.zones:
        first, zeroth = (np.broadcast_to(term, omega.shape) for term in arc.terms(omega, slides))
        root = np.sqrt(first**2 + 4.0 * arc.net * zeroth + 0j)
        up, down = (first + root) / (2.0 * arc.net), (first - root) / (2.0 * arc.net)
        most = np.maximum(up.real, down.real) * length
        a, b = np.exp(up * length - most), np.exp(down * length - most)
        gap = root / arc.net
        u, slope = (
            ((up * b - down * a) * u + (a - b) * slope) / gap,
            (up * down * (b - a) * u + (up * a - down * b) * slope) / gap,
        )
        size = np.abs(u) / length + np.abs(slope)
        u, slope = u / size, slope / size
    return slope


def turns(arc: Arc, corners: list[complex], near: Complex) -> float:
    """Turns of the determinant about zero along a path past corners; finest beside `near`."""
    total = 0.0
    steps = np.geomspace(1e-9, 1e3, 2001) * arc.critical_speed / (arc.radius * arc.wrap_angle)
    for start, end in pairwise(corners):
        along = (end - start) / abs(end - start)
        offsets = ((near - start) / along).real[:, None] + np.concatenate([-steps, steps])
        at = np.concatenate([offsets.ravel(), np.linspace(0.0, abs(end - start), 301)])
        at = np.unique(at[(at >= 0.0) & (at <= abs(end - start))])
        values = determinant(arc, start + along * at)
        for _ in range(50):
            angles = np.angle(values[1:] / values[:-1])
            coarse = np.flatnonzero(np.abs(angles) > 0.7)
            if coarse.size == 0:
                break
            middle = 0.5 * (at[coarse] + at[coarse + 1])
            at = np.insert(at, coarse + 1, middle)
            values = np.insert(values, coarse + 1, determinant(arc, start + along * middle))
        total += float(angles.sum()) / (2.0 * math.pi)
    return total


def counted(arc: Arc, upto: float, found: Complex) -> float:
    """Zeros of the determinant with |Re omega| < upto, by the argument principle.

    The box reaches from below the real axis to well above all decay rates found. The determinant at
    -conj(omega) is the conjugate of that at omega, so half of the way round does.
    """
    unit = arc.critical_speed / (arc.radius * arc.wrap_angle)
    high = 2.0 * np.abs(found.imag).max() + 20.0 * unit
    low = -0.01 * unit
    return 2.0 * turns(arc, [1j * low, upto + 1j * low, upto + 1j * high, 1j * high], found)


@settings(REPEATABLE, max_examples=60)
@given(arcs(), st.integers(1, 6))
def test_the_argument_principle_counts_the_modes_found(arc: Arc, count: int) -> None:
    found = arc.modes(count + 1).frequencies
    assert found.size == count + 1
    last, beyond = found.real[-2:]
    if last == beyond:
        return  # both overdamped: no line parts them
    overdamped = np.count_nonzero(found.real[:-1] == 0.0)
    expected = overdamped + 2 * (count - overdamped)
    assert counted(arc, 0.5 * (last + beyond), found) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize(
    "arc",
    [
        # One layer thinner than the sliding zone, which has modes below those of the sprung zone.
        Arc(role=Role.DRIVER, transition_angle=0.991 * math.pi, friction_stiffness=4.4e12),
        Arc(transition_angle=0.995 * math.pi, friction_stiffness=2.4e12, speed=0.0),
        Arc(role=Role.DRIVER, transition_angle=2.0, speed=878.0),
        Arc(role=Role.DRIVER, transition_angle=0.2, friction_stiffness=1e6, speed=878.9),
        Arc(transition_angle=math.pi - 1e-9, speed=600.0),
    ],
    ids=[
        "short sliding zone",
        "at standstill",
        "critical",
        "critical, compliant",
        "hardly sliding",
    ],
)
def test_none_is_missed_at_the_extremes(arc: Arc) -> None:
    found = arc.modes(4).frequencies
    overdamped = np.count_nonzero(found.real[:-1] == 0.0)
    between = 0.5 * (found.real[-1] + found.real[-2])
    assert counted(arc, between, found) == pytest.approx(
        overdamped + 2 * (3 - overdamped), abs=1e-3
    )


@every_arc
def test_twenty_modes_are_the_first_twenty(arc: Arc) -> None:
    found = arc.modes(20).frequencies
    overdamped = np.count_nonzero(found.real[:-1] == 0.0)
    between = 0.5 * (found.real[-1] + found.real[-2])
    assert counted(arc, between, found) == pytest.approx(
        overdamped + 2 * (19 - overdamped), abs=1e-3
    )
    np.testing.assert_array_equal(arc.modes(3).frequencies.round(6), found[:3].round(6))


@every_arc
def test_frequencies_come_in_gyroscopic_pairs_and_in_order(arc: Arc) -> None:
    found = arc.modes(6).frequencies
    assert np.all(found.real >= 0.0)
    assert np.all(np.diff(found.real) >= 0.0)
    partners = -found.conj()
    beside = np.abs(determinant(arc, 1.001 * partners))
    np.testing.assert_array_less(np.abs(determinant(arc, partners)), 1e-6 * beside)


# --- Stability -----------------------------------------------------------------------------------


@REPEATABLE
@given(arcs())
def test_every_arc_below_the_critical_speed_is_stable(arc: Arc) -> None:
    modes = arc.modes(5)
    assert modes.is_stable
    if arc.speed == 0.0:
        limit = 1e-12 * np.abs(modes.frequencies)
        np.testing.assert_array_less(np.abs(modes.frequencies.imag), limit)


@REPEATABLE
@given(arcs(), st.floats(0.1, 0.99))
def test_a_travelling_arc_of_moderate_stiffness_loses_what_disturbs_it(
    arc: Arc, ratio: float
) -> None:
    net = arc.axial_stiffness * (1.0 - ratio**2)
    stretch = 10.0 / (arc.radius * arc.wrap_angle)
    moving = arc._replace(
        speed=ratio * arc.critical_speed,
        friction_stiffness=net * stretch**2,
        restick_angle=math.nan,
    )
    assert np.all(moving.modes().frequencies.imag > 0.0)


@every_arc
def test_the_outlet_takes_out_all_that_the_modes_lose(arc: Arc) -> None:
    # The energy balance that proves stability: with f = u exp(-(i omega m v/K) s), K = EA - m v^2,
    # and the weight p of Sturm and Liouville, Re z = -beta p(L) |f(L)|^2 L / (2 int p |f|^2 ds).
    modes = arc.modes(5)
    modes = replace(
        modes,
        **{
            name: getattr(modes, name)[modes.frequencies.real > 0.0]
            for name in ("frequencies", "eigenvalues")
        },
    )
    beta = arc.speed / arc.critical_speed
    start, weight = 0.0, 1.0
    stored = np.zeros(modes.frequencies.size)
    travel = 1j * modes.frequencies * arc.mass_per_length * arc.speed / arc.net
    for length, slides in arc.zones:
        nodes, gauss = np.polynomial.legendre.leggauss(80)
        s = 0.5 * length * (np.append(nodes, 1.0) + 1.0)
        angle = np.minimum((start + s) / arc.radius, arc.wrap_angle)
        f = np.abs(modes.shapes(angle) * np.exp(-travel[:, None] * (start + s))) ** 2
        drift = arc.role * arc.friction_coefficient / arc.radius if slides else 0.0
        p = weight * np.exp(-drift * s)
        stored += (p * f)[:, :-1] @ gauss * 0.5 * length
        start, weight, at_outlet = start + length, p[-1], (p * f)[:, -1]
    unit = arc.net / arc.axial_stiffness * arc.critical_speed  # omega = -i z unit / L
    decay = 0.5 * beta * unit * at_outlet / stored
    np.testing.assert_allclose(modes.frequencies.imag, decay, rtol=1e-8, atol=1e-8)


def test_growth_would_be_called_unstable() -> None:
    modes = Arc().modes()
    assert not replace(modes, frequencies=modes.frequencies.conj()).is_stable


# --- Continuity, shapes --------------------------------------------------------------------------


@pytest.mark.parametrize("role", Role)
@pytest.mark.parametrize("speed", [0.0, 9.75, 100.0])
def test_frequencies_move_continuously_with_the_transition_angle(role: Role, speed: float) -> None:
    angles = np.concatenate([[0.0, 1e-9], np.linspace(1e-3, math.pi - 1e-3, 200)])
    angles = np.concatenate([angles, [math.pi - 1e-9, math.pi]])
    arc = Arc(role=role, speed=speed)
    found = np.stack([arc._replace(transition_angle=x).modes(5).frequencies for x in angles])
    steps = np.abs(np.diff(found, axis=0)) / np.abs(found[:-1])
    assert np.all(steps < 3.0 * np.diff(angles)[:, None] + 1e-7)


def test_two_overdamped_modes_become_a_pair_where_they_meet() -> None:
    arc = Arc(role=Role.DRIVER, speed=300.0)
    angles = np.linspace(0.4, 0.8, 101)
    modes = [arc._replace(transition_angle=x).modes().frequencies for x in angles]
    apart = np.array([omega[1].real == 0.0 for omega in modes])
    assert apart[0]
    assert not apart[-1]
    assert np.all(np.diff(apart.astype(int)) <= 0)
    first = np.array([omega[0] for omega in modes])
    second = np.array([omega[1] if omega[1].real == 0.0 else -omega[0].conj() for omega in modes])
    for smooth in (first + second, first * second):
        assert np.abs(np.diff(smooth)).max() < 0.02 * np.abs(smooth).max()


@every_arc
def test_shapes_are_normalised_with_a_positive_slope_at_the_inlet(arc: Arc) -> None:
    modes = arc.modes(5)
    angles = np.linspace(0.0, arc.wrap_angle, 20001)
    np.testing.assert_allclose(np.abs(modes.shapes(angles)).max(axis=1), 1.0, atol=1e-5)
    slope = modes.shapes(1e-7)
    assert np.all(slope.real > 0.0)
    np.testing.assert_allclose(slope.imag / slope.real, 0.0, atol=1e-4)


def test_shapes_keep_the_shape_of_the_angles() -> None:
    modes = Arc(transition_angle=2.0).modes(4)
    assert modes.shapes(1.0).shape == (4,)
    assert modes.shapes(np.ones((2, 3))).shape == (4, 2, 3)


# --- The whole drive -----------------------------------------------------------------------------


def paper_drive(**changed: Any) -> BeltDrive:
    """Table 1."""
    pulley = Pulley(0.08125, math.pi, 1.2, 8.1e7)
    return BeltDrive(Belt(80068.0, 0.1036), pulley, pulley, **changed)


def test_the_arcs_of_a_drive_are_those_of_its_equilibrium() -> None:
    drive = paper_drive()
    modes = drive_modes(drive, 45.0, 434.0, 120.0, count=4)
    state = solve_equilibrium(drive, 45.0, 434.0, 120.0)
    for role, found, transition in (
        (Role.DRIVEN, modes.driven, state.driven_transition_angle),
        (Role.DRIVER, modes.driver, state.driver_transition_angle),
    ):
        expected = Arc(role=role, transition_angle=float(transition)).modes(4)
        np.testing.assert_array_equal(found.frequencies, expected.frequencies)


@pytest.mark.parametrize(("torque", "speed"), [(-45.0, 120.0), (45.0, -120.0)])
def test_a_driving_load_swaps_the_arcs(torque: float, speed: float) -> None:
    drive = paper_drive()
    forward = drive_modes(drive, 45.0, 434.0, 120.0)
    back = drive_modes(drive, torque, 434.0, speed)
    np.testing.assert_allclose(back.driven.frequencies, forward.driver.frequencies, rtol=1e-12)
    np.testing.assert_allclose(back.driver.frequencies, forward.driven.frequencies, rtol=1e-12)


@st.composite
def loaded_drives(draw: st.DrawFn) -> tuple[BeltDrive, float, float, float]:
    """A drive, its torque [N m], held tension [N] and driver speed [rad/s]."""
    axial = draw(spread(3e3, 3e6))
    tension = axial * draw(spread(1e-3, 3e-2))
    friction = draw(st.floats(0.1, 1.5))
    pulleys = [
        Pulley(
            draw(spread(0.02, 0.5)),
            draw(st.floats(0.5, 6.0)),
            friction * draw(st.floats(0.5, 2.0)),
            draw(spread(1e5, 1e11)),
        )
        for _ in range(2)
    ]
    speed = draw(spread(0.1, 500.0))
    lift = draw(spread(1e-6, 0.8)) * tension
    drive = BeltDrive(
        Belt(axial, lift / (speed * pulleys[1].radius) ** 2),
        *pulleys,
        tensioning=draw(st.sampled_from([Tensioning.CONSTANT_MEAN, Tensioning.CONSTANT_SLACK])),
    )
    limit = float(torque_capacity(drive, tension, speed))
    return drive, draw(st.floats(0.0, 0.99)) * limit, tension, speed


@REPEATABLE
@given(loaded_drives())
def test_every_drive_is_stable_in_equilibrium(case: tuple[BeltDrive, float, float, float]) -> None:
    modes = drive_modes(*case)
    assert modes.driven.is_stable
    assert modes.driver.is_stable


# --- Errors --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"speed": 900.0}, r"900 m/s is not below the critical speed 879\.1"),
        ({"speed": -1.0}, "-1 m/s is against"),
        ({"speed": math.nan}, "nan m/s"),
        ({"mass_per_length": 0.0}, "without inertia"),
        ({"transition_angle": 3.2}, "3.2 rad is not within the wrap angle 3.14"),
        ({"transition_angle": math.nan}, "nan rad"),
        ({"transition_angle": 1.0, "restick_angle": 2.0}, "only driven arcs with mu > lambda R"),
        ({"friction_stiffness": 1e6, "restick_angle": 2.0}, "not between the transition angle"),
        ({"friction_stiffness": 0.0}, "kf is 0"),
        ({"radius": -1.0}, "radius is -1"),
    ],
)
def test_what_cannot_be_is_refused(changed: dict[str, float], message: str) -> None:
    with pytest.raises(DriveError, match=message):
        Arc()._replace(**changed).modes()


@pytest.mark.parametrize("count", [0, 21])
def test_counts_out_of_range_are_refused(count: int) -> None:
    with pytest.raises(DriveError, match=f"{count} modes"):
        Arc().modes(count)


def test_a_massless_or_critical_drive_is_refused() -> None:
    with pytest.raises(DriveError, match="without inertia"):
        drive_modes(paper_drive().without_inertia(), 45.0, 434.0, 120.0)
    with pytest.raises(DriveError, match="critical speed"):
        drive_modes(paper_drive(), 45.0, 434.0, 12000.0)


@pytest.mark.parametrize("angle", [-0.1, 3.2, math.nan])
def test_shapes_off_the_arc_are_refused(angle: float) -> None:
    with pytest.raises(DriveError, match="not on the arc"):
        Arc().modes().shapes(angle)
