"""Belts a user can name: stiffness, mass, friction and friction stiffness with their ranges.

A preset is a start, not a measurement. The manufacturer's own figures replace it wherever there are
any: `stiffness_from_k1` turns a catalogue's k1% into EA. Where each figure comes from, and whether
it was seen in print, travels with it (`Range.sources`).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

from belt_ros.mechanics.drive import Belt, DriveError, require_positive
from belt_ros.mechanics.materials.contact_layer import in_series
from belt_ros.mechanics.materials.lagging import SurfaceState, lagging_named
from belt_ros.mechanics.materials.ranges import Range, Source, all_sources
from belt_ros.mechanics.materials.wedge import WedgeSection, wedge_factor
from belt_ros.mechanics.units import meant_millimetres


class Size(Enum):
    """What the size of a belt is counted in."""

    WIDTH = "m of width"
    DIAMETER = "m of diameter"
    RIBS = "ribs"
    BELTS = "belts"

    def section(self, size: float) -> float:
        """Return what EA and mass are proportional to: width, cross-section [m2] or number."""
        return math.pi * size**2 / 4.0 if self is Size.DIAMETER else size

    def contact(self, size: float) -> float:
        """Return what kf is proportional to; a round belt's does not depend on its diameter."""
        return 1.0 if self is Size.DIAMETER else size

    def check(self, size: float) -> None:
        """Raise `DriveError` if there is no belt of that size, as when it is in millimetres."""
        low, high = _SIZES[self]
        within = low <= size <= high
        if self in (Size.RIBS, Size.BELTS):
            if not within or size != int(size):
                raise DriveError(
                    f"size is {size:g} {self.value}; it must be a whole number from {low:g} to "
                    f"{high:g}"
                )
        elif not within:
            raise DriveError(
                f"size is {size:g} {self.value}; it must lie between {low:g} and {high:g}"
                f"{meant_millimetres(size, low, high)}"
            )


_SIZES = {
    Size.WIDTH: (1e-3, 4.0),  # the widest conveyor belts have 3.2 m
    Size.DIAMETER: (1e-3, 0.1),
    Size.RIBS: (1.0, 200.0),
    Size.BELTS: (1.0, 100.0),
}


@dataclass(frozen=True)
class ServiceLimits:
    """What the belt stands; None where no figure was found.

    Parameters
    ----------
    strain : float
        Greatest strain in service [-].
    coldest, hottest : float or None
        Of the belt in continuous service [degC].
    speed : float or None
        Greatest belt speed [m/s].
    sources : tuple of Source
        Of all four.
    """

    strain: float
    coldest: float | None
    hottest: float | None
    speed: float | None
    sources: tuple[Source, ...]


class PriorSuggestion(NamedTuple):
    """What a preset says before anything is measured, in the estimator's terms."""

    tension: float  # of one strand as installed [N]
    tension_stddev: float
    friction_coefficient: float  # of the equivalent flat belt [-]
    friction_coefficient_stddev: float
    friction_stiffness: float  # median [N/m2]
    friction_stiffness_decades: float  # standard deviation of log10


@dataclass(frozen=True)
class BeltMaterial:
    """A kind of belt.

    Parameters
    ----------
    name, title : str
        What a user writes, and what it means.
    size : Size
        What the belt is sized by.
    stiffness : Range
        EA per width [N/m], per cross-section [Pa], or of a rib or belt [N].
    mass : Range
        Per width [kg/m2], per volume [kg/m3], or of a rib or belt [kg/m].
    contact_stiffness : Range
        kf per width [N/m3], or of a round belt, rib or belt [N/m2].
    friction : mapping of (lagging, state) to Range
        mu [-]; on the flanks where there is a groove.
    installed_strain : Range
        Strain at which it is fitted [-].
    limits : ServiceLimits
    groove : WedgeSection or None
        The section, if it runs in grooves.
    """

    name: str
    title: str
    size: Size
    stiffness: Range
    mass: Range
    contact_stiffness: Range
    friction: Mapping[tuple[str, SurfaceState], Range]
    installed_strain: Range
    limits: ServiceLimits
    groove: WedgeSection | None = field(default=None, repr=False)

    def axial_stiffness(self, size: float) -> Range:
        """EA [N] of a belt of `size` [m of width or diameter, or number of ribs or belts]."""
        return self.stiffness.scaled(self._section(size), "N")

    def mass_per_length(self, size: float) -> Range:
        """Mass per length m [kg/m] of a belt of `size`."""
        return self.mass.scaled(self._section(size), "kg/m")

    def belt(self, size: float) -> Belt:
        """Return the typical belt of `size`.

        Raises
        ------
        DriveError
            If `size` is not finite and positive.
        """
        return Belt(self.axial_stiffness(size).typical, self.mass_per_length(size).typical)

    def friction_coefficient(
        self, lagging: str = "steel", state: SurfaceState = SurfaceState.DRY
    ) -> Range:
        """Friction coefficient mu [-] on `lagging`; on the flanks where there is a groove.

        Raises
        ------
        DriveError
            If there is no such lagging, or no figure for the pair; the message lists what there is.
        """
        surface = lagging_named(lagging)
        found = self.friction.get((surface.name, state))
        if found is None:
            known = ", ".join(f"{name} {known.value}" for name, known in self.friction)
            raise DriveError(
                f"no friction coefficient is known of {self.name} on {surface.name}, "
                f"{state.value}; there are {known}. Give your own mu"
            )
        return found

    def equivalent_friction(
        self,
        lagging: str = "steel",
        state: SurfaceState = SurfaceState.DRY,
        datum_diameter: float | None = None,
    ) -> Range:
        """Friction coefficient [-] of the equivalent flat belt.

        Parameters
        ----------
        lagging, state
            As in `friction_coefficient`.
        datum_diameter : float or None
            Of the pulley [m]; sets the standard groove angle. None takes a large pulley.

        Raises
        ------
        DriveError
            As in `friction_coefficient`, and if the pulley is too small for the section.
        """
        mu = self.friction_coefficient(lagging, state)
        if self.groove is None:
            return mu
        diameter = math.inf if datum_diameter is None else datum_diameter
        return mu.scaled(wedge_factor(self.groove.groove_angle(diameter)))

    def friction_stiffness(self, size: float, lagging: str = "steel") -> Range:
        """Friction stiffness kf [N/m2] of a belt of `size`, in series with the lagging.

        Raises
        ------
        DriveError
            If `size` is not finite and positive, or there is no such lagging.
        """
        require_positive(size, f"belt size [{self.size.value}]")
        layer = self.contact_stiffness
        soft = lagging_named(lagging).contact_stiffness
        if soft is not None and self.size is Size.WIDTH:
            layer = in_series(layer, soft)
        return layer.scaled(self.size.contact(size), "N/m2")

    def prior(
        self,
        size: float,
        lagging: str = "steel",
        state: SurfaceState = SurfaceState.DRY,
        datum_diameter: float | None = None,
    ) -> PriorSuggestion:
        """Return priors for the estimator; arguments as above.

        Tension is EA times the installed strain, both log-normal; kf is log-normal; mu is normal.
        """
        stiffness = self.axial_stiffness(size)
        spread = math.hypot(stiffness.relative_stddev, self.installed_strain.relative_stddev)
        tension = stiffness.typical * self.installed_strain.typical
        mu = self.equivalent_friction(lagging, state, datum_diameter)
        kf = self.friction_stiffness(size, lagging)
        return PriorSuggestion(
            tension, spread * tension, mu.typical, mu.stddev, kf.typical, kf.decades
        )

    def sources(self) -> tuple[Source, ...]:
        """Return the sources of all figures, each once."""
        ranges = (self.stiffness, self.mass, self.contact_stiffness, self.installed_strain)
        every = all_sources(*ranges, *self.friction.values()) + self.limits.sources
        return tuple(dict.fromkeys(every))

    def _section(self, size: float) -> float:
        require_positive(size, f"belt size [{self.size.value}]")
        return self.size.section(size)


def stiffness_from_k1(k1: float) -> float:
    """EA per width [N/m] from a catalogue's k1%.

    k1% is the force per width at 1 % elongation of one strand, so EA is a hundred times as much.
    Catalogues give it in N per mm of width: 8 N/mm is k1 = 8000 N/m, EA = 8e5 N per m of width.
    Take the relaxed value to turn strain into tension, and the static one, nearer to what the belt
    does in the time of one turn, for creep.

    Parameters
    ----------
    k1 : float
        k1% [N/m].

    Raises
    ------
    DriveError
        Unless finite and positive.
    """
    require_positive(k1, "k1%", "N/m")
    return 100.0 * k1
