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

Everything is explicit in the traction ln(w_H/w_L), and rises with it: pull and creep, creep without
bound at the traction limit. So pull is defined and monotone for every creep, gross slip included.

These are the compiled scalar functions that equilibrium, rig and estimator share.
"""

import math
from typing import NamedTuple

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.arc_profile import ScaledArc
from belt_ros.mechanics.constants import (
    FIXED_CENTRES,
    HELD_HUB_LOAD,
    DriveConstants,
    both_arcs,
    traction_limit,
)
from belt_ros.mechanics.tensioning import held_slack, slack_at_pull, slack_at_traction

_SOLVE_STEPS = 100
_LARGEST_EXPONENT = 500.0
_NEAREST_TO_CAPACITY = 1e-12
_BESIDE_LIMIT = 0.1
_PART_OF_GAP = 1e-3
_SURELY_BELOW = 0.99


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


class _Loaded(NamedTuple):
    """Pull, slip and tensions at a traction, with their slopes in it."""

    pull: float
    pull_slope: float
    slip: float
    slip_slope: float
    slack: float  # T_L [N]
    tight: float  # T_H [N]
    receiving_gradient: float  # u'(0) [-]
    giving_gradient: float


@compiled
def _strain(c: DriveConstants, slack: float, tight: float) -> tuple[float, float]:
    """Return the ratio of span speeds v_L/v_H, and one minus it."""
    base = c.axial_stiffness + (slack if c.exact_strain else 0.0)
    far = base + (tight - slack)
    return base / far, (tight - slack) / far


@compiled
def _slip(ratio: float, deficit: float, received: float, given: float) -> float:
    """Slip from the speed ratio of the spans and the inlet gradients of both arcs."""
    if received <= 1.0:
        return (received * ratio - given + deficit) / (1.0 - given)
    # The receiving pulley is pushed backwards. Only its own sliding counts from here on, which
    # keeps slip rising with the pull.
    return 1.0 + (received - 1.0) * ratio


@compiled
def _loaded(
    c: DriveConstants,
    traction: float,
    tension: float,
    lift: float,
    receiving: ScaledArc,
    giving: ScaledArc,
) -> _Loaded:
    """Return what a traction amounts to; infinite slip where an arc slides as a whole."""
    net = c.axial_stiffness - lift
    growth, rise = math.exp(traction), math.expm1(traction)
    slack, slack_slope = slack_at_traction(c, traction, tension, lift, receiving, giving)
    pull, pull_slope = slack * rise, slack_slope * rise + slack * growth
    stretch = c.axial_stiffness / net
    t_slack, t_tight = slack + lift, slack + lift + stretch * pull
    u_r = receiving.state.gradient * slack / net
    u_g = -giving.state.gradient * slack * growth / net
    if not (slack > 0.0 and math.isfinite(u_r) and math.isfinite(u_g)):
        return _Loaded(pull, 0.0, math.inf, math.inf, t_slack, t_tight, math.inf, -math.inf)
    du_r = receiving.state.slope * slack / net + u_r * slack_slope / slack
    du_g = -giving.state.slope * slack * growth / net + u_g * (1.0 + slack_slope / slack)
    ratio, deficit = _strain(c, t_slack, t_tight)
    far = (t_tight - t_slack) / deficit if deficit > 0.0 else c.axial_stiffness + t_slack
    ratio_slope = -ratio * stretch * pull_slope / far
    if c.exact_strain:
        ratio_slope += deficit * slack_slope / far
    slip = _slip(ratio, deficit, u_r, u_g)
    if u_r <= 1.0:
        drag = 1.0 / (1.0 - u_g)
        slope = (du_r * ratio - (1.0 - u_r) * ratio_slope) * drag
        slope -= (1.0 - u_r) * ratio * drag * drag * du_g
    else:
        slope = du_r * ratio + (u_r - 1.0) * ratio_slope
    return _Loaded(pull, pull_slope, slip, slope, t_slack, t_tight, u_r, u_g)


@compiled
def _lift(c: DriveConstants, speed: float) -> float:
    """Return m v^2 [N]."""
    return c.mass_per_length * speed * speed


@compiled
def _can_pull(c: DriveConstants, tension: float, lift: float) -> bool:
    """Whether the belt presses on the pulleys at all."""
    held = tension if c.tensioning == HELD_HUB_LOAD else tension - lift
    return c.axial_stiffness > lift and held > 0.0


@compiled
def pull_capacity(
    c: DriveConstants, tension: float, mu: float, kf: float, speed: float, driven_receives: bool
) -> float:
    """Effective pull w_H - w_L [N] at gross slip of the pulley that slips first; 0 if lifted off.

    Parameters as of `creep`. Only between fixed centres does more than mu matter: the other
    pulley's arc takes its part of the belt's length.
    """
    lift = _lift(c, speed)
    if not _can_pull(c, tension, lift):
        return 0.0
    limit = min(traction_limit(c, mu), _LARGEST_EXPONENT)
    if c.tensioning == FIXED_CENTRES:
        net = c.axial_stiffness - lift
        receiving, giving = both_arcs(c, limit, mu, kf, net, driven_receives)
        slack = slack_at_traction(c, limit, tension, lift, receiving, giving)[0]
    else:
        slack = held_slack(c, limit, tension, lift)[0]
    return slack * math.expm1(limit)


@compiled
def _traction_at_pull(
    c: DriveConstants,
    pull: float,
    tension: float,
    lift: float,
    mu: float,
    kf: float,
    driven_receives: bool,
) -> float:
    """Traction at a pull; its limit at and beyond the capacity."""
    limit = traction_limit(c, mu)
    slack = slack_at_pull(c, pull, tension, lift)
    x = min(math.log1p(pull / slack), limit) if slack > 0.0 else limit
    if c.tensioning != FIXED_CENTRES or pull == 0.0:
        return x
    # Held at its mean the belt would have this traction; between fixed centres, nearly the same.
    low, high = 0.0, limit
    for _ in range(_SOLVE_STEPS):
        receiving, giving = both_arcs(c, x, mu, kf, c.axial_stiffness - lift, driven_receives)
        slack, slope = slack_at_traction(c, x, tension, lift, receiving, giving)
        error = slack * math.expm1(x) - pull
        if error > 0.0:
            high = x
        else:
            low = x
        candidate = x - error / (slope * math.expm1(x) + slack * math.exp(x))
        if not (low <= candidate <= high):
            candidate = 0.5 * (low + high)
        if abs(candidate - x) <= 1e-9 * x:  # the next step would move it by the square of this
            return candidate
        x = candidate
    return x


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
    lift = _lift(c, speed)
    if not _can_pull(c, tension, lift):
        return Creep(
            math.inf, math.inf, 0.0, tension, tension, 0.0, 0.0, math.nan, math.inf, -math.inf
        )
    traction = _traction_at_pull(c, pull, tension, lift, mu, kf, driven_receives)
    receiving, giving = both_arcs(c, traction, mu, kf, c.axial_stiffness - lift, driven_receives)
    load = _loaded(c, traction, tension, lift, receiving, giving)
    receiving_radius, receiving_wrap = c.driven_radius, c.driven_wrap
    giving_radius, giving_wrap = c.driver_radius, c.driver_wrap
    if not driven_receives:
        receiving_radius, giving_radius = giving_radius, receiving_radius
        receiving_wrap, giving_wrap = giving_wrap, receiving_wrap
    return Creep(
        load.slip,
        load.slip_slope / load.pull_slope if math.isfinite(load.slip) else math.inf,
        load.pull,
        load.slack,
        load.tight,
        min(receiving.begin * receiving.unit / receiving_radius, receiving_wrap),
        min(giving.begin * giving.unit / giving_radius, giving_wrap),
        receiving.state.restick * receiving.unit / receiving_radius,
        load.receiving_gradient,
        load.giving_gradient,
    )


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
    lift = _lift(c, speed)
    stretch = c.axial_stiffness / max(c.axial_stiffness - lift, 1e-3 * c.axial_stiffness)
    slack = slack_at_pull(c, pull, tension, lift)
    if c.tensioning == FIXED_CENTRES and pull > 0.0 and _can_pull(c, tension, lift):
        limit = pull_capacity(c, tension, mu, kf, speed, driven_receives)
        held = min(pull, limit)
        traction = _traction_at_pull(c, held, tension, lift, mu, kf, driven_receives)
        slack = held / math.expm1(traction) - 0.5 * (pull - held)
    return slack + lift, slack + lift + stretch * pull


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
    step of the spans' motion. The left side rises monotonically, so there is one root; Newton
    iteration in the traction, from that of the pull `start`, kept between bounds that close in on
    the limit geometrically.
    """
    lift = _lift(c, speed)
    if not (load > 0.0 and _can_pull(c, tension, lift)):
        return 0.0
    net = c.axial_stiffness - lift
    limit = min(traction_limit(c, mu), _LARGEST_EXPONENT)
    low, high = 0.0, limit * (1.0 - _NEAREST_TO_CAPACITY)
    # A Newton step doubles the digits: a step this small leaves an error of its square.
    enough = (2e-16 if weight == 0.0 else 1e-7) * limit
    slack = slack_at_pull(c, max(start, 0.0), tension, lift)
    x = min(math.log1p(max(start, 0.0) / slack), high) if slack > 0.0 else high
    pull = 0.0
    for _ in range(_SOLVE_STEPS):
        receiving, giving = both_arcs(c, x, mu, kf, net, driven_receives)
        state = _loaded(c, x, tension, lift, receiving, giving)
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
    if c.tensioning == FIXED_CENTRES and x < _SURELY_BELOW * limit:
        return pull  # the capacity costs as much as a step, and is far
    return min(pull, pull_capacity(c, tension, mu, kf, speed, driven_receives))
