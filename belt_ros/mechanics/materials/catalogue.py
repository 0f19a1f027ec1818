"""The belts that can be named, and the refusal of toothed ones."""

import re
from collections.abc import Mapping
from types import MappingProxyType

from belt_ros.mechanics.drive import DriveError
from belt_ros.mechanics.materials.belt_material import BeltMaterial
from belt_ros.mechanics.materials.flat_belts import FLAT_BELTS
from belt_ros.mechanics.materials.grooved_belts import GROOVED_BELTS

BELTS: Mapping[str, BeltMaterial] = MappingProxyType(
    {belt.name: belt for belt in (*FLAT_BELTS, *GROOVED_BELTS)}
)

# A section alone names its belt; a V-ribbed belt also as it is marked, "6PK1200".
_SECTIONS = {belt.groove.name.lower(): belt for belt in GROOVED_BELTS if belt.groove is not None}
_RIBBED_MARK = re.compile(r"\d*(p[jklm])\d*")

# Names of toothed belts: words, and profiles with or without a pitch ("htd 5m", "at10", "gt2").
_TOOTHED_WORDS = re.compile(r"timing|tooth|synchron|zahnriemen|poly-?chain")
_TOOTHED_PROFILES = re.compile(
    r"(mxl|xl|l|h|xh|xxh|(htd|rpp|std|gt|gates-gt)-?\d*m?|s\d+m|(at|t|atl|tk|atk)\d+(\.\d)?|"
    r"\d+m?-?(gt|htd|mgt|m)-?\d*)"
)


def belt_material(name: str) -> BeltMaterial:
    """Return the belt called `name`, or the one of the V-section `name`.

    Case, spaces and underscores do not matter.

    Raises
    ------
    DriveError
        If there is none, listing the names; if it is a toothed belt, with the reason.
    """
    key = re.sub(r"[\s_]+", "-", name.strip().lower())
    section = _RIBBED_MARK.sub(r"\1", key)
    found = BELTS.get(key) or _SECTIONS.get(section)
    if found is not None:
        return found
    if _TOOTHED_WORDS.search(key) or _TOOTHED_PROFILES.fullmatch(key):
        raise DriveError(
            f"{name!r} is a toothed belt. It drives by form, not by friction: it neither creeps "
            "nor slips, and its load sits on its teeth, so there is no slip to estimate and no "
            "capacity mu phi. Compare the positions of its pulleys instead: the difference is "
            "windup, in proportion to torque, and a jump by a whole tooth pitch is a skipped tooth"
        )
    raise DriveError(f"no belt is called {name!r}; choose from {', '.join(BELTS)}")
