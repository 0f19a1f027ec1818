"""The pull after a step of a belt of which two states near by are known, compiled.

Between two states, and not far beside them, pull and slip are cubics of the traction by their
values and slopes at both. That spares another solution of both arcs.
"""

import math

from belt_ros.mechanics._compile import inlined
from belt_ros.mechanics.constants import FIXED_CENTRES, DriveConstants
from belt_ros.mechanics.loaded_belt import Loaded, MountedBelt

_SURELY_BELOW = 0.99  # of the traction limit; beyond it, the pole of slip is near
_PART_OF_GAP = 2e-3  # to the limit, within which a cubic leaves an error of some 1e-12 of the gap
_BESIDE = 3.0  # distances of the two states, within which their rounding does not show
_STEPS = 3  # of a Newton iteration whose first step is off by some 1e-3 of itself


@inlined
def _sliding(belt: MountedBelt, traction: float) -> bool:
    """Whether both arcs creep first and slide from there to the outlet."""
    limits = max(belt.receiving.shape.elastic_limit, belt.giving.shape.elastic_limit)
    return belt.receiving.shape.growth < 1.0 and traction > limits


@inlined
def pull_between(
    c: DriveConstants, belt: MountedBelt, weight: float, load: float, one: Loaded, other: Loaded
) -> float:
    """Pull [N] as of `creep.balance`, by two of the belt's states; NaN where they do not tell it.

    Off by less than 1e-10 of itself. They do not tell it where they are too far from it, or one and
    the same, where an arc slides otherwise than at them, and between fixed centres, where the slope
    of the pull is not exact.
    """
    x, apart = one.traction, other.traction - one.traction
    if apart == 0.0 or c.tensioning == FIXED_CENTRES:
        return math.nan
    error = weight * one.pull + one.slip - load
    slope = apart * (weight * one.pull_slope + one.slip_slope)
    end = apart * (weight * other.pull_slope + other.slip_slope)
    gained = weight * (other.pull - one.pull) + (other.slip - one.slip)
    square, cube = 3.0 * gained - 2.0 * slope - end, slope + end - 2.0 * gained
    t = -error / slope
    if not abs(t) <= _BESIDE:
        return math.nan
    reach = max(abs(t), 1.0) * abs(apart)
    least, most = min(x, other.traction) - reach, max(x, other.traction) + reach
    near = reach < _PART_OF_GAP * (belt.limit - most) and most < _SURELY_BELOW * belt.limit
    if not (near and _sliding(belt, least)):
        return math.nan
    for _ in range(_STEPS):
        rest = error + t * (slope + t * (square + t * cube))
        t -= rest / (slope + t * (2.0 * square + 3.0 * t * cube))
    slope, end = apart * one.pull_slope, apart * other.pull_slope
    gained = other.pull - one.pull
    square, cube = 3.0 * gained - 2.0 * slope - end, slope + end - 2.0 * gained
    return one.pull + t * (slope + t * (square + t * cube))
