"""Natural modes of an arc, against textbooks, the equations themselves and collocation."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import eigvals
from vibrating_arcs import Arc, Complex, every_arc

from belt_ros.mechanics.arc import Role

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
