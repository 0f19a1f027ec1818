"""What the tensioning makes of the tensions: effective slack tension at a traction, compiled.

The traction ln(w_H/w_L) fixes the shape of both arcs. The tensions' level follows from what the
installation holds: explicitly for a held mean or slack tension or hub load; with fixed centres from
the belt's unstretched length, which stays,

    loop integral of ds / (1 + T/EA) = path / (1 + T_installed/EA)

(`Kinematics.LINEAR`: loop integral of T ds = path T_installed). Tension is low or high over most of
an arc and changes near its outlet, faster where it is higher; so a fixed loop pulls tighter under
load, and T_H + T_L rises with the torque.
"""

import math
from typing import NamedTuple

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.arc_profile import ScaledArc, excess, relaxed_length
from belt_ros.mechanics.constants import (
    FIXED_CENTRES,
    HELD_HUB_LOAD,
    HELD_MEAN,
    DriveConstants,
)
from belt_ros.mechanics.exponentials import exp_minus_one

_SECANT_STEPS = 20
_LEAST_RATE, _MOST_RATE = 0.02, 50.0  # times that of the linear law: others are rounding
_NO_TAUTER = 1.0 + 1e-6  # times the unloaded tension; the slack span is below it
_NEAR = 1e-7  # relative change after which a rate from near by leaves an error below 1e-10


class Tautness(NamedTuple):
    """How the exact law of fixed centres differs from the linear one; nearly the same near by."""

    ratio: float  # of the slack tensions
    rate: float  # of the changes of length with slack tension; NaN if not known


AS_LINEAR = Tautness(1.0, math.nan)


@compiled
def slack_at_pull(c: DriveConstants, pull: float, held: float, lift: float) -> float:
    """Effective slack tension w_L [N] at an effective pull w_H - w_L [N], not for fixed centres.

    `held` [N] is what the tensioning holds, `lift` = m v^2 [N].
    """
    if c.tensioning == HELD_HUB_LOAD:
        return held - 0.5 * pull
    if c.tensioning in (HELD_MEAN, FIXED_CENTRES):
        return held - lift - 0.5 * pull / (1.0 - lift / c.axial_stiffness)
    return held - lift


@compiled
def held_slack(c: DriveConstants, traction: float, held: float, lift: float) -> tuple[float, float]:
    """Effective slack tension w_L [N] at a traction, and its slope; not for fixed centres."""
    growth = math.exp(traction)
    if c.tensioning == HELD_HUB_LOAD:
        slack = 2.0 * held / (1.0 + growth)
        return slack, -slack * growth / (1.0 + growth)
    if c.tensioning == HELD_MEAN:
        share = 1.0 - lift / c.axial_stiffness
        shape = 1.0 + 0.5 * (growth - 1.0) / share
        slack = (held - lift) / shape
        return slack, -0.5 * slack * growth / (share * shape)
    return held - lift, 0.0


@compiled
def slack_at_traction(
    c: DriveConstants,
    traction: float,
    held: float,
    lift: float,
    receiving: ScaledArc,
    giving: ScaledArc,
) -> tuple[float, float]:
    """Effective slack tension w_L [N] at a traction, and its slope.

    With fixed centres and exact strain the slope is that of the linear law, to first order.
    """
    if c.tensioning != FIXED_CENTRES:
        return held_slack(c, traction, held, lift)
    slack, slope, _ = fixed_centres_slack(c, traction, held, lift, receiving, giving, AS_LINEAR)
    return slack, slope


@compiled
def fixed_centres_slack(
    c: DriveConstants,
    traction: float,
    held: float,
    lift: float,
    receiving: ScaledArc,
    giving: ScaledArc,
    near: Tautness,
) -> tuple[float, float, Tautness]:
    """As `slack_at_traction`, from the tautness at a state near by; also the tautness here."""
    share = 1.0 - lift / c.axial_stiffness
    growth = math.exp(traction)
    rise = exp_minus_one(traction, growth)
    received, received_slope = excess(receiving)
    given, given_slope = excess(giving)
    path = 2.0 * c.span_length + receiving.wrap * receiving.unit + giving.wrap * giving.unit
    # Loop integral of w/w_L - 1.
    gained = receiving.unit * received + c.span_length * rise
    gained += giving.unit * (growth * given + rise * giving.wrap)
    gained_slope = receiving.unit * received_slope + c.span_length * growth
    gained_slope += giving.unit * growth * (given + given_slope + giving.wrap)
    # Where contact is absurdly soft or belts are absurdly stiff, rounding leaves nothing of these.
    gained = _within(gained, rise * path)
    gained_slope = _within(gained_slope, growth * path)
    shape = 1.0 + gained / (share * path)
    slack = (held - lift) / shape
    slope = -gained_slope / (share * path * shape)
    if c.exact_strain and slack > 0.0:
        slack, near = _refined(c, slack, held, lift, growth, shape, receiving, giving, near)
    return slack, slack * slope, near


@compiled
def _within(value: float, most: float) -> float:
    """Return a value between 0 and `most` where it is; half of that for what is no number."""
    if math.isnan(value):
        return 0.5 * most
    return min(max(value, 0.0), most)


@compiled
def _refined(
    c: DriveConstants,
    linear: float,
    held: float,
    lift: float,
    growth: float,
    shape: float,
    receiving: ScaledArc,
    giving: ScaledArc,
    near: Tautness,
) -> tuple[float, Tautness]:
    """Slack tension at which the unstretched length is the installed one, from the linear law's."""
    ea = c.axial_stiffness
    path = 2.0 * c.span_length + receiving.wrap * receiving.unit + giving.wrap * giving.unit
    installed = path / (1.0 + held / ea)
    linear_rate = -shape * path / (ea * (1.0 + held / ea) ** 2)
    known = not math.isnan(near.rate)
    rate = linear_rate * (near.rate if known else 1.0)
    slack = linear * near.ratio
    before, error_before = slack, 0.0
    for step in range(_SECANT_STEPS):
        error = _unstretched(c, slack, lift, growth, receiving, giving) - installed
        # A difference that rounding has eaten says nothing of the rate.
        if step > 0 and abs(slack - before) > _NEAR * slack:
            found = (error - error_before) / (slack - before)
            if _LEAST_RATE < found / linear_rate < _MOST_RATE:
                rate, known = found, True
        before, error_before = slack, error
        slack = max(slack - error / rate, 0.5 * slack)
        # The error is this times that of the rate, which after a secant is nearly this as well.
        if abs(slack - before) <= (_NEAR if known else 1e-9) * slack:
            break
    if not 0.0 < slack <= _NO_TAUTER * (held - lift):  # rounding has eaten the lengths
        return linear, AS_LINEAR
    return slack, Tautness(slack / linear, rate / linear_rate if known else math.nan)


@compiled
def _unstretched(
    c: DriveConstants,
    slack: float,
    lift: float,
    growth: float,
    receiving: ScaledArc,
    giving: ScaledArc,
) -> float:
    """Unstretched length [m] of the belt in the loop at an effective slack tension."""
    ea = c.axial_stiffness
    net = ea - lift
    tight = slack * growth
    slack_strain = (slack + lift) / ea
    tight_strain = slack_strain + (tight - slack) / net
    return (
        c.span_length / (1.0 + slack_strain)
        + c.span_length / (1.0 + tight_strain)
        + receiving.unit * relaxed_length(receiving, slack_strain, slack / net)
        + giving.unit * relaxed_length(giving, tight_strain, tight / net)
    )
