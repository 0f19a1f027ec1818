"""What a belt on any number of pulleys is: the pulleys in the order of travel, and the tensioning.

Where the pulleys' places and sizes are known, `belt_ros.mechanics.layout` finds wraps and spans;
`loop_equilibrium` finds tensions, slips and margin.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from belt_ros.mechanics.drive import Belt, DriveError, Kinematics, Pulley, require_positive
from belt_ros.mechanics.layout import Layout

_Floats = NDArray[np.float64]


@dataclass(frozen=True)
class FixedCentres:
    """All shafts are fixed; the tension asked for is that of the belt as installed, at rest [N]."""


@dataclass(frozen=True)
class HeldSpan:
    """An automatic tensioner holds the tension T [N] of the span that leaves a pulley.

    Parameters
    ----------
    after : str
        Name of the pulley.
    """

    after: str


@dataclass(frozen=True)
class HubLoad:
    """A free pulley is pulled with a constant force [N], against the belt's effective tensions.

    Along the bisector they pull with (w_in + w_out) sin(phi/2). Wraps stay as given: the pulley's
    travel is small against the spans.

    Parameters
    ----------
    on : str
        Name of the pulley.
    angle : float
        Direction of the force against the bisector of the two spans [rad], positive against the
        pulley's rotation, see `Layout.hub_angle`.
    """

    on: str
    angle: float = 0.0

    def __post_init__(self) -> None:
        if not abs(self.angle) < 0.5 * np.pi:
            raise DriveError(
                f"hub load acts at {self.angle:g} rad to the bisector of the spans; "
                "it must be less than pi/2, or it does not tension the belt"
            )


@dataclass(frozen=True)
class LoopPulley:
    """One pulley of a loop.

    Parameters
    ----------
    name : str
    pulley : Pulley
    span_length : float
        Free length of the span that leaves it, in the order of the list [m].
    """

    name: str
    pulley: Pulley
    span_length: float

    def __post_init__(self) -> None:
        require_positive(self.span_length, "span length", "m")


@dataclass(frozen=True)
class BeltLoop:
    """A belt on n pulleys.

    Parameters
    ----------
    belt : Belt
    pulleys : tuple of LoopPulley
        Two or more, in the order of belt travel at positive speed.
    driver : str
        Name of the pulley whose speed is given.
    kinematics : Kinematics
    tensioning : FixedCentres or HeldSpan or HubLoad
    """

    belt: Belt
    pulleys: tuple[LoopPulley, ...]
    driver: str
    kinematics: Kinematics = Kinematics.EXACT
    tensioning: FixedCentres | HeldSpan | HubLoad = field(default_factory=FixedCentres)

    def __post_init__(self) -> None:
        if len(self.pulleys) < 2:
            raise DriveError(f"the belt runs on {len(self.pulleys)} pulleys; it needs at least 2")
        if len(set(self.names)) < len(self.names):
            raise DriveError(f"pulleys {', '.join(self.names)}: every name must be its own")
        self.index(self.driver)
        if isinstance(self.tensioning, HeldSpan):
            self.index(self.tensioning.after)
        if isinstance(self.tensioning, HubLoad):
            self.index(self.tensioning.on)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the pulleys."""
        return tuple(pulley.name for pulley in self.pulleys)

    def index(self, name: str) -> int:
        """Place of a pulley in the list; raises `DriveError` if there is none of that name."""
        if name not in self.names:
            raise DriveError(f"no pulley is called {name!r}; there are {', '.join(self.names)}")
        return self.names.index(name)

    def torques(self, given: Mapping[str, ArrayLike]) -> _Floats:
        """Torques of named pulleys [N m] as an array (..., n); 0 on all others."""
        columns = dict.fromkeys(range(len(self.pulleys)), np.asarray(0.0))
        for name, torque in given.items():
            columns[self.index(name)] = np.asarray(torque, dtype=np.float64)
        return np.stack(np.broadcast_arrays(*columns.values()), axis=-1)


def loop_pulleys(
    layout: Layout,
    names: Sequence[str],
    friction_coefficient: ArrayLike,
    friction_stiffness: ArrayLike,
    inertia: ArrayLike = 0.01,
) -> tuple[LoopPulley, ...]:
    """Pulleys of a loop from where the belt runs.

    Parameters
    ----------
    layout : Layout
        Of n discs.
    names : sequence of str, length n
    friction_coefficient, friction_stiffness, inertia : array_like, () or (n,)
        mu [-], kf [N/m2], J [kg m2]; a pulley that the belt's back touches has its own mu.

    Raises
    ------
    DriveError
        If there are not n names or values.
    """
    count = len(layout.discs)
    if len(names) != count:
        raise DriveError(f"{len(names)} names for {count} pulleys")
    values = []
    for label, given in (("mu", friction_coefficient), ("kf", friction_stiffness), ("J", inertia)):
        value = np.asarray(given, dtype=np.float64)
        if value.shape not in {(), (count,)}:
            raise DriveError(f"{label} has shape {value.shape}; it must be one or ({count},)")
        values.append(np.broadcast_to(value, (count,)))
    return tuple(
        LoopPulley(
            name,
            Pulley(disc.radius, float(wrap), float(mu), float(kf), float(moment)),
            float(span),
        )
        for name, disc, wrap, span, mu, kf, moment in zip(
            names, layout.discs, layout.wrap_angle, layout.span_length, *values, strict=True
        )
    )
