"""A figure as it is honestly known: from, typically, to, its unit, and where it comes from."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

from belt_ros.mechanics.drive import DriveError

_STDDEVS_ACROSS = 4.0  # low and high are taken as the 2.5 % and 97.5 % points


class Evidence(Enum):
    """How a source was consulted."""

    READ = "read"  # the document itself
    QUOTED = "quoted"  # another text that quotes it
    MEMORY = "from memory, not looked up"
    DERIVED = "computed here"
    ESTIMATE = "estimate of this project"


@dataclass(frozen=True)
class Source:
    """Where a figure comes from.

    Parameters
    ----------
    key : str
        Short name for tables.
    title : str
        Document, standard or book, and what it says.
    evidence : Evidence
        How it was consulted.
    """

    key: str
    title: str
    evidence: Evidence

    @property
    def verified(self) -> bool:
        """Whether the figure was seen in print, at first or at second hand."""
        return self.evidence in {Evidence.READ, Evidence.QUOTED}


@dataclass(frozen=True)
class Range:
    """A positive quantity between two bounds.

    Parameters
    ----------
    low, typical, high : float
        Bounds that hold nineteen cases in twenty, and the value to start from.
    unit : str
        SI; "-" for a ratio.
    sources : tuple of Source
        At least one.

    Raises
    ------
    DriveError
        Unless 0 < low <= typical <= high < infinity, with low < high, and a source is named.
    """

    low: float
    typical: float
    high: float
    unit: str
    sources: tuple[Source, ...]

    def __post_init__(self) -> None:
        ordered = 0.0 < self.low <= self.typical <= self.high < math.inf
        if not (ordered and self.low < self.high):
            raise DriveError(
                f"range {self.low:g} / {self.typical:g} / {self.high:g} {self.unit}; "
                "it must rise from low over typical to high, all finite and > 0"
            )
        if not self.sources:
            raise DriveError(f"range around {self.typical:g} {self.unit} names no source; give one")

    @property
    def verified(self) -> bool:
        """Whether every source was seen in print."""
        return all(source.verified for source in self.sources)

    @property
    def stddev(self) -> float:
        """Standard deviation [the unit] of a normal prior about `typical`."""
        return (self.high - self.low) / _STDDEVS_ACROSS

    @property
    def decades(self) -> float:
        """Standard deviation of log10 [decades] of a log-normal prior with median `typical`."""
        return math.log10(self.high / self.low) / _STDDEVS_ACROSS

    @property
    def relative_stddev(self) -> float:
        """Standard deviation of the natural logarithm [-] of a log-normal prior."""
        return self.decades * math.log(10.0)

    def scaled(self, factor: float, unit: str | None = None) -> "Range":
        """Return the range times `factor` > 0, in `unit` if given."""
        return self.mapped(lambda value: factor * value, unit)

    def mapped(self, function: Callable[[float], float], unit: str | None = None) -> "Range":
        """Return the range under a rising `function`, in `unit` if given."""
        return replace(
            self,
            low=function(self.low),
            typical=function(self.typical),
            high=function(self.high),
            unit=self.unit if unit is None else unit,
        )


def all_sources(*ranges: Range) -> tuple[Source, ...]:
    """Return the sources of all `ranges`, each once, in order of appearance."""
    return tuple(dict.fromkeys(source for one in ranges for source in one.sources))
