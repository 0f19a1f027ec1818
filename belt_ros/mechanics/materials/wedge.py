"""What makes a V-belt or a V-ribbed belt an equivalent flat one.

A belt in a groove of angle beta, pressed inwards by n [N/m], rests on two flanks, each with
n_side = n / (2 sin(beta/2)). Friction along the belt is mu n_side on each flank,

    2 mu n_side = mu n / sin(beta/2) = mu_equivalent n

so the flat-belt theory holds with mu/sin(beta/2) in place of mu. The friction spring of Eq. 1 works
along the belt on both flanks and takes no such factor: it is the shear of the rubber between cords
and flanks.

While the belt is still being drawn into the groove, friction points outwards as well and carries
a part: n = 2 n_side (sin(beta/2) + mu cos(beta/2)). So the wedge factor lies between
1/(sin(beta/2) + mu cos(beta/2)), wedging, and 1/sin(beta/2), seated. What slides along the belt
cannot also hold the belt out of the groove: at gross slip the seated value applies.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from belt_ros.mechanics.drive import DriveError, require_positive
from belt_ros.mechanics.materials.ranges import Range, Source
from belt_ros.mechanics.materials.sources import (
    BEIKMANN,
    CONTITECH,
    CORD,
    ESTIMATE,
    KIM_LEAMY_FERRI,
    OPTIBELT,
    RUBBER,
    SHEAR,
    V_RIBBED_STANDARD,
)

_DEGREE = math.pi / 180.0


def wedge_factor(groove_angle: float) -> float:
    """Flank friction over flat friction of a belt seated in its groove, 1/sin(beta/2) [-].

    Parameters
    ----------
    groove_angle : float
        beta [rad], the full angle between the flanks; pi is a flat pulley.

    Raises
    ------
    DriveError
        Outside (0, pi].
    """
    if not 0.0 < groove_angle <= math.pi:
        raise DriveError(
            f"groove angle is {groove_angle:g} rad; it must be > 0 and at most pi (flat). "
            "Give radians: 38 deg is 0.663 rad"
        )
    return 1.0 / math.sin(groove_angle / 2.0)


def wedging_factor(groove_angle: float, friction_coefficient: float) -> float:
    """Return the factor [-] of a belt being drawn inwards, 1/(sin(beta/2) + mu cos(beta/2)).

    It is the least that the factor can be. `groove_angle` as in `wedge_factor`.
    """
    require_positive(friction_coefficient, "friction coefficient mu")
    return 1.0 / (
        1.0 / wedge_factor(groove_angle) + friction_coefficient * math.cos(groove_angle / 2.0)
    )


def equivalent_friction(friction_coefficient: float, groove_angle: float) -> float:
    """Friction coefficient [-] of the flat belt that grips as this one does in its groove."""
    require_positive(friction_coefficient, "friction coefficient mu")
    return friction_coefficient * wedge_factor(groove_angle)


def flank_force(normal_force: float, groove_angle: float) -> float:
    """Force on one flank per length [N/m] under `normal_force` n = T/R per length [N/m]."""
    return 0.5 * normal_force * wedge_factor(groove_angle)


def sticks_in_groove(groove_angle: float, friction_coefficient: float) -> bool:
    """Whether the belt must be pulled out of the groove: tan(beta/2) < mu.

    True of a dry rubber V-belt (tan 17 deg is 0.31). Such a belt leaves the pulley late, and its
    friction at the end of the arc points inwards; the flat-belt theory leaves both out.
    """
    wedge_factor(groove_angle)
    return math.tan(groove_angle / 2.0) < friction_coefficient


def flank_friction_stiffness(
    shear_modulus: float, flank_height: float, shear_depth: float, flanks: int = 2
) -> float:
    """Friction stiffness kf [N/m2] of a belt held by its flanks.

    Parameters
    ----------
    shear_modulus : float
        G of the rubber [Pa].
    flank_height : float
        Height of the flank in contact, along the flank [m].
    shear_depth : float
        Mean distance from flank to cords [m].
    flanks : int
        Flanks in contact: two a belt, two a rib.
    """
    require_positive(shear_modulus, "shear modulus G", "Pa")
    require_positive(flank_height, "flank height", "m")
    require_positive(shear_depth, "shear depth", "m")
    return flanks * shear_modulus * flank_height / shear_depth


@dataclass(frozen=True)
class WedgeSection:
    """A standard section of V-belt, or one rib of a V-ribbed belt.

    Parameters
    ----------
    name : str
        Its designation.
    width : float
        Datum width of a V-belt, rib pitch of a V-ribbed belt [m].
    stiffness : Range
        EA [N] of one belt or rib.
    mass : Range
        [kg/m] of one belt or rib.
    friction_stiffness : Range
        kf [N/m2] of one belt or rib.
    grooves : tuple of (float, float)
        Rising greatest datum diameters [m] and the groove angle [rad] up to each.
    smallest_diameter : float
        Smallest recommended datum diameter [m].
    groove_source : Source
        Of the angles and of the smallest diameter.
    """

    name: str
    width: float
    stiffness: Range
    mass: Range
    friction_stiffness: Range
    grooves: tuple[tuple[float, float], ...]
    smallest_diameter: float
    groove_source: Source

    def groove_angle(self, datum_diameter: float) -> float:
        """Return the standard groove angle [rad] of a pulley of `datum_diameter` [m].

        Small pulleys have the sharper groove, because bending widens the belt's foot. Infinity
        asks for that of a large pulley.

        Raises
        ------
        DriveError
            If the pulley is smaller than the section allows.
        """
        if not datum_diameter >= self.smallest_diameter:
            raise DriveError(
                f"datum diameter is {datum_diameter:g} m; section {self.name} bends over "
                f"{self.smallest_diameter:g} m at least. Take a smaller section"
            )
        return next(angle for limit, angle in self.grooves if datum_diameter <= limit)


def _flanks(flank_height: float, shear_depth: float) -> Range:
    """Friction stiffness of two flanks, widened as in `contact_layer`."""
    typical = flank_friction_stiffness(2e6, flank_height, shear_depth)
    return Range(typical / 6.0, typical, typical * 6.0, "N/m2", (SHEAR, RUBBER, ESTIMATE))


def _v_belt(
    name: str,
    datum_width: float,
    height: float,
    cord: float,
    mass: float,
    sharp_up_to: float,
    smallest: float,
    source: Source,
) -> WedgeSection:
    """Return a V-belt section; lengths in mm, mass in kg/m."""
    stiffness = 8e9 * 0.65 * datum_width * cord * 1e-6
    return WedgeSection(
        name=name,
        width=datum_width * 1e-3,
        stiffness=Range(0.5 * stiffness, stiffness, 2.0 * stiffness, "N", (CORD,)),
        mass=Range(0.9 * mass, mass, 1.1 * mass, "kg/m", (source,)),
        friction_stiffness=_flanks(height * 1e-3, 0.25e-3 * datum_width),
        grooves=((sharp_up_to * 1e-3, 34.0 * _DEGREE), (math.inf, 38.0 * _DEGREE)),
        smallest_diameter=smallest * 1e-3,
        groove_source=OPTIBELT,
    )


def _rib(
    name: str,
    pitch: float,
    height: float,
    stiffness: float,
    mass: float,
    smallest: float,
    *sources: Source,
) -> WedgeSection:
    """Return one rib of a V-ribbed belt; lengths in mm, stiffness in N, mass in kg/m."""
    flank = 0.5 * pitch / math.cos(20.0 * _DEGREE)
    return WedgeSection(
        name=name,
        width=pitch * 1e-3,
        stiffness=Range(0.5 * stiffness, stiffness, 2.0 * stiffness, "N", sources),
        mass=Range(0.9 * mass, mass, 1.1 * mass, "kg/m", (CONTITECH,)),
        friction_stiffness=_flanks(flank * 1e-3, 0.5e-3 * height),
        grooves=((math.inf, 40.0 * _DEGREE),),
        smallest_diameter=smallest * 1e-3,
        groove_source=V_RIBBED_STANDARD,
    )


# Datum width, height and cord [mm], mass [kg/m], greatest diameter of the 34 deg groove, smallest
# pulley [mm].
V_BELTS: Mapping[str, WedgeSection] = MappingProxyType(
    {
        section.name: section
        for section in (
            _v_belt("SPZ", 8.5, 8.0, 1.0, 0.074, 80.0, 63.0, OPTIBELT),
            _v_belt("SPA", 11.0, 10.0, 1.1, 0.123, 118.0, 90.0, OPTIBELT),
            _v_belt("SPB", 14.0, 13.0, 1.5, 0.195, 190.0, 140.0, OPTIBELT),
            _v_belt("SPC", 19.0, 18.0, 2.0, 0.377, 315.0, 224.0, OPTIBELT),
            _v_belt("Z", 8.5, 6.0, 0.9, 0.060, 80.0, 50.0, CONTITECH),
            _v_belt("A", 11.0, 8.0, 1.0, 0.105, 118.0, 71.0, CONTITECH),
            _v_belt("B", 14.0, 11.0, 1.2, 0.170, 190.0, 112.0, CONTITECH),
            _v_belt("C", 19.0, 14.0, 1.6, 0.300, 315.0, 180.0, CONTITECH),
        )
    }
)

# Rib pitch and belt height [mm], EA [N] and mass [kg/m] of a rib, smallest pulley [mm].
V_RIBS: Mapping[str, WedgeSection] = MappingProxyType(
    {
        section.name: section
        for section in (
            _rib("PJ", 2.34, 3.8, 9e3, 0.009, 20.0, CORD),
            _rib("PK", 3.56, 5.0, 2.2e4, 0.021, 45.0, CORD, KIM_LEAMY_FERRI, BEIKMANN),
            _rib("PL", 4.70, 9.0, 4e4, 0.040, 75.0, CORD),
            _rib("PM", 9.40, 14.5, 1.2e5, 0.120, 180.0, CORD),
        )
    }
)
