"""Presets of flat and round belts."""

from collections.abc import Mapping
from types import MappingProxyType

from belt_ros.mechanics.materials import sources as said
from belt_ros.mechanics.materials.belt_material import BeltMaterial, ServiceLimits, Size
from belt_ros.mechanics.materials.contact_layer import shear_layer
from belt_ros.mechanics.materials.lagging import RUBBER_COVER, SurfaceState, friction
from belt_ros.mechanics.materials.ranges import Range, Source

_DRY = SurfaceState.DRY

Figures = tuple[float, float, float]
Friction = Mapping[tuple[str, SurfaceState], Range]


def _of(unit: str, figures: Figures, *sources: Source) -> Range:
    return Range(*figures, unit, sources)


def _layer(modulus: Figures, thickness: Figures, *sources: Source) -> Range:
    """Contact stiffness of a cover: G [Pa], of the sources given; t [m], estimated."""
    return shear_layer(_of("Pa", modulus, *sources), _of("m", thickness, said.ESTIMATE))


_URETHANE: Friction = MappingProxyType(
    {
        ("steel", _DRY): friction(0.30, 0.50, 0.70, said.ESBAND, said.GATES_FLAT, said.ELATECH),
        ("stainless", _DRY): friction(0.20, 0.30, 0.40, said.ESBAND),
        ("cast-iron", _DRY): friction(0.30, 0.40, 0.50, said.ESBAND),
        ("aluminium", _DRY): friction(0.30, 0.50, 0.60, said.ESBAND, said.GATES_FLAT),
        ("anodised", _DRY): friction(0.70, 0.80, 0.90, said.ESBAND),
        ("rubber", _DRY): friction(0.40, 0.60, 0.90, said.ESTIMATE),
    }
)
_URETHANE_COVER = _layer((2e6, 7e6, 1.4e7), (0.4e-3, 0.6e-3, 1.0e-3), said.DURABELT)

_POLYAMIDE = BeltMaterial(
    name="polyamide-rubber",
    title="flat power-transmission belt, polyamide tension member, rubber (NBR) friction cover",
    size=Size.WIDTH,
    stiffness=_of("N/m", (2.4e5, 8e5, 3e6), said.HABASIT_HAT8P, said.CATALOGUES),
    mass=_of("kg/m2", (1.3, 2.4, 3.9), said.HABASIT_A1, said.HABASIT_HAT8P, said.SHIGLEY_FLAT),
    contact_stiffness=_layer((1e6, 1.6e6, 3e6), (0.3e-3, 0.6e-3, 1.2e-3), said.RUBBER),
    friction=MappingProxyType(
        {("steel", _DRY): friction(0.30, 0.55, 0.80, said.BELT_CONTACT, said.SHIGLEY_FLAT)}
    ),
    installed_strain=_of("-", (0.015, 0.02, 0.03), said.CATALOGUES),
    limits=ServiceLimits(0.03, -20.0, 80.0, 70.0, (said.SIEGLING, said.NITTA, said.CATALOGUES)),
)
_POLYESTER = BeltMaterial(
    name="polyester-flat",
    title="flat power-transmission belt, endless polyester cord or fabric, polyurethane cover",
    size=Size.WIDTH,
    stiffness=_of("N/m", (6e5, 1.2e6, 2.5e6), said.ESBAND, said.CATALOGUES),
    mass=_of("kg/m2", (0.8, 1.5, 3.0), said.ESTIMATE),
    contact_stiffness=_layer((0.7e6, 1e6, 2e6), (0.2e-3, 0.5e-3, 1.0e-3), said.RUBBER),
    friction=_URETHANE,
    installed_strain=_of("-", (0.004, 0.006, 0.008), said.ESBAND),
    limits=ServiceLimits(0.015, -10.0, 60.0, None, (said.ESBAND, said.CATALOGUES)),
)
_ARAMID = BeltMaterial(
    name="aramid-flat",
    title="flat belt, aramid cords, polyurethane cover",
    size=Size.WIDTH,
    stiffness=_of("N/m", (4.5e6, 1.06e7, 2.3e7), said.ESBAND, said.GATES_FLAT),
    mass=_of("kg/m2", (2.5, 3.0, 3.9), said.GATES_FLAT),
    contact_stiffness=_URETHANE_COVER,
    friction=_URETHANE,
    installed_strain=_of("-", (0.001, 0.002, 0.003), said.ESBAND),
    limits=ServiceLimits(0.004, -5.0, 70.0, None, (said.GATES_FLAT,)),
)
_STEEL_CORD = BeltMaterial(
    name="steel-cord-flat",
    title="flat belt, steel cords, polyurethane cover",
    size=Size.WIDTH,
    stiffness=_of("N/m", (1.9e7, 1.91e7, 5.9e7), said.GATES_FLAT),
    mass=_of("kg/m2", (3.3, 4.3, 6.6), said.GATES_FLAT),
    contact_stiffness=_URETHANE_COVER,
    friction=_URETHANE,
    installed_strain=_of("-", (0.0005, 0.001, 0.002), said.CATALOGUES),
    limits=ServiceLimits(0.004, -5.0, 70.0, None, (said.GATES_FLAT,)),
)
_ELASTIC = BeltMaterial(
    name="polyurethane-elastic",
    title="elastic conveyor belt, polyurethane without fabric or with rubber cords, 1 to 3 mm",
    size=Size.WIDTH,
    stiffness=_of("N/m", (1.2e4, 4e4, 9e4), said.ESBAND, said.DURABELT),
    mass=_of("kg/m2", (1.2, 2.4, 3.6), said.TPU_DENSITY),
    contact_stiffness=_layer((1e6, 7e6, 1.4e7), (0.5e-3, 1.0e-3, 1.5e-3), said.DURABELT),
    friction=_URETHANE,
    installed_strain=_of("-", (0.04, 0.06, 0.08), said.ESBAND),
    limits=ServiceLimits(0.10, -10.0, 60.0, None, (said.ESBAND, said.DURABELT)),
)
_ROUND = BeltMaterial(
    name="polyurethane-round",
    title="round elastic belt, polyurethane 83 to 90 Shore A",
    size=Size.DIAMETER,
    stiffness=_of("Pa", (1.6e7, 1.9e7, 3.1e7), said.MEGAWELD, said.DURABELT),
    mass=_of("kg/m3", (1170.0, 1180.0, 1220.0), said.TPU_DENSITY),
    contact_stiffness=_of("N/m2", (2e6, 1e7, 5e7), said.SHEAR, said.DURABELT),
    friction=MappingProxyType(
        {
            ("steel", _DRY): friction(0.30, 0.45, 0.55, said.DURABELT),
            ("aluminium", _DRY): friction(0.45, 0.55, 0.62, said.DURABELT),
        }
    ),
    installed_strain=_of("-", (0.05, 0.08, 0.10), said.DURABELT, said.MEGAWELD),
    limits=ServiceLimits(0.10, -20.0, 50.0, None, (said.DURABELT,)),
)
_LIGHT_FABRIC = BeltMaterial(
    name="polyester-fabric",
    title="light conveyor belt, polyester fabric (1 to 3 plies), bare or impregnated running side",
    size=Size.WIDTH,
    stiffness=_of("N/m", (6.5e5, 9.5e5, 2e6), said.HABASIT_F5, said.CATALOGUES),
    mass=_of("kg/m2", (1.3, 2.5, 4.5), said.HABASIT_F5, said.CATALOGUES),
    contact_stiffness=_of("N/m3", (3e8, 3e9, 3e10), said.ESTIMATE),
    friction=MappingProxyType(
        {
            ("steel", _DRY): friction(0.10, 0.20, 0.30, said.HABASIT_F5, said.ESBAND),
            ("rubber", _DRY): friction(0.25, 0.35, 0.50, said.ESTIMATE),
        }
    ),
    installed_strain=_of("-", (0.002, 0.004, 0.006), said.CATALOGUES),
    limits=ServiceLimits(0.01, -30.0, 80.0, None, (said.HABASIT_F5, said.CATALOGUES)),
)
_EP = BeltMaterial(
    name="ep-conveyor",
    title="heavy conveyor belt, EP (polyester-polyamide) fabric of class 400/3, rubber covers 4+2",
    size=Size.WIDTH,
    stiffness=_of("N/m", (1e6, 2.5e6, 4e6), said.GB_7984, said.CATALOGUES),
    mass=_of("kg/m2", (9.0, 11.0, 13.0), said.EP_MASS, said.ESTIMATE),
    contact_stiffness=_layer((0.7e6, 1e6, 2e6), (1e-3, 2e-3, 4e-3), said.RUBBER),
    friction=RUBBER_COVER,
    installed_strain=_of("-", (0.002, 0.005, 0.010), said.CATALOGUES),
    limits=ServiceLimits(0.02, None, None, None, (said.GB_7984,)),
)
_STEEL = BeltMaterial(
    name="steel-belt",
    title="stainless steel belt, 0.8 to 1.2 mm",
    size=Size.WIDTH,
    stiffness=_of("N/m", (1.5e8, 1.93e8, 2.4e8), said.SHIGLEY_METAL, said.ESTIMATE),
    mass=_of("kg/m2", (6.2, 7.8, 9.5), said.ESTIMATE),
    contact_stiffness=_of("N/m3", (1e9, 1e10, 1e11), said.ESTIMATE),
    friction=MappingProxyType(
        {("steel", _DRY): friction(0.12, 0.25, 0.35, said.LUST, said.SHIGLEY_METAL)}
    ),
    installed_strain=_of("-", (5e-5, 1e-4, 3e-4), said.CATALOGUES),
    limits=ServiceLimits(1e-3, None, None, None, (said.ESTIMATE,)),
)

FLAT_BELTS: tuple[BeltMaterial, ...] = (
    _POLYAMIDE,
    _POLYESTER,
    _ARAMID,
    _STEEL_CORD,
    _ELASTIC,
    _ROUND,
    _LIGHT_FABRIC,
    _EP,
    _STEEL,
)
