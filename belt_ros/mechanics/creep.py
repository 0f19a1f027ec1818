"""Creep of the whole drive: how much slower the receiving pulley runs at a given effective pull.

The power flows from a giving pulley (the driver, unless the load pushes) to a receiving one. On the
receiving pulley tension rises along the arc from slack to tight span, on the giving pulley it falls
back. Mass is conserved round the loop, so with the inlet gradients u' of both arcs (Eq. 11)

    (rim speed received)/(rim speed given) = (1 - u_r')/(1 - u_g') * (1 + T_L/EA)/(1 + T_H/EA)

and creep = 1 - that ratio. Belt inertia is taken at one speed, the driver's rim speed in all that
uses this; the belt's own differs from it by the creep.

The pull is the effective one, w_H - w_L = M/R: what friction puts on a pulley. The belt's tension
changes by more, T_H - T_L = (EA/K)(w_H - w_L), because the stretched belt runs faster and takes
momentum along.

Everything is explicit in the traction ln(w_H/w_L), and rises with it, pull and creep. Towards the
traction limit creep grows without bound where the receiving pulley slips first, and to 1, the
receiving pulley at rest, where the giving one does. So pull is defined and monotone for every
creep, gross slip included.

These are the compiled scalar functions that equilibrium, rig and estimator share.
"""

import math
from typing import NamedTuple

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.arc_profile import PulleyArc
from belt_ros.mechanics.constants import FIXED_CENTRES, DriveConstants
from belt_ros.mechanics.loaded_belt import (
    LARGEST_EXPONENT,
    NEAREST_TO_CAPACITY,
    UNKNOWN,
    Loaded,
    MountedBelt,
    Near,
    belt_on_pulleys,
    capacity_of,
    loaded,
    loaded_at_pull,
    loaded_near_pull,
)
from belt_ros.mechanics.tensioning import slack_at_pull

_SOLVE_STEPS = 100
_STEP_ENOUGH = 1e-6
_BESIDE_LIMIT = 0.1
_PART_OF_GAP = 1e-3
_SURELY_BELOW = 0.99
_LEAST_TRACTION = 1e-9  # below it, a subnormal pull has too few digits to tell the slack tension


class Creep(NamedTuple):
    """Creep at a pull, the tensions, and the state of both arcs."""

    slip: float  # of the receiving pulley against the giving one [-]
    slope: float  # d slip / d pull [1/N]
    pull: float  # w_H - w_L [N]
    slack: float  # T_L [N]
    tight: float  # T_H [N]
    receiving_transition: float  # transition angle [rad]
    giving_transition: float
    receiving_restick: float  # NaN where there is none
    receiving_gradient: float  # u'(0) [-]
    giving_gradient: float


@compiled
def pull_capacity(
    c: DriveConstants, tension: float, mu: float, kf: float, speed: float, driven_receives: bool
) -> float:
    """Effective pull w_H - w_L [N] at gross slip, see `capacity_of`; parameters as of `creep`."""
    belt = belt_on_pulleys(c, tension, mu, kf, speed, driven_receives)
    return capacity_of(c, belt, UNKNOWN)


@compiled
def creep(
    c: DriveConstants,
    pull: float,
    tension: float,
    mu: float,
    kf: float,
    speed: float,
    driven_receives: bool,
) -> Creep:
    """Creep at an effective pull.

    Parameters
    ----------
    c : DriveConstants
    pull : float
        w_H - w_L = M/R >= 0 [N].
    tension : float
        What the tensioning holds [N], see `Tensioning`.
    mu, kf : float
        Of the driven pulley [-], [N/m2]; the driver's follow by the constants' ratios.
    speed : float
        Of the belt [m/s], for its inertia.
    driven_receives : bool
        True when power flows from driver to driven pulley.

    Returns
    -------
    Creep
        Infinite slip at and beyond the capacity.
    """
    belt = belt_on_pulleys(c, tension, mu, kf, speed, driven_receives)
    return creep_of(c, belt, pull, UNKNOWN)[0]


@compiled
def creep_of(c: DriveConstants, belt: MountedBelt, pull: float, near: Near) -> tuple[Creep, Near]:
    """Creep at an effective pull [N], solved from `near`, and what is near it."""
    if not belt.grips:
        lost = math.inf
        tension = belt.held
        return Creep(lost, lost, 0.0, tension, tension, 0.0, 0.0, math.nan, lost, -lost), near
    load = loaded_at_pull(c, belt, pull, near)
    receiving, giving = belt.receiving, belt.giving
    return Creep(
        load.slip,
        load.slip_slope / load.pull_slope if math.isfinite(load.slip) else math.inf,
        load.pull,
        load.slack,
        load.tight,
        _angle(receiving, load.near.receiving.transition),
        _angle(giving, load.near.giving.transition),
        _angle(receiving, load.near.receiving.restick),
        load.receiving_gradient,
        load.giving_gradient,
    ), load.near


@compiled
def tensions_at_pull(
    c: DriveConstants, belt: MountedBelt, pull: float, capacity: float, near: Near
) -> tuple[float, float]:
    """Tensions (T_L, T_H) [N] of the two spans at an effective pull, also beyond the capacity."""
    stretch = c.axial_stiffness / max(belt.net, 1e-3 * c.axial_stiffness)
    slack = slack_at_pull(c, pull, belt.held, belt.lift)
    if c.tensioning == FIXED_CENTRES and pull > 0.0 and belt.grips:
        held = min(pull, capacity)
        state = loaded_at_pull(c, belt, held, near)
        slack = state.slack - belt.lift
        if state.traction > _LEAST_TRACTION:
            slack = held / math.expm1(state.traction)
        slack -= 0.5 * (pull - held)
    return slack + belt.lift, slack + belt.lift + stretch * pull


@compiled
def span_tensions(
    c: DriveConstants,
    pull: float,
    tension: float,
    mu: float,
    kf: float,
    speed: float,
    driven_receives: bool,
) -> tuple[float, float]:
    """Tensions (T_L, T_H) [N] of the two spans at an effective pull; parameters as of `creep`."""
    belt = belt_on_pulleys(c, tension, mu, kf, speed, driven_receives)
    return tensions_at_pull(c, belt, pull, capacity_of(c, belt, UNKNOWN), UNKNOWN)


@compiled
def pull_at_creep(
    c: DriveConstants,
    weight: float,
    load: float,
    start: float,
    tension: float,
    mu: float,
    kf: float,
    speed: float,
    driven_receives: bool,
) -> float:
    """Pull [N] in [0, capacity) at which weight * pull + slip(pull) = load.

    With weight 0 it inverts creep: the pull at slip `load`. With weight > 0 it is one implicit
    step of the spans' motion. The search begins at the pull `start` [N].
    """
    belt = belt_on_pulleys(c, tension, mu, kf, speed, driven_receives)
    if not (load > 0.0 and belt.grips):
        return 0.0
    first = loaded_near_pull(c, belt, start, UNKNOWN)
    return balance(c, belt, weight, load, first)[0]


@compiled
def balance(
    c: DriveConstants, belt: MountedBelt, weight: float, load: float, start: Loaded
) -> tuple[float, Loaded]:
    """Pull [N] of a belt that grips at which weight * pull + slip(pull) = load > 0.

    The left side rises monotonically, so there is one root; Newton iteration in the traction from
    the state `start`, kept between bounds that close in on the limit geometrically. Also returns
    the last state evaluated, which is `start` itself where that is near enough.
    """
    limit = min(belt.limit, LARGEST_EXPONENT)
    low, high = 0.0, limit * (1.0 - NEAREST_TO_CAPACITY)
    # A Newton step doubles the digits: a step this small leaves an error of its square.
    enough = (2e-16 if weight == 0.0 else _STEP_ENOUGH) * limit
    state, x, pull = start, start.traction, start.pull
    for _ in range(_SOLVE_STEPS):
        error = weight * state.pull + state.slip - load
        if error > 0.0:
            high = x
        else:
            low = x
        candidate = x - error / (weight * state.pull_slope + state.slip_slope)
        # Beside the pole at the limit a Newton step from above only doubles the distance to it.
        lost = error > load and limit - x < _BESIDE_LIMIT * limit
        if lost or not (math.isfinite(state.slip_slope) and low <= candidate <= high):
            candidate = limit - math.sqrt((limit - low) * (limit - high))
        pull = state.pull + state.pull_slope * (candidate - x)
        step = abs(candidate - x)
        if step <= min(enough, _PART_OF_GAP * (limit - x)) or high - low <= 2e-16 * limit:
            break
        x = candidate
        state = loaded(c, belt, x, state.near)
    if x < _SURELY_BELOW * limit:
        return pull, state  # the capacity, which costs as much as a step, is far
    return min(
        pull, capacity_of(c, belt, UNKNOWN)
    ), state  # the same as everyone else's, to the bit


@compiled
def _angle(arc: PulleyArc, x: float) -> float:
    """Angle [rad] at a scaled distance from the inlet."""
    if math.isnan(x):
        return x
    return arc.wrap_angle * min(x / arc.shape.wrap, 1.0)
