"""Belts by name: what a preset says, against the catalogues' own figures."""

import math
from dataclasses import fields
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.estimation.assumptions import Prior
from belt_ros.mechanics.drive import DriveError
from belt_ros.mechanics.materials.belt_material import BeltMaterial, Size, stiffness_from_k1
from belt_ros.mechanics.materials.catalogue import BELTS, belt_material
from belt_ros.mechanics.materials.lagging import LAGGINGS, RUBBER_COVER, SurfaceState
from belt_ros.mechanics.materials.ranges import Range
from belt_ros.mechanics.materials.sources import SOURCES
from belt_ros.mechanics.materials.tables import with_tables

DOCUMENT = Path(__file__).parents[3] / "docs" / "materials.md"
EVERY_BELT = pytest.mark.parametrize("belt", BELTS.values(), ids=BELTS)
SIZES = {Size.WIDTH: 0.05, Size.DIAMETER: 0.01, Size.RIBS: 6.0, Size.BELTS: 2.0}


def holds(one: Range, value: float) -> bool:
    return one.low <= value <= one.high


def per_width(newtons: float, metres: float, elongation: float) -> float:
    """EA per width [N/m] from a force on a width at an elongation."""
    return newtons / metres / elongation


def test_tables_of_the_document_are_those_of_the_code() -> None:
    text = DOCUMENT.read_text(encoding="utf-8")
    assert text.count("<!-- table: ") == text.count("<!-- end -->") == 7
    assert text == with_tables(text), "renew it: write with_tables(text) back to docs/materials.md"


def test_every_figure_names_a_listed_source_and_every_source_is_used() -> None:
    used = {source for belt in BELTS.values() for source in belt.sources()}
    grooves = {belt.groove.groove_source for belt in BELTS.values() if belt.groove}
    laggings = {
        source
        for lagging in LAGGINGS.values()
        if lagging.contact_stiffness
        for source in lagging.contact_stiffness.sources
    }
    assert used | grooves | laggings == set(SOURCES)
    assert len({source.key for source in SOURCES}) == len(SOURCES)


@EVERY_BELT
def test_belt_is_found_by_its_name_however_it_is_written(belt: BeltMaterial) -> None:
    assert belt_material(belt.name) is belt
    assert belt_material(f" {belt.name.upper().replace('-', '_')} ") is belt
    assert belt_material(belt.name.replace("-", " ")) is belt


@pytest.mark.parametrize(
    ("name", "found"),
    [("SPA", "v-belt-spa"), ("b", "v-belt-b"), ("PK", "v-ribbed-pk"), ("6PK1200", "v-ribbed-pk")],
)
def test_section_names_its_belt(name: str, found: str) -> None:
    assert belt_material(name).name == found


@pytest.mark.parametrize(
    "name",
    [
        *("timing", "toothed belt", "synchronous", "HTD", "HTD 5M", "htd_8m", "GT2", "GT3", "3GT"),
        *("8MGT", "T5", "T10", "T2.5", "AT5", "AT10", "MXL", "XL", "L", "H", "5M", "S8M", "RPP8M"),
        *("STD 5M", "Poly Chain", "polychain"),
    ],
)
def test_toothed_belts_are_refused_with_the_reason_and_the_way_out(name: str) -> None:
    with pytest.raises(DriveError, match="by form, not by friction") as refusal:
        belt_material(name)
    assert str(refusal.value).startswith(f"{name!r} is a toothed belt")
    assert "Compare the positions" in str(refusal.value)


@pytest.mark.parametrize("name", ["leather", "", "spx", "PX", "polyurethane"])
def test_unknown_belt_lists_the_names(name: str) -> None:
    with pytest.raises(DriveError, match="no belt is called") as refusal:
        belt_material(name)
    assert all(known in str(refusal.value) for known in BELTS)


@EVERY_BELT
def test_figures_scale_with_size(belt: BeltMaterial) -> None:
    size = SIZES[belt.size]
    section = 4.0 if belt.size is Size.DIAMETER else 2.0
    contact = 1.0 if belt.size is Size.DIAMETER else 2.0
    one, two = belt.belt(size), belt.belt(2.0 * size)
    assert two.axial_stiffness == pytest.approx(section * one.axial_stiffness)
    assert two.mass_per_length == pytest.approx(section * one.mass_per_length)
    grip = belt.friction_stiffness(2.0 * size).typical / belt.friction_stiffness(size).typical
    assert grip == pytest.approx(contact)


@EVERY_BELT
@pytest.mark.parametrize("size", [0.0, -0.1, math.nan, math.inf])
def test_size_must_be_finite_and_positive(belt: BeltMaterial, size: float) -> None:
    for ask in (belt.belt, belt.friction_stiffness, belt.prior):
        with pytest.raises(DriveError, match="belt size"):
            ask(size)


@EVERY_BELT
def test_belt_is_fitted_within_what_it_stands(belt: BeltMaterial) -> None:
    assert belt.installed_strain.high <= belt.limits.strain


@EVERY_BELT
def test_fitted_belt_still_presses_on_the_pulley_at_speed(belt: BeltMaterial) -> None:
    speed = belt.limits.speed or 10.0  # conveyors are slower
    one = belt.belt(SIZES[belt.size])
    tension = one.axial_stiffness * belt.installed_strain.typical
    assert tension > one.mass_per_length * speed**2
    assert speed < one.critical_speed


@EVERY_BELT
def test_prior_is_one_that_the_estimator_takes(belt: BeltMaterial) -> None:
    suggestion = belt.prior(SIZES[belt.size])._asdict()
    allowed = {one.name: one.metadata for one in fields(Prior)}
    assert set(suggestion) <= set(allowed)
    for name, value in suggestion.items():
        assert allowed[name]["low"] <= value <= allowed[name]["high"], name
    assert 0.3 <= suggestion["friction_stiffness_decades"] <= 0.7
    assert suggestion["tension_stddev"] < suggestion["tension"]


def test_prior_multiplies_stiffness_by_strain() -> None:
    belt = belt_material("polyester-flat")
    prior = belt.prior(0.1)
    assert prior.tension == pytest.approx(1.2e6 * 0.1 * 0.006)
    spread = math.hypot(math.log(2.5e6 / 6e5), math.log(0.008 / 0.004)) / 4.0
    assert prior.tension_stddev == pytest.approx(spread * prior.tension)
    assert prior.friction_coefficient == 0.5
    assert prior.friction_coefficient_stddev == pytest.approx(0.1)


def test_k1_becomes_stiffness() -> None:
    assert stiffness_from_k1(7.0e3) == 7.0e5  # HAT-8P, 7 N/mm
    assert stiffness_from_k1(1.0) == per_width(1.0, 1.0, 0.01)
    with pytest.raises(DriveError, match="k1% is 0 N/m"):
        stiffness_from_k1(0.0)


@pytest.mark.parametrize(
    ("name", "published"),
    [
        ("polyamide-rubber", per_width(7.0, 1e-3, 0.01)),  # HAT-8P, static
        ("polyamide-rubber", per_width(2.4, 1e-3, 0.01)),  # relaxed
        ("polyester-fabric", per_width(9.5, 1e-3, 0.01)),  # Habasit F-5EXWT
        ("polyester-fabric", per_width(6.5, 1e-3, 0.01)),
        ("polyester-flat", per_width(130.0 / 2.0, 1e-2, 0.01)),  # Esband PU 4/6, axle load
        ("polyester-flat", per_width(290.0 / 2.0, 1e-2, 0.01)),  # PU 12
        ("polyurethane-elastic", per_width(8.0 / 2.0, 1e-2, 0.01)),  # PU elastic 13
        ("polyurethane-elastic", per_width((30.0 - 10.0) / 2.0, 1e-2, 0.08)),  # its slope
        ("polyurethane-elastic", 32.0 * 6894.76 * 100.0 * 2e-3),  # Dura-Belt 85A, 2 mm
        ("aramid-flat", per_width(1000.0 / 2.0, 1e-2, 0.011)),  # Esband PU 17
        ("aramid-flat", 60_700.0 * 4.44822 / 0.0254),  # Gates F8, lbf/in
        ("aramid-flat", 130_000.0 * 4.44822 / 0.0254),  # FX12
        ("steel-cord-flat", 109_000.0 * 4.44822 / 0.0254),  # F8
        ("steel-cord-flat", 334_600.0 * 4.44822 / 0.0254),  # FL12
        ("ep-conveyor", per_width(0.1 * 400.0, 1e-3, 0.04)),  # GB/T 7984, the softest allowed
        ("ep-conveyor", per_width(0.1 * 400.0, 1e-3, 0.02)),
        ("steel-belt", 28e6 * 6894.76 * 1e-3),  # Shigley, 1 mm
    ],
)
def test_stiffness_holds_what_catalogues_say(name: str, published: float) -> None:
    assert holds(BELTS[name].stiffness, published * (1.0 + 1e-9)) or holds(
        BELTS[name].stiffness, published * (1.0 - 1e-9)
    )


def test_round_belts_pull_as_catalogued_at_eight_percent() -> None:
    diameters = [2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 15, 18, 20]  # Megaweld PR 85 [mm]
    forces = [4.7, 10, 19, 29, 42, 57, 75, 95, 118, 170, 265, 381, 462]
    belt = belt_material("polyurethane-round")
    pulls = [0.08 * belt.axial_stiffness(1e-3 * d).typical for d in diameters]
    assert pulls == pytest.approx(forces, rel=0.08)


@pytest.mark.parametrize(
    ("name", "tension", "stiffness"),
    [("aramid-flat", 1081.0, 10_635.0), ("steel-cord-flat", 1939.0, 19_085.0)],
)
def test_allowed_strain_is_the_catalogued_tension(
    name: str, tension: float, stiffness: float
) -> None:
    strain = tension / 25.0 / stiffness  # N per 25 mm, N/mm
    assert BELTS[name].limits.strain == pytest.approx(strain, rel=0.03)


def test_shigley_polyamide_lies_within_the_preset() -> None:
    pounds_per_cubic_inch, inch, pound = 27_679.9, 0.0254, 4.44822
    belt = BELTS["polyamide-rubber"]
    assert holds(belt.mass, 0.042 * pounds_per_cubic_inch * 0.13 * inch)
    assert holds(belt.friction_coefficient(), 0.8)
    assert holds(belt.friction_coefficient(), 0.5)  # F-1
    allowed = 100.0 * pound / inch  # N/m
    assert allowed < belt.stiffness.typical * belt.limits.strain


def test_the_papers_belt_lies_within_flat_and_ribbed_presets() -> None:
    polyamide, ribbed = belt_material("polyamide-rubber"), belt_material("PK")
    width = 80_068.0 / polyamide.stiffness.typical
    assert holds(polyamide.friction_stiffness(width), 8.1e7)
    ribs = round(0.1036 / ribbed.mass.typical)
    assert ribs == 5
    assert holds(ribbed.axial_stiffness(ribs), 80_068.0)
    assert holds(ribbed.axial_stiffness(ribs), 170_000.0)  # Beikmann
    assert holds(ribbed.friction_stiffness(ribs), 8.1e7)
    assert holds(ribbed.equivalent_friction(), 1.2)


@pytest.mark.parametrize("belt", ["v-belt-a", "v-belt-spb"])
def test_v_belt_grips_between_design_value_and_observation(belt: str) -> None:
    grip = BELTS[belt].equivalent_friction(datum_diameter=0.15)
    assert holds(grip, 0.5123)
    assert holds(grip, 1.0)


def test_friction_of_an_unknown_pair_lists_the_known_ones() -> None:
    belt = belt_material("polyamide-rubber")
    with pytest.raises(DriveError, match=r"polyamide-rubber on ceramic, wet; there are steel dry"):
        belt.friction_coefficient("ceramic", SurfaceState.WET)
    with pytest.raises(DriveError, match="no pulley surface is called 'teflon'") as refusal:
        belt.friction_coefficient("teflon")
    assert all(name in str(refusal.value) for name in LAGGINGS)


@pytest.mark.parametrize("lagging", sorted({name for name, _ in RUBBER_COVER}))
def test_water_and_dirt_take_grip_away(lagging: str) -> None:
    dry, wet, dirty = (RUBBER_COVER[lagging, state].typical for state in SurfaceState)
    assert dry > wet > dirty


def test_grooves_and_ceramic_keep_grip_when_wet() -> None:
    wet = {name: mu.typical for (name, state), mu in RUBBER_COVER.items() if state.value == "wet"}
    assert wet["steel"] < wet["rubber"] < wet["rubber-diamond"] <= wet["ceramic"]


def test_lagging_is_a_spring_in_series_with_the_cover() -> None:
    belt = belt_material("ep-conveyor")
    bare, lagged = belt.friction_stiffness(0.8), belt.friction_stiffness(0.8, "rubber-diamond")
    soft = LAGGINGS["rubber-diamond"].contact_stiffness
    assert soft is not None
    for bound in ("low", "typical", "high"):
        compliance = 1.0 / getattr(bare, bound) + 1.0 / (0.8 * getattr(soft, bound))
        assert getattr(lagged, bound) == pytest.approx(1.0 / compliance)
    assert belt.friction_stiffness(0.8, "steel") == bare


@given(
    low=st.floats(1e-6, 1e6),
    up=st.floats(1.001, 1e3),
    more=st.floats(1.0, 1e3),
    factor=st.floats(1e-3, 1e3),
)
@settings(derandomize=True, deadline=None)
def test_scaling_a_range_scales_its_spread(
    low: float, up: float, more: float, factor: float
) -> None:
    one = Range(low, low * up, low * up * more, "-", SOURCES[:1])
    other = one.scaled(factor, "N")
    assert other.decades == pytest.approx(one.decades)
    assert other.stddev == pytest.approx(factor * one.stddev)
    assert (other.unit, other.sources) == ("N", one.sources)
    assert 10.0 ** (4.0 * one.decades) == pytest.approx(one.high / one.low)
    assert one.relative_stddev == pytest.approx(math.log(one.high / one.low) / 4.0)


@pytest.mark.parametrize(
    ("low", "typical", "high"),
    [(2, 1, 3), (1, 4, 3), (1, 1, 1), (0, 1, 2), (-1, 1, 2), (1, 2, math.inf), (1, math.nan, 2)],
)
def test_range_must_rise(low: float, typical: float, high: float) -> None:
    with pytest.raises(DriveError, match="it must rise from low over typical to high"):
        Range(low, typical, high, "N", SOURCES[:1])


def test_range_without_a_source_is_refused() -> None:
    with pytest.raises(DriveError, match="names no source"):
        Range(1.0, 2.0, 3.0, "N", ())


def test_one_unseen_source_makes_a_range_unverified() -> None:
    seen = next(source for source in SOURCES if source.verified)
    unseen = next(source for source in SOURCES if not source.verified)
    assert Range(1.0, 2.0, 3.0, "N", (seen,)).verified
    assert not Range(1.0, 2.0, 3.0, "N", (seen, unseen)).verified
