"""The presets as tables of text: for `docs/materials.md`, whose tables a test holds to these.

Figures are written low / typical / high; a star marks those of which not every source was seen in
print.
"""

import math
import re
from collections.abc import Iterable
from typing import NamedTuple

from belt_ros.mechanics.materials.belt_material import BeltMaterial, Size
from belt_ros.mechanics.materials.catalogue import BELTS
from belt_ros.mechanics.materials.lagging import LAGGINGS
from belt_ros.mechanics.materials.ranges import Range, Source
from belt_ros.mechanics.materials.sources import SOURCES
from belt_ros.mechanics.materials.wedge import V_BELTS, V_RIBS, WedgeSection, wedge_factor


class Table(NamedTuple):
    """A table of text."""

    name: str
    header: tuple[str, ...]
    rows: list[tuple[str, ...]]


def tables() -> tuple[Table, ...]:
    """Return all tables: belts, limits, friction, laggings, sections, evidence and sources."""
    belts = BELTS.values()
    return (
        Table(
            "belts",
            ("belt", "EA", "mass", "fitted strain [%]", "kf", "stretch length [mm]"),
            [_belt_row(belt) for belt in belts],
        ),
        Table(
            "limits",
            ("belt", "what it is", "strain up to [%]", "temperature [degC]", "speed up to [m/s]"),
            [_limits_row(belt) for belt in belts],
        ),
        Table("friction", ("belt", "pulley", "state", "mu"), list(_friction_rows(belts))),
        Table("laggings", ("pulley", "what it is", "kf of the lagging"), _lagging_rows()),
        Table(
            "sections",
            ("section", "width [mm]", "least diameter [mm]", "groove [deg]", "wedge factor"),
            [_section_row(one) for one in (*V_BELTS.values(), *V_RIBS.values())],
        ),
        Table(
            "evidence",
            ("belt", "EA", "mass", "fitted strain", "kf", "limits"),
            [_evidence_row(belt) for belt in belts],
        ),
        Table(
            "sources",
            ("key", "consulted", "source"),
            [(one.key, one.evidence.value, one.title) for one in SOURCES],
        ),
    )


def markdown(table: Table) -> str:
    """Return `table` in Markdown."""
    lines = [table.header, tuple("---" for _ in table.header), *table.rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def with_tables(document: str) -> str:
    """Return `document` with the text between `<!-- table: name -->` and `<!-- end -->` renewed."""
    for table in tables():
        start = f"<!-- table: {table.name} -->"
        before, found, after = document.partition(start)
        if found:
            _, end, rest = after.partition("<!-- end -->")
            document = f"{before}{start}\n\n{markdown(table)}\n\n{end}{rest}"
    return document


def _number(value: float) -> str:
    """Return `value` with three digits, without a padded exponent."""
    return re.sub(r"e([+-])0*(\d)", r"e\1\2", f"{value:.3g}").replace("e+", "e")


def _figure(one: Range, factor: float = 1.0, unit: str = "") -> str:
    text = " / ".join(_number(factor * value) for value in (one.low, one.typical, one.high))
    return f"{text} {unit}".rstrip() + ("" if one.verified else " *")


def _belt_row(belt: BeltMaterial) -> tuple[str, ...]:
    per = {Size.RIBS: " a rib", Size.BELTS: " a belt"}.get(belt.size, "")
    stretch = "-"
    if belt.size is not Size.DIAMETER:
        ratio = belt.stiffness.typical / belt.contact_stiffness.typical
        stretch = _number(1e3 * math.sqrt(ratio))
    return (
        belt.name,
        _figure(belt.stiffness, unit=belt.stiffness.unit + per),
        _figure(belt.mass, unit=belt.mass.unit + per),
        _figure(belt.installed_strain, 100.0),
        _figure(belt.contact_stiffness, unit=belt.contact_stiffness.unit + per),
        stretch,
    )


def _limits_row(belt: BeltMaterial) -> tuple[str, ...]:
    limits = belt.limits
    warm = "-" if limits.coldest is None else f"{limits.coldest:g} to {limits.hottest:g}"
    speed = "-" if limits.speed is None else f"{limits.speed:g}"
    return belt.name, belt.title, _number(100.0 * limits.strain), warm, speed


def _friction_rows(belts: Iterable[BeltMaterial]) -> Iterable[tuple[str, ...]]:
    """Yield friction, once for belts that share it."""
    shared: dict[int, list[BeltMaterial]] = {}
    for belt in belts:
        shared.setdefault(id(belt.friction), []).append(belt)
    for same in shared.values():
        grooved = same[0].groove is not None
        who = "V-belts and V-ribbed belts, flanks" if grooved else ", ".join(b.name for b in same)
        for (pulley, state), mu in same[0].friction.items():
            yield who, pulley, state.value, f"{_figure(mu)} [{_keys(mu.sources)}]"


def _lagging_rows() -> list[tuple[str, ...]]:
    return [
        (
            one.name,
            one.title,
            "rigid" if one.contact_stiffness is None else _figure(one.contact_stiffness, 1, "N/m3"),
        )
        for one in LAGGINGS.values()
    ]


def _section_row(section: WedgeSection) -> tuple[str, ...]:
    grooves, factors, above = [], [], 0.0
    for limit, angle in section.grooves:
        where = "" if len(section.grooves) == 1 else f" above {1e3 * above:g} mm"
        where = f" up to {1e3 * limit:g} mm" if math.isfinite(limit) else where
        grooves.append(f"{math.degrees(angle):.0f}{where}")
        factors.append(f"{wedge_factor(angle):.2f}")
        above = limit
    return (
        section.name,
        _number(1e3 * section.width),
        _number(1e3 * section.smallest_diameter),
        f"{', '.join(grooves)} [{section.groove_source.key}]",
        ", ".join(factors),
    )


def _evidence_row(belt: BeltMaterial) -> tuple[str, ...]:
    figures = (belt.stiffness, belt.mass, belt.installed_strain, belt.contact_stiffness)
    return (belt.name, *(_keys(one.sources) for one in figures), _keys(belt.limits.sources))


def _keys(sources: Iterable[Source]) -> str:
    return ", ".join(source.key for source in sources)
