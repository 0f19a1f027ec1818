"""Arcs below the critical speed lose what disturbs them, and so do the arcs of every drive."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from drawing import spread
from hypothesis import given
from hypothesis import strategies as st
from vibrating_arcs import ARCS, REPEATABLE, Arc, arcs, every_arc

from belt_ros.mechanics.arc import Role, solve_arc
from belt_ros.mechanics.drive import Belt, BeltDrive, DriveError, Pulley, Tensioning
from belt_ros.mechanics.equilibrium import solve_equilibrium, torque_capacity
from belt_ros.mechanics.stability import drive_modes


@pytest.mark.parametrize("name", ["re-stuck", "re-stuck, fast"])
def test_arcs_that_are_said_to_restick_do(name: str) -> None:
    arc = ARCS[name]
    lift = arc.mass_per_length * arc.speed**2
    tensions = lift + 100.0, lift + 100.0 + 100.0 * math.expm1(3.5) * arc.axial_stiffness / arc.net

    found = solve_arc(*arc[:3], *arc[4:8], arc.speed, *tensions)

    assert float(found.transition_angle) == pytest.approx(arc.transition_angle, abs=1e-6)
    assert float(found.restick_angle) == pytest.approx(arc.restick_angle, abs=1e-6)


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


def test_a_massless_or_critical_drive_is_refused() -> None:
    with pytest.raises(DriveError, match="without inertia"):
        drive_modes(paper_drive().without_inertia(), 45.0, 434.0, 120.0)
    with pytest.raises(DriveError, match="critical speed"):
        drive_modes(paper_drive(), 45.0, 434.0, 12000.0)
