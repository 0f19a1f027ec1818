"""Presets of V-belts and V-ribbed belts, one for each standard section."""

from collections.abc import Mapping
from types import MappingProxyType

from belt_ros.mechanics.materials import sources as said
from belt_ros.mechanics.materials.belt_material import BeltMaterial, ServiceLimits, Size
from belt_ros.mechanics.materials.lagging import SurfaceState, friction
from belt_ros.mechanics.materials.ranges import Range
from belt_ros.mechanics.materials.wedge import V_BELTS, V_RIBS, WedgeSection

_DRY, _WET = SurfaceState.DRY, SurfaceState.WET

# On the flanks. The lower bound is the design value of the equivalent friction, 0.5123, times
# sin(17 deg); the wet figures are the dry ones less the 30 to 40 % that was measured.
_FLANKS: Mapping[tuple[str, SurfaceState], Range] = MappingProxyType(
    {
        (metal, state): friction(*figures, said.V_EFFECTIVE, *more)
        for metal in ("steel", "cast-iron")
        for state, figures, more in (
            (_DRY, (0.14, 0.35, 0.55), ()),
            (_WET, (0.09, 0.23, 0.36), (said.WET_RIBS,)),
        )
    }
)


def _grooved(
    section: WedgeSection, name: str, title: str, size: Size, limits: ServiceLimits
) -> BeltMaterial:
    return BeltMaterial(
        name=name,
        title=title,
        size=size,
        stiffness=section.stiffness,
        mass=section.mass,
        contact_stiffness=section.friction_stiffness,
        friction=_FLANKS,
        installed_strain=Range(0.002, 0.005, 0.01, "-", (said.CATALOGUES,)),
        limits=limits,
        groove=section,
    )


_V_LIMITS = ServiceLimits(0.015, -20.0, 70.0, None, (said.WEDGE_LIMITS, said.CATALOGUES))
_SK_LIMITS = ServiceLimits(
    0.015, -20.0, 70.0, 42.0, (said.OPTIBELT, said.WEDGE_LIMITS, said.CATALOGUES)
)
_RIB_LIMITS = ServiceLimits(0.01, -18.0, 100.0, 50.0, (said.PIX, said.CATALOGUES))

GROOVED_BELTS: tuple[BeltMaterial, ...] = (
    *(
        _grooved(
            section,
            f"v-belt-{section.name.lower()}",
            f"wrapped V-belt of section {section.name}, polyester cords",
            Size.BELTS,
            _SK_LIMITS if section.name.startswith("SP") else _V_LIMITS,
        )
        for section in V_BELTS.values()
    ),
    *(
        _grooved(
            section,
            f"v-ribbed-{section.name.lower()}",
            f"V-ribbed belt of section {section.name}, polyester cords",
            Size.RIBS,
            _RIB_LIMITS,
        )
        for section in V_RIBS.values()
    ),
)
