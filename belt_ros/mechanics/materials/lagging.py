"""What the belt runs on: bare and lagged pulleys, and the friction of rubber belts on them."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

from belt_ros.mechanics.drive import DriveError
from belt_ros.mechanics.materials.contact_layer import shear_layer
from belt_ros.mechanics.materials.ranges import Range, Source
from belt_ros.mechanics.materials.sources import (
    BULK_ONLINE,
    DIN_22101,
    DIN_22101_QUOTED,
    DRIVE_FACTORS,
    ESTIMATE,
    RUBBER,
)


class SurfaceState(Enum):
    """What lies between belt and pulley."""

    DRY = "dry"
    WET = "wet"  # clean water
    DIRTY = "dirty"  # wet clay, loam, slime


@dataclass(frozen=True)
class Lagging:
    """A pulley surface.

    Parameters
    ----------
    name, title : str
        What a user writes, and what it means.
    contact_stiffness : Range or None
        Shear stiffness of the lagging per width [N/m3]; None where it is rigid beside a belt.
    """

    name: str
    title: str
    contact_stiffness: Range | None = None


def friction(low: float, typical: float, high: float, *sources: Source) -> Range:
    """Return a friction coefficient [-]."""
    return Range(low, typical, high, "-", sources)


def _modulus(low: float, typical: float, high: float, *sources: Source) -> Range:
    return Range(low, typical, high, "Pa", sources)


def _thickness(low: float, typical: float, high: float, *sources: Source) -> Range:
    return Range(low, typical, high, "m", sources)


_RUBBER_LAGGING = shear_layer(
    _modulus(0.7e6, 1.3e6, 2.0e6, RUBBER), _thickness(6e-3, 10e-3, 20e-3, ESTIMATE)
)
_POLYURETHANE_LAGGING = shear_layer(
    _modulus(2e6, 5e6, 1.2e7, ESTIMATE), _thickness(3e-3, 8e-3, 15e-3, ESTIMATE)
)

LAGGINGS: Mapping[str, Lagging] = MappingProxyType(
    {
        lagging.name: lagging
        for lagging in (
            Lagging("steel", "bare steel"),
            Lagging("stainless", "bare stainless steel"),
            Lagging("cast-iron", "bare cast iron"),
            Lagging("aluminium", "bare aluminium"),
            Lagging("anodised", "anodised aluminium"),
            Lagging("rubber", "plain rubber lagging", _RUBBER_LAGGING),
            Lagging("rubber-diamond", "diamond or herringbone grooved rubber", _RUBBER_LAGGING),
            Lagging("ceramic", "ceramic tiles in rubber", _RUBBER_LAGGING),
            Lagging("polyurethane", "grooved polyurethane lagging", _POLYURETHANE_LAGGING),
        )
    }
)

_DRY, _WET, _DIRTY = SurfaceState

# Conveyor belts with rubber covers. Design standards choose low values on purpose; measured ones
# are higher, so typical lies at the standards' upper end.
RUBBER_COVER: Mapping[tuple[str, SurfaceState], Range] = MappingProxyType(
    {
        ("steel", _DRY): friction(0.25, 0.35, 0.40, DRIVE_FACTORS, DIN_22101),
        ("steel", _WET): friction(0.05, 0.10, 0.20, BULK_ONLINE, DRIVE_FACTORS),
        ("steel", _DIRTY): friction(0.05, 0.07, 0.10, DIN_22101),
        ("rubber", _DRY): friction(0.35, 0.40, 0.60, DRIVE_FACTORS),
        ("rubber", _WET): friction(0.20, 0.25, 0.35, DRIVE_FACTORS),
        ("rubber", _DIRTY): friction(0.20, 0.22, 0.30, DRIVE_FACTORS),
        ("rubber-diamond", _DRY): friction(0.35, 0.42, 0.60, DRIVE_FACTORS, BULK_ONLINE),
        ("rubber-diamond", _WET): friction(0.30, 0.35, 0.40, DRIVE_FACTORS, BULK_ONLINE),
        ("rubber-diamond", _DIRTY): friction(0.25, 0.28, 0.35, DRIVE_FACTORS, BULK_ONLINE),
        ("ceramic", _DRY): friction(0.40, 0.45, 0.80, DIN_22101_QUOTED, DRIVE_FACTORS),
        ("ceramic", _WET): friction(0.35, 0.38, 0.50, DIN_22101_QUOTED, BULK_ONLINE),
        ("ceramic", _DIRTY): friction(0.30, 0.35, 0.38, BULK_ONLINE),
        ("polyurethane", _DRY): friction(0.30, 0.37, 0.40, DIN_22101),
        ("polyurethane", _WET): friction(0.25, 0.35, 0.38, DIN_22101),
        ("polyurethane", _DIRTY): friction(0.15, 0.20, 0.25, DIN_22101),
    }
)


def lagging_named(name: str) -> Lagging:
    """Return the lagging called `name`.

    Raises
    ------
    DriveError
        If there is none; the message lists the names.
    """
    found = LAGGINGS.get(name.strip().lower().replace("_", "-").replace(" ", "-"))
    if found is None:
        raise DriveError(f"no pulley surface is called {name!r}; choose from {', '.join(LAGGINGS)}")
    return found
