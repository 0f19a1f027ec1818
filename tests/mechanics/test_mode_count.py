"""No natural mode of an arc is missed and none invented, by the argument principle."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vibrating_arcs import REPEATABLE, Arc, Complex, arcs, every_arc

from belt_ros.mechanics.arc import Role


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
