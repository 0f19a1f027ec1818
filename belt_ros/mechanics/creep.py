"""Creep of the whole drive: how much slower the receiving pulley runs at a given effective pull.

The power flows from a giving pulley (the driver, unless the load pushes) to a receiving one. On the
receiving pulley tension rises along the arc from slack to tight span, on the giving pulley it falls
back. Mass is conserved round the loop, so with the inlet gradients u' of both arcs (Eq. 11)

    (rim speed received)/(rim speed given) = (1 - u_r')/(1 - u_g') * (1 + T_L/EA)/(1 + T_H/EA)

and creep = 1 - that ratio. Belt inertia is taken at one speed, the driver's rim speed in all that
uses this; the belt's own differs from it by the creep. The effective tensions then differ by
(1 - m v^2/EA) times the pull between either pulley's ends, and both have the same capacity law.

Creep rises with the pull, without bound at the capacity; inverted, pull is therefore defined and
monotone for every creep, gross slip included.

These are the compiled scalar functions that equilibrium, rig and estimator share.
"""

import math
from typing import NamedTuple

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.arc_state import ArcState, arc_state
from belt_ros.mechanics.drive import BeltDrive, Kinematics, Tensioning

_SOLVE_STEPS = 100
_LARGEST_EXPONENT = 500.0
_NEAREST_TO_CAPACITY = 1e-12


class DriveConstants(NamedTuple):
    """A `BeltDrive` as plain numbers for compiled code, SI units."""

    axial_stiffness: float
    mass_per_length: float
    driven_radius: float
    driven_wrap: float
    driven_inertia: float
    driver_radius: float
    driver_wrap: float
    driver_inertia: float
    friction_ratio: float  # mu of the driver over mu of the driven pulley
    stiffness_ratio: float  # kf of the driver over kf of the driven pulley
    span_compliance: float  # change of winding per change of pull, L/(2 EA) [m/N]
    slack_share: float  # fall of slack tension per rise of pull: 1/2 mean held, 0 slack held
    exact_strain: bool


class Creep(NamedTuple):
    """Creep at a pull, and the state of both arcs."""

    slip: float  # of the receiving pulley against the giving one [-]
    slope: float  # d slip / d pull [1/N]
    receiving_transition: float  # transition angle [rad]
    giving_transition: float
    receiving_restick: float  # NaN where there is none
    receiving_gradient: float  # u'(0) [-]
    giving_gradient: float


def drive_constants(drive: BeltDrive) -> DriveConstants:
    """Return `drive` in the form that compiled code takes."""
    return DriveConstants(
        axial_stiffness=drive.belt.axial_stiffness,
        mass_per_length=drive.belt.mass_per_length,
        driven_radius=drive.driven.radius,
        driven_wrap=drive.driven.wrap_angle,
        driven_inertia=drive.driven.inertia,
        driver_radius=drive.driver.radius,
        driver_wrap=drive.driver.wrap_angle,
        driver_inertia=drive.driver.inertia,
        friction_ratio=drive.driver.friction_coefficient / drive.driven.friction_coefficient,
        stiffness_ratio=drive.driver.friction_stiffness / drive.driven.friction_stiffness,
        span_compliance=drive.span_length / (2.0 * drive.belt.axial_stiffness),
        slack_share=0.5 if drive.tensioning is Tensioning.CONSTANT_MEAN else 0.0,
        exact_strain=drive.kinematics is Kinematics.EXACT,
    )


@compiled
def pull_capacity(c: DriveConstants, tension: float, mu: float, speed: float) -> float:
    """Effective pull T_H - T_L [N] at gross slip of the pulley that slips first; 0 if lifted off.

    `tension` [N] is what the tensioning holds, `mu` [-] the driven pulley's, `speed` [m/s].
    """
    lift = c.mass_per_length * speed * speed
    limit = mu * min(c.driven_wrap, c.friction_ratio * c.driver_wrap)
    growth = math.expm1(min(limit, _LARGEST_EXPONENT))
    share = 1.0 - lift / c.axial_stiffness
    if share <= 0.0:
        return 0.0
    return max(growth * (tension - lift) / (share + c.slack_share * growth), 0.0)


class _Contact(NamedTuple):
    """One pulley's contact with the belt."""

    radius: float
    wrap: float
    friction: float
    stiffness: float


class _Strain(NamedTuple):
    """Ratio (1 + T_L/EA)/(1 + T_H/EA), one minus it, and its slope in the pull [1/N]."""

    ratio: float
    deficit: float
    slope: float


@compiled
def _contacts(c: DriveConstants, mu: float, kf: float) -> tuple[_Contact, _Contact]:
    """Return the driven and the driver pulley's contact."""
    driven = _Contact(c.driven_radius, c.driven_wrap, mu, kf)
    return driven, _Contact(
        c.driver_radius, c.driver_wrap, mu * c.friction_ratio, kf * c.stiffness_ratio
    )


@compiled
def _strain(c: DriveConstants, pull: float, slack: float) -> _Strain:
    """Return how strain slows the belt from tight to slack span."""
    ea = c.axial_stiffness
    if not c.exact_strain:
        ratio = ea / (ea + pull)
        return _Strain(ratio, pull / (ea + pull), -ratio / (ea + pull))
    tight = ea + slack + pull
    ratio = (ea + slack) / tight
    slope = (-c.slack_share - ratio * (1.0 - c.slack_share)) / tight
    return _Strain(ratio, pull / tight, slope)


@compiled
def _scaled_arc(contact: _Contact, stiffness: float, ratio: float, role: int) -> ArcState:
    """Solve the arc whose effective tensions differ by a factor 1 + `ratio`; angles in rad."""
    stretch = math.sqrt(contact.stiffness / stiffness) * contact.radius
    state = arc_state(math.log1p(ratio), contact.friction / stretch, stretch * contact.wrap, role)
    return ArcState(
        state.gradient,
        state.slope,
        min(state.transition / stretch, contact.wrap),
        state.restick / stretch,
    )


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
        T_H - T_L >= 0 [N].
    tension : float
        What the tensioning holds constant, mean or slack tension [N].
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
    driven, driver = _contacts(c, mu, kf)
    receiving, giving = (driven, driver) if driven_receives else (driver, driven)
    lift = c.mass_per_length * speed * speed
    stiffness = c.axial_stiffness - lift
    slack = tension - c.slack_share * pull
    rise = stiffness / c.axial_stiffness
    w_slack = slack - lift
    w_tight = w_slack + rise * pull
    if not (stiffness > 0.0 and w_slack > 0.0):
        return Creep(math.inf, math.inf, 0.0, 0.0, math.nan, math.inf, -math.inf)
    ratio = rise * pull / w_slack
    arc_r = _scaled_arc(receiving, stiffness, ratio, 1)
    arc_g = _scaled_arc(giving, stiffness, ratio, -1)
    u_r = arc_r.gradient * w_slack / stiffness
    u_g = -arc_g.gradient * w_tight / stiffness
    if not (math.isfinite(u_r) and math.isfinite(u_g)):
        return Creep(math.inf, math.inf, 0.0, 0.0, math.nan, math.inf, -math.inf)
    tight_slope = rise - c.slack_share
    traction_slope = tight_slope / w_tight + c.slack_share / w_slack
    du_r = (arc_r.slope * traction_slope * w_slack - arc_r.gradient * c.slack_share) / stiffness
    du_g = -(arc_g.slope * traction_slope * w_tight + arc_g.gradient * tight_slope) / stiffness
    strain = _strain(c, pull, slack)
    if u_r <= 1.0:
        drag = 1.0 / (1.0 - u_g)
        slip = (u_r * strain.ratio - u_g + strain.deficit) * drag
        slope = (du_r * strain.ratio - (1.0 - u_r) * strain.slope) * drag
        slope -= (1.0 - u_r) * strain.ratio * drag * drag * du_g
    else:
        # The receiving pulley is pushed backwards. Only its own sliding counts from here on,
        # which keeps slip rising with the pull.
        slip = 1.0 + (u_r - 1.0) * strain.ratio
        slope = du_r * strain.ratio + (u_r - 1.0) * strain.slope
    return Creep(slip, slope, arc_r.transition, arc_g.transition, arc_r.restick, u_r, u_g)


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
    iteration from `start`, kept between bounds that close in on the capacity geometrically.
    """
    if not load > 0.0:
        return 0.0
    capacity = pull_capacity(c, tension, mu, speed)
    low = 0.0
    high = capacity * (1.0 - _NEAREST_TO_CAPACITY)
    if weight > 0.0:
        high = min(high, load / weight)
    if not high > 0.0:
        return 0.0
    # A Newton step doubles the digits: a step this small leaves an error of its square.
    enough = (2e-16 if weight == 0.0 else 1e-7) * capacity
    x = min(max(start, 0.0), high)
    for _ in range(_SOLVE_STEPS):
        state = creep(c, x, tension, mu, kf, speed, driven_receives)
        error = weight * x + state.slip - load
        if error > 0.0:
            high = x
        else:
            low = x
        candidate = x - error / (weight + state.slope)
        if not (math.isfinite(state.slope) and low <= candidate <= high):
            candidate = capacity - math.sqrt((capacity - low) * (capacity - high))
        if abs(candidate - x) <= enough or high - low <= 2e-16 * capacity:
            return min(max(candidate, low), high)
        x = candidate
    return x
