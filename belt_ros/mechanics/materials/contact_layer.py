"""Friction stiffness from the shear of what lies between tension member and pulley.

Nobody publishes kf, the stiffness of the friction spring of Eq. 1. Firbank (1970) showed what it
is on belts with stiff tension members: the shear of the soft layer. A layer of shear modulus G and
thickness t, over a width b, gives kf = b G/t; layers in series (belt cover, pulley lagging) add
their compliances t/G.
"""

from belt_ros.mechanics.materials.ranges import Range, all_sources
from belt_ros.mechanics.materials.sources import SHEAR

# A third of the apparent area touches, so a cover may grip a third as stiffly; and filled rubber
# is up to some three times stiffer at the rate and strain of creep than in a slow test.
_MODEL_FACTOR = 3.0


def shear_layer(shear_modulus: Range, thickness: Range) -> Range:
    """Friction stiffness per width of a layer, G/t.

    Parameters
    ----------
    shear_modulus : Range
        G [Pa].
    thickness : Range
        t [m], from the tension member to the surface.

    Returns
    -------
    Range
        kf/b [N/m3], widened by a factor of three either way for what the formula leaves out.
    """
    return Range(
        low=shear_modulus.low / thickness.high / _MODEL_FACTOR,
        typical=shear_modulus.typical / thickness.typical,
        high=shear_modulus.high / thickness.low * _MODEL_FACTOR,
        unit="N/m3",
        sources=(SHEAR, *all_sources(shear_modulus, thickness)),
    )


def in_series(first: Range, second: Range) -> Range:
    """Stiffness of two layers one behind the other; both in the same unit."""
    return Range(
        low=_series(first.low, second.low),
        typical=_series(first.typical, second.typical),
        high=_series(first.high, second.high),
        unit=first.unit,
        sources=all_sources(first, second),
    )


def _series(first: float, second: float) -> float:
    return first * second / (first + second)
