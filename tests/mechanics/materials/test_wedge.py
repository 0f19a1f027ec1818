"""The groove: flank forces, the equivalent flat belt, and standard sections."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from belt_ros.mechanics.drive import BeltDrive, DriveError, Pulley, Tensioning
from belt_ros.mechanics.equilibrium import torque_capacity
from belt_ros.mechanics.materials.catalogue import belt_material
from belt_ros.mechanics.materials.contact_layer import in_series, shear_layer
from belt_ros.mechanics.materials.ranges import Range
from belt_ros.mechanics.materials.sources import SOURCES
from belt_ros.mechanics.materials.wedge import (
    V_BELTS,
    V_RIBS,
    WedgeSection,
    equivalent_friction,
    flank_force,
    flank_friction_stiffness,
    sticks_in_groove,
    wedge_factor,
    wedging_factor,
)

ANGLES = st.floats(math.radians(10.0), math.pi)
FRICTIONS = st.floats(0.01, 2.0)


@pytest.mark.parametrize(
    ("degrees", "factor"), [(34, 3.4203), (36, 3.2361), (38, 3.0716), (40, 2.9238), (180, 1.0)]
)
def test_wedge_factor_of_standard_grooves(degrees: float, factor: float) -> None:
    assert wedge_factor(math.radians(degrees)) == pytest.approx(factor, abs=5e-5)


@pytest.mark.parametrize("angle", [0.0, -0.5, 38.0, math.nan, math.inf])
def test_groove_angle_is_in_radians_up_to_flat(angle: float) -> None:
    with pytest.raises(DriveError, match=r"Give radians: 38 deg is 0\.663 rad"):
        wedge_factor(angle)


@given(angle=ANGLES, mu=FRICTIONS, force=st.floats(1e-3, 1e6))
@settings(derandomize=True, deadline=None)
def test_flanks_carry_the_belt(angle: float, mu: float, force: float) -> None:
    # The balance of forces across the belt, flanks' normals and radial friction resolved inwards.
    half = angle / 2.0
    balance = np.array([[2.0 * math.sin(half)]])
    seated = np.linalg.solve(balance, [force])[0]
    assert flank_force(force, angle) == pytest.approx(seated)
    wedging = np.linalg.solve(balance + 2.0 * mu * math.cos(half), [force])[0]
    assert wedging_factor(angle, mu) * force == pytest.approx(2.0 * wedging)
    assert wedging_factor(angle, mu) <= wedge_factor(angle)


def test_capacity_in_a_groove_is_that_of_the_equivalent_flat_belt() -> None:
    mu, angle, wrap, radius = 0.35, math.radians(38.0), 2.6, 0.07

    def tension_gradient(_: float, tension: np.ndarray) -> np.ndarray:
        return 2.0 * mu * np.array([flank_force(tension[0] / radius, angle)]) * radius

    along = solve_ivp(tension_gradient, (0.0, wrap), [100.0], rtol=1e-10, atol=1e-10)
    belt = belt_material("spa").belt(1.0)
    flat = Pulley(radius, wrap, equivalent_friction(mu, angle), 1e8)
    drive = BeltDrive(belt, flat, flat, tensioning=Tensioning.CONSTANT_SLACK)
    capacity = torque_capacity(drive.without_inertia(), 100.0, 0.0)
    assert capacity / radius == pytest.approx(along.y[0, -1] - 100.0, rel=1e-8)


def test_belt_sticks_where_friction_exceeds_the_flank_slope() -> None:
    angle = math.radians(34.0)
    assert sticks_in_groove(angle, 0.306)
    assert not sticks_in_groove(angle, 0.305)


@pytest.mark.parametrize(
    ("section", "millimetres", "degrees"),
    [
        ("SPZ", 80, 34),
        ("SPZ", 81, 38),
        ("SPA", 118, 34),
        ("SPA", 119, 38),
        ("SPB", 190, 34),
        ("SPB", 191, 38),
        ("SPC", 315, 34),
        ("C", 316, 38),
    ],
)
def test_groove_angle_follows_the_pulley(section: str, millimetres: float, degrees: float) -> None:
    angle = V_BELTS[section].groove_angle(1e-3 * millimetres)
    assert math.degrees(angle) == pytest.approx(degrees)


@pytest.mark.parametrize("section", V_RIBS.values(), ids=V_RIBS)
def test_ribs_run_in_forty_degrees_on_every_pulley(section: WedgeSection) -> None:
    for diameter in (section.smallest_diameter, 0.5, math.inf):
        assert math.degrees(section.groove_angle(diameter)) == pytest.approx(40.0)


def test_too_small_a_pulley_is_refused() -> None:
    with pytest.raises(DriveError, match=r"0\.1 m; section SPB bends over 0\.14 m at least"):
        belt_material("SPB").equivalent_friction(datum_diameter=0.1)


def test_grip_of_a_named_v_belt_has_the_factor_of_its_pulley() -> None:
    belt = belt_material("SPA")
    small, large = (belt.equivalent_friction(datum_diameter=d).typical for d in (0.1, 0.3))
    flank = belt.friction_coefficient().typical
    assert small == pytest.approx(flank * wedge_factor(math.radians(34.0)))
    assert large == pytest.approx(flank * wedge_factor(math.radians(38.0)))
    assert belt.equivalent_friction().typical == pytest.approx(large)


def test_ribs_count() -> None:
    belt = belt_material("6PK")
    assert belt.belt(6).axial_stiffness == pytest.approx(6 * 2.2e4)
    assert belt.belt(6).mass_per_length == pytest.approx(6 * 0.021)


def test_sections_grow_with_their_mass() -> None:
    for family in (("SPZ", "SPA", "SPB", "SPC"), ("Z", "A", "B", "C")):
        ordered = [V_BELTS[name] for name in family]
        assert ordered == sorted(ordered, key=lambda one: one.mass.typical)
        assert ordered == sorted(ordered, key=lambda one: one.stiffness.typical)


def test_two_flanks_of_a_layer_are_twice_its_shear() -> None:
    assert flank_friction_stiffness(2e6, 0.01, 0.0025) == 2.0 * 2e6 * 0.01 / 0.0025
    for wrong in ((0.0, 0.01, 0.1), (1e6, -1.0, 0.1), (1e6, 0.01, math.inf)):
        with pytest.raises(DriveError, match="must be finite and > 0"):
            flank_friction_stiffness(*wrong)


def test_shear_layer_is_widened_threefold_either_way() -> None:
    modulus = Range(1e6, 2e6, 3e6, "Pa", SOURCES[:1])
    layer = shear_layer(modulus, Range(1e-3, 2e-3, 4e-3, "m", SOURCES[:1]))
    assert (layer.low, layer.typical, layer.high) == pytest.approx((2.5e8 / 3.0, 1e9, 9e9))
    assert not layer.verified


def _layer(thickness: float) -> Range:
    modulus = Range(1e6, 1e6, 1.001e6, "Pa", SOURCES[:1])
    return shear_layer(modulus, Range(thickness, thickness, 1.001 * thickness, "m", SOURCES[1:2]))


def test_two_layers_of_one_rubber_are_one_thicker_layer() -> None:
    both = in_series(_layer(1e-3), _layer(3e-3))
    one = _layer(4e-3)
    assert both.typical == pytest.approx(one.typical) == pytest.approx(1e6 / 4e-3)
    assert (both.low, both.high) == pytest.approx((one.low, one.high))
    assert set(both.sources) == set(one.sources)
