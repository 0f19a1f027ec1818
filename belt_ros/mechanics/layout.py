"""Where the belt runs: wraps, free spans and path length from the pulleys' places and sizes.

The pulleys are discs in a plane, visited in the order of belt travel. Between two of them the belt
follows the common tangent that leaves one and meets the other in their senses of rotation; on each
disc it turns from the tangent that arrives to the one that leaves. A belt that does not cross
itself has turned once in all, one that crosses itself once (a crossed drive) not at all: the wraps,
signed by the sense of rotation, sum to +-2 pi or to 0.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.mechanics.drive import (
    Belt,
    BeltDrive,
    DriveError,
    Kinematics,
    Pulley,
    Tensioning,
    require_positive,
)

_Floats = NDArray[np.float64]
_LEAST_WRAP = 1e-9


class Side(IntEnum):
    """Sense in which the belt runs round a pulley.

    Where the belt travels counterclockwise, the pulleys inside its loop turn counterclockwise and
    those outside, which the belt's back touches, clockwise.
    """

    COUNTERCLOCKWISE = 1
    CLOCKWISE = -1


@dataclass(frozen=True)
class Disc:
    """One pulley in the plane of the belt.

    Parameters
    ----------
    x, y : float
        Centre [m].
    radius : float
        R [m], to the belt's neutral line.
    side : Side
        Sense of rotation.
    """

    x: float
    y: float
    radius: float
    side: Side = Side.COUNTERCLOCKWISE

    def __post_init__(self) -> None:
        if not (math.isfinite(self.x) and math.isfinite(self.y)):
            raise DriveError(f"pulley centre is ({self.x:g}, {self.y:g}) m; it must be finite")
        require_positive(self.radius, "pulley radius", "m")


class Layout(NamedTuple):
    """The course of a belt round n discs. Span i leaves disc i."""

    discs: tuple[Disc, ...]
    wrap_angle: _Floats  # (n,) [rad]
    span_length: _Floats  # (n,) [m]
    direction: _Floats  # (n, 2) unit vectors of travel along the spans
    begin: _Floats  # (n, 2) where the spans leave their discs [m]
    end: _Floats  # (n, 2) where they meet the next [m]

    @property
    def path_length(self) -> float:
        """Length of the belt as it lies on the pulleys [m]."""
        on_discs = sum(
            disc.radius * wrap for disc, wrap in zip(self.discs, self.wrap_angle, strict=True)
        )
        return float(np.sum(self.span_length) + on_discs)

    @property
    def turning(self) -> float:
        """Sum of the wraps signed by sense [rad]: +-2 pi, or 0 for a crossed belt."""
        return float(sum(d.side * w for d, w in zip(self.discs, self.wrap_angle, strict=True)))

    def hub_angle(self, index: int, direction: float) -> float:
        """Angle [rad] of a direction against the bisector of the two spans of a disc.

        The belt's force on a disc points along the bisector where both spans pull alike. Positive
        angles are those against the disc's rotation, towards the span that leaves.

        Parameters
        ----------
        index : int
            Of the disc.
        direction : float
            Angle [rad] against the x axis.
        """
        pull_x, pull_y = self.direction[index] - self.direction[index - 1]
        angle = -self.discs[index].side * (direction - math.atan2(pull_y, pull_x))
        return math.remainder(angle, 2.0 * math.pi)


def trace(discs: Sequence[Disc], *, crossed: bool = False) -> Layout:
    """Lay a belt round discs, in the order of its travel.

    Parameters
    ----------
    discs : sequence of Disc
        Two or more.
    crossed : bool
        Whether the belt is meant to cross itself, once.

    Returns
    -------
    Layout

    Raises
    ------
    DriveError
        For fewer than two discs, discs that overlap, a disc that the belt would not touch, a span
        that crosses a disc it does not run on, or a belt that crosses itself otherwise than meant.
    """
    discs = tuple(discs)
    if len(discs) < 2:
        raise DriveError(f"the belt runs on {len(discs)} pulleys; it needs at least 2")
    _check_apart(discs)
    centre = np.array([(disc.x, disc.y) for disc in discs], dtype=np.float64)
    reach = np.array([disc.side * disc.radius for disc in discs], dtype=np.float64)
    layout = _follow(discs, centre, reach)
    _check_spans_clear(layout, centre)
    _check_crossings(layout, crossed)
    return layout


def _follow(discs: tuple[Disc, ...], centre: _Floats, reach: _Floats) -> Layout:
    """Follow tangents and wraps; `reach` is R [m], negative where the belt turns clockwise."""
    gap = np.roll(centre, -1, axis=0) - centre
    distance = np.hypot(gap[:, 0], gap[:, 1])
    lean = reach - np.roll(reach, -1)
    length = np.sqrt((distance - lean) * (distance + lean))
    x, y = gap.T / distance**2
    direction = np.stack([x * length - y * lean, x * lean + y * length], axis=-1)
    right = np.stack([direction[:, 1], -direction[:, 0]], axis=-1)
    before_x, before_y = np.roll(direction, 1, axis=0).T
    after_x, after_y = direction.T
    turn = np.arctan2(
        before_x * after_y - before_y * after_x, before_x * after_x + before_y * after_y
    )
    return Layout(
        discs=discs,
        wrap_angle=np.mod(np.sign(reach) * turn, 2.0 * math.pi),
        span_length=length,
        direction=direction,
        begin=centre + reach[:, None] * right,
        end=np.roll(centre, -1, axis=0) + np.roll(reach, -1)[:, None] * right,
    )


def _check_apart(discs: tuple[Disc, ...]) -> None:
    for (i, one), (j, other) in itertools.combinations(enumerate(discs), 2):
        distance = math.hypot(other.x - one.x, other.y - one.y)
        if distance <= one.radius + other.radius:
            raise DriveError(
                f"pulleys {i} and {j} overlap: their centres are {distance:g} m apart, "
                f"not more than their radii together, {one.radius + other.radius:g} m"
            )


def _check_spans_clear(layout: Layout, centre: _Floats) -> None:
    count = len(layout.discs)
    for span, disc in itertools.product(range(count), range(count)):
        if disc in {span, (span + 1) % count}:
            continue
        offset = centre[disc] - layout.begin[span]
        along = float(np.clip(offset @ layout.direction[span], 0.0, layout.span_length[span]))
        distance = float(np.hypot(*(offset - along * layout.direction[span])))
        if distance < layout.discs[disc].radius:
            raise DriveError(
                f"the span from pulley {span} to {(span + 1) % count} crosses pulley {disc}: it "
                f"passes its centre at {distance:g} m, less than its radius of "
                f"{layout.discs[disc].radius:g} m; change the order or a side"
            )


def _spans_cross(layout: Layout, i: int, j: int) -> bool:
    def opposite(a: int, b: int) -> bool:
        """Whether the ends of span b lie on either side of the line of span a."""
        x, y = layout.direction[a]
        sides = [
            x * (p[1] - layout.begin[a, 1]) - y * (p[0] - layout.begin[a, 0])
            for p in (layout.begin[b], layout.end[b])
        ]
        return float(sides[0] * sides[1]) < 0.0

    return opposite(i, j) and opposite(j, i)


def _check_crossings(layout: Layout, crossed: bool) -> None:
    """Raise unless the belt crosses itself exactly as often as it is meant to.

    A disc that the belt misses shows as a belt that crosses itself to get a nearly full turn
    round it: the tangents are the same.
    """
    count = len(layout.discs)
    for index, wrap in enumerate(layout.wrap_angle):
        if not _LEAST_WRAP < wrap < 2.0 * math.pi - _LEAST_WRAP:
            raise _missed(layout, index)
    crossings = [
        pair for pair in itertools.combinations(range(count), 2) if _spans_cross(layout, *pair)
    ]
    if crossed:
        if len(crossings) != 1 or abs(layout.turning) > 1.0:
            raise DriveError(
                f"the belt crosses itself {len(crossings)} times and turns by "
                f"{layout.turning:g} rad; a crossed belt does once and by 0: check order and sides"
            )
        return
    for i, j in crossings:
        if count > 2 and (j - i in {1, count - 1}):
            raise _missed(layout, j if j - i == 1 else 0)
    if crossings:
        i, j = crossings[0]
        raise DriveError(
            f"the spans that leave pulleys {i} and {j} cross: check order and sides, or say that "
            "the belt is crossed"
        )


def _missed(layout: Layout, index: int) -> DriveError:
    wrap = float(layout.wrap_angle[index])
    if wrap > _LEAST_WRAP:
        wrap -= 2.0 * math.pi
    return DriveError(
        f"the belt would not touch pulley {index}: its wrap would be {wrap:g} rad and must be > 0; "
        "move it against the belt, change its side, or say that the belt is crossed"
    )


def _two_pulley_drive(
    belt: Belt,
    discs: tuple[Disc, Disc],
    contact: tuple[float, float],
    kinematics: Kinematics,
    tensioning: Tensioning,
) -> BeltDrive:
    """Drive whose driven pulley is the first disc and whose driver is the second."""
    layout = trace(discs, crossed=discs[0].side != discs[1].side)
    driven, driver = (
        Pulley(disc.radius, float(wrap), *contact)
        for disc, wrap in zip(discs, layout.wrap_angle, strict=True)
    )
    return BeltDrive(
        belt=belt,
        driven=driven,
        driver=driver,
        span_length=float(layout.span_length[0]),
        kinematics=kinematics,
        tensioning=tensioning,
    )


def open_drive(
    belt: Belt,
    driven_radius: float,
    driver_radius: float,
    centre_distance: float,
    friction_coefficient: float,
    friction_stiffness: float,
    *,
    kinematics: Kinematics = Kinematics.EXACT,
    tensioning: Tensioning = Tensioning.CONSTANT_MEAN,
) -> BeltDrive:
    """Two-pulley drive with an open belt; both pulleys turn the same way.

    Parameters
    ----------
    belt : Belt
    driven_radius, driver_radius : float
        R1, R2 [m].
    centre_distance : float
        Between the shafts [m].
    friction_coefficient, friction_stiffness : float
        mu [-] and kf [N/m2] of both pulleys; `dataclasses.replace` gives one its own.
    kinematics, tensioning
        As for `BeltDrive`.

    Returns
    -------
    BeltDrive
        With the wraps and the span length of the layout.

    Raises
    ------
    DriveError
        If the pulleys overlap, or for a value that no drive can have.
    """
    discs = Disc(0.0, 0.0, driven_radius), Disc(centre_distance, 0.0, driver_radius)
    contact = friction_coefficient, friction_stiffness
    return _two_pulley_drive(belt, discs, contact, kinematics, tensioning)


def crossed_drive(
    belt: Belt,
    driven_radius: float,
    driver_radius: float,
    centre_distance: float,
    friction_coefficient: float,
    friction_stiffness: float,
    *,
    kinematics: Kinematics = Kinematics.EXACT,
    tensioning: Tensioning = Tensioning.CONSTANT_MEAN,
) -> BeltDrive:
    """Two-pulley drive with a crossed belt; the pulleys turn opposite ways.

    A speed of the driven pulley, and a torque on it, are then positive in its own sense of
    rotation. Parameters and errors as for `open_drive`.
    """
    discs = (
        Disc(0.0, 0.0, driven_radius),
        Disc(centre_distance, 0.0, driver_radius, Side.CLOCKWISE),
    )
    contact = friction_coefficient, friction_stiffness
    return _two_pulley_drive(belt, discs, contact, kinematics, tensioning)
