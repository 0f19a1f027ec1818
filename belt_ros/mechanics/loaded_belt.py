"""The belt on both pulleys: what a traction ln(w_H/w_L) amounts to, compiled.

Everything about a loaded belt is explicit in the traction but for the transitions of both arcs and,
between fixed centres, the level of tension. Those are solved for, and what was found is kept
(`Near`): a belt that differs little is then solved in one or two steps instead of five.
"""

import math
from typing import NamedTuple

from belt_ros.mechanics._compile import compiled, inlined
from belt_ros.mechanics.arc_profile import PulleyArc, profile_of
from belt_ros.mechanics.arc_state import UNKNOWN_ARC, ArcState, loaded_arc
from belt_ros.mechanics.constants import (
    FIXED_CENTRES,
    HELD_HUB_LOAD,
    DriveConstants,
    both_arcs,
    traction_limit,
)
from belt_ros.mechanics.exponentials import exp_minus_one, log_one_plus
from belt_ros.mechanics.tensioning import (
    AS_LINEAR,
    Tautness,
    fixed_centres_slack,
    held_slack,
    slack_at_pull,
)

LARGEST_EXPONENT = 500.0
_MOST_STRETCHED = 1.0  # tension over EA
_FASTENED = 25.0  # traction whose slack is rounding beside the tight span
_DEEP = 3.0  # scaled transition from which its arc is solved as fast from nothing known
_SOLVE_STEPS = 100
NEAREST_TO_CAPACITY = 1e-12
# Of a step in the traction between fixed centres, relative; its error is that of the slope.
_NEAR_ENOUGH = 1e-8
_SECANT_ENOUGH = 1e-7


class MountedBelt(NamedTuple):
    """The belt on both pulleys, before it is loaded."""

    held: float  # what the tensioning holds [N]
    lift: float  # m v^2 [N]
    net: float  # K = EA - m v^2 [N]
    limit: float  # traction at gross slip [-]
    grips: bool  # whether it presses on the pulleys at all
    receiving: PulleyArc
    giving: PulleyArc


class Near(NamedTuple):
    """What a solved state leaves as a start for solving one near by."""

    receiving: ArcState
    giving: ArcState
    tautness: Tautness
    shift: float  # of the traction, between fixed centres, from that at a held mean [-]


UNKNOWN = Near(UNKNOWN_ARC, UNKNOWN_ARC, AS_LINEAR, 0.0)


class Loaded(NamedTuple):
    """Pull, slip and tensions at a traction, with their slopes in it."""

    traction: float  # ln(w_H/w_L) [-]
    pull: float
    pull_slope: float
    slip: float
    slip_slope: float
    slack: float  # T_L [N]
    tight: float  # T_H [N]
    receiving_gradient: float  # u'(0) [-]
    giving_gradient: float
    near: Near


@compiled
def _strain(c: DriveConstants, slack: float, rise: float) -> tuple[float, float, float]:
    """Return the ratio of span speeds v_L/v_H, one minus it, and the inverse of EA + T_H.

    `rise` = T_H - T_L [N] is given, since their difference would lose the digits of a small load.
    """
    base = c.axial_stiffness + (slack if c.exact_strain else 0.0)
    inverse = 1.0 / (base + rise)
    return base * inverse, rise * inverse, inverse


@compiled
def _slip(ratio: float, deficit: float, received: float, given: float) -> float:
    """Slip from the speed ratio of the spans and the inlet gradients of both arcs."""
    if received <= 1.0:
        return (received * ratio - given + deficit) / (1.0 - given)
    # The receiving pulley is pushed backwards. Only its own sliding counts from here on, which
    # keeps slip rising with the pull.
    return 1.0 + (received - 1.0) * ratio


@compiled
def _traction_near(
    c: DriveConstants, belt: MountedBelt, pull: float, most: float, shift: float
) -> float:
    """Traction at a pull, at most `most`; between fixed centres nearly, with `Near.shift`."""
    slack = slack_at_pull(c, pull, belt.held, belt.lift)
    if slack <= 0.0:
        return most
    return min(max(log_one_plus(pull / slack) + shift, 0.0), most)


@compiled
def loaded(c: DriveConstants, belt: MountedBelt, traction: float, near: Near) -> Loaded:
    """Return what a traction amounts to; infinite slip where an arc slides as a whole."""
    lift, net = belt.lift, belt.net
    receiving = loaded_arc(traction, belt.receiving.shape, near.receiving)
    giving = loaded_arc(traction, belt.giving.shape, near.giving)
    growth = math.exp(traction)
    rise = exp_minus_one(traction, growth)
    tautness = near.tautness
    if c.tensioning == FIXED_CENTRES:
        slack, slack_slope, tautness = fixed_centres_slack(
            c,
            traction,
            belt.held,
            lift,
            profile_of(belt.receiving, traction, receiving),
            profile_of(belt.giving, traction, giving),
            tautness,
        )
    else:
        slack, slack_slope = held_slack(c, traction, belt.held, lift)
    pull, pull_slope = slack * rise, slack_slope * rise + slack * growth
    shift = 0.0
    if c.tensioning == FIXED_CENTRES and traction < belt.limit:
        shift = traction - _traction_near(c, belt, pull, belt.limit, 0.0)
    here = Near(receiving, giving, tautness, shift)
    stretch = c.axial_stiffness / net
    t_slack, t_tight = slack + lift, slack + lift + stretch * pull
    loose, tight = slack / net, slack * growth / net
    u_r, u_g = receiving.gradient * loose, -giving.gradient * tight
    creeping = traction < belt.limit and math.isfinite(u_r) and math.isfinite(u_g)
    if not (slack > 0.0 and creeping):
        lost = math.inf
        return Loaded(traction, pull, 0.0, lost, lost, t_slack, t_tight, lost, -lost, here)
    relative = slack_slope / slack
    du_r = receiving.slope * loose + u_r * relative
    du_g = -giving.slope * tight + u_g * (1.0 + relative)
    ratio, deficit, inverse = _strain(c, t_slack, stretch * pull)
    ratio_slope = -ratio * stretch * pull_slope * inverse
    if c.exact_strain:
        ratio_slope += deficit * slack_slope * inverse
    slip = _slip(ratio, deficit, u_r, u_g)
    if u_r <= 1.0:
        drag = 1.0 / (1.0 - u_g)
        slope = (du_r * ratio - (1.0 - u_r) * ratio_slope) * drag
        slope -= (1.0 - u_r) * ratio * drag * drag * du_g
    else:
        slope = du_r * ratio + (u_r - 1.0) * ratio_slope
    return Loaded(traction, pull, pull_slope, slip, slope, t_slack, t_tight, u_r, u_g, here)


@compiled
def belt_on_pulleys(
    c: DriveConstants, tension: float, mu: float, kf: float, speed: float, driven_receives: bool
) -> MountedBelt:
    """Return the belt before it is loaded; parameters as of `creep.creep`."""
    limit = traction_limit(c, mu)
    if c.tensioning == FIXED_CENTRES:  # beyond these, the length of the belt drowns in rounding
        tension, limit = min(tension, _MOST_STRETCHED * c.axial_stiffness), min(limit, _FASTENED)
    lift = c.mass_per_length * speed * speed
    held = tension if c.tensioning == HELD_HUB_LOAD else tension - lift
    net = c.axial_stiffness - lift
    grips = net > 0.0 and held > 0.0
    arcs = both_arcs(c, mu, kf, net if grips else c.axial_stiffness, driven_receives)
    return MountedBelt(tension, lift, net, limit, grips, arcs[0], arcs[1])


@compiled
def _scaled(arc: ArcState, scale: float) -> ArcState:
    """Return a start for an arc like this one, scaled lengths being `scale` times as long."""
    x, rate = arc.transition * scale, arc.rate * scale
    if x > _DEEP:
        return UNKNOWN_ARC
    return ArcState(arc.gradient, arc.slope, x, arc.restick, arc.traction, rate)


@compiled
def near_on(belt: MountedBelt, solved: MountedBelt, near: Near) -> Near:
    """Return what is near on one belt from what is near on another, which `solved` is."""
    if not (solved.grips and math.isfinite(near.shift)):
        return UNKNOWN
    r_scale = belt.receiving.shape.wrap / solved.receiving.shape.wrap
    g_scale = belt.giving.shape.wrap / solved.giving.shape.wrap
    receiving, giving = _scaled(near.receiving, r_scale), _scaled(near.giving, g_scale)
    return Near(receiving, giving, near.tautness, near.shift)


@compiled
def capacity_of(c: DriveConstants, belt: MountedBelt, near: Near) -> float:
    """Effective pull w_H - w_L [N] at gross slip of the pulley that slips first; 0 if lifted off.

    Only between fixed centres does more than mu matter: the other pulley's arc takes its part of
    the belt's length.
    """
    if not belt.grips:
        return 0.0
    limit = min(belt.limit, LARGEST_EXPONENT)
    if c.tensioning != FIXED_CENTRES:
        return held_slack(c, limit, belt.held, belt.lift)[0] * math.expm1(limit)
    return loaded(c, belt, limit, near).pull


@compiled
def loaded_at_pull(c: DriveConstants, belt: MountedBelt, pull: float, near: Near) -> Loaded:
    """State at a pull; that at the traction limit at and beyond the capacity."""
    if c.tensioning != FIXED_CENTRES or pull == 0.0:
        return loaded(c, belt, _traction_near(c, belt, pull, belt.limit, 0.0), near)
    x = _traction_near(c, belt, pull, belt.limit, near.shift)
    state = loaded(c, belt, x, near)
    low, high = 0.0, belt.limit
    # The slope is that of the linear law; how the exact one departs from it shows between states.
    departing, enough = 0.0, _NEAR_ENOUGH
    for _ in range(_SOLVE_STEPS):
        error = state.pull - pull
        if error > 0.0:
            high = x
        else:
            low = x
        candidate = x - error / (state.pull_slope + state.pull * departing)
        if not (low <= candidate <= high):
            candidate = 0.5 * (low + high)
        step, ratio = candidate - x, state.near.tautness.ratio
        x = candidate
        state = loaded(c, belt, x, state.near)
        if abs(step) <= enough * x:
            break
        departing = (state.near.tautness.ratio / ratio - 1.0) / step
        enough = _SECANT_ENOUGH
    return state


@inlined
def loaded_near_pull(c: DriveConstants, belt: MountedBelt, pull: float, near: Near) -> Loaded:
    """State at about a pull [N], below the capacity."""
    most = min(belt.limit, LARGEST_EXPONENT) * (1.0 - NEAREST_TO_CAPACITY)
    return loaded(c, belt, _traction_near(c, belt, max(pull, 0.0), most, near.shift), near)
