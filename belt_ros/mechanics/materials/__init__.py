"""Belts, laggings and grooves that a user can name; every figure with its range and its source."""

from belt_ros.mechanics.materials.belt_material import (
    BeltMaterial,
    PriorSuggestion,
    Size,
    stiffness_from_k1,
)
from belt_ros.mechanics.materials.catalogue import BELTS, belt_material
from belt_ros.mechanics.materials.lagging import LAGGINGS, SurfaceState
from belt_ros.mechanics.materials.ranges import Range
from belt_ros.mechanics.materials.wedge import equivalent_friction, wedge_factor

__all__ = [
    "BELTS",
    "LAGGINGS",
    "BeltMaterial",
    "PriorSuggestion",
    "Range",
    "Size",
    "SurfaceState",
    "belt_material",
    "equivalent_friction",
    "stiffness_from_k1",
    "wedge_factor",
]
