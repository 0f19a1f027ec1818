"""What goes on along a solved arc, and what it sums up to, compiled; scaled as in `arc`.

With W = w/w_in and the scaled distance x = lambda s from the inlet, an arc of gradient D has

    elastic creep   W = 1 +- D (cosh x - 1)                 friction/(lambda w_in) = D sinh x
    sliding         W = W* exp(+- a (x - x*))               friction/(lambda w_in) = a W
    stuck again     W = 1 - D + W2 (a^2 cosh y + a sinh y)  y = x - x2

(upper sign driven, lower driver), and everywhere the belt's displacement relative to the pulley has
the gradient u'(x) K/w_in = +-(D +- (W - 1)). All three pieces join with equal slopes, so that the
derivative of any integral with respect to D needs no account of where the zones end.

D underflows where friction is stiff; the elastic zone is therefore written by what the tension
gains over it, D (cosh x* - 1), which does not.
"""

import math
from typing import NamedTuple

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.arc_state import UNKNOWN_ARC, ArcShape, ArcState, arc_shape, loaded_arc

_SMALL = 0.5
_LEAST_GRADIENT = 1e-290


class ScaledArc(NamedTuple):
    """A solved arc with the groups that it was solved for."""

    role: int  # +1 driven, -1 driver
    growth: float  # a
    wrap: float  # X = lambda R phi
    unit: float  # 1/lambda [m], the length of x = 1
    begin: float  # where sliding begins, X if nowhere
    end: float  # where sliding ends, X if not before the outlet
    gain: float  # |W - 1| where sliding begins
    state: ArcState


class PointState(NamedTuple):
    """State of the belt at one point of an arc, scaled; the last three positive."""

    tension: float  # W
    stretch: float  # of the friction spring: friction over lambda w_in
    displacement: float  # |u| lambda K / w_in
    gradient: float  # |u'| K / w_in


class PulleyArc(NamedTuple):
    """An arc before it is loaded."""

    unit: float  # 1/lambda [m], the length of x = 1
    wrap_angle: float  # [rad]
    shape: ArcShape


@compiled
def pulley_arc(
    radius: float, wrap_angle: float, mu: float, kf: float, net: float, role: int
) -> PulleyArc:
    """Return the arc of one pulley in scaled form; `net` is K = EA - m v^2 [N]."""
    unit = math.sqrt(net / kf)
    shape = arc_shape(mu * unit / radius, radius * wrap_angle / unit, role)
    return PulleyArc(unit, wrap_angle, shape)


@compiled
def profile_of(arc: PulleyArc, traction: float, state: ArcState) -> ScaledArc:
    """Return an arc solved at a traction ln(w_H/w_L), with where its zones end."""
    role, growth, wrap = arc.shape.role, arc.shape.growth, arc.shape.wrap
    # Within rounding of gross slip D is without bound, though the transition may not be at 0 yet.
    begin = min(state.transition, wrap) if math.isfinite(state.gradient) else 0.0
    end = wrap if math.isnan(state.restick) else min(state.restick, wrap)
    if begin < wrap:
        held = growth * math.tanh(0.5 * begin)
        gain = held / (1.0 - role * held)
    else:
        gain = abs(math.expm1(role * traction))
    return ScaledArc(role, growth, wrap, arc.unit, begin, end, gain, state)


@compiled
def scaled_arc(
    traction: float, radius: float, wrap_angle: float, mu: float, kf: float, net: float, role: int
) -> ScaledArc:
    """Solve an arc at a traction ln(w_H/w_L), see `arc_state`; `net` is K = EA - m v^2 [N]."""
    arc = pulley_arc(radius, wrap_angle, mu, kf, net, role)
    return profile_of(arc, traction, loaded_arc(traction, arc.shape, UNKNOWN_ARC))


@compiled
def point_state(arc: ScaledArc, x: float) -> PointState:
    """State at the scaled distance `x` from the inlet, 0 <= x <= X."""
    role, a, d = arc.role, arc.growth, arc.state.gradient
    tension, stretch, displacement, gradient = 1.0, a, 0.0, d
    if arc.begin > 0.0:
        near = min(x, arc.begin)
        held = arc.gain * math.exp(near - arc.begin) / math.expm1(-arc.begin) ** 2
        tension = 1.0 + role * held * math.expm1(-near) ** 2
        displacement = stretch = -held * math.expm1(-2.0 * near)
        gradient = held * (1.0 + math.exp(-2.0 * near))
    if x > arc.begin:
        slid = min(x, arc.end) - arc.begin
        growth = math.expm1(role * a * slid)
        displacement += (d - role) * slid + tension * growth / a
        tension *= 1.0 + growth
        stretch = a * tension
    if x > arc.end:
        past = x - arc.end
        again = tension * (a * a * math.sinh(past) + a * math.cosh(past)) - stretch
        tension = 1.0 - d + tension * (a * a * math.cosh(past) + a * math.sinh(past))
        stretch += again
        displacement += again
    if x > arc.begin:
        gradient = d + role * (tension - 1.0)
    return PointState(tension, stretch, displacement, gradient)


@compiled
def _sinh_lag(x: float) -> float:
    """Return (sinh x - x) / (cosh x - 1) for x > 0, without cancellation or overflow."""
    if x < _SMALL:
        q = x * x
        lag = 1.0 + q / 20.0 * (1.0 + q / 42.0 * (1.0 + q / 72.0 * (1.0 + q / 110.0)))
        half = math.sinh(0.5 * x) / (0.5 * x)
        return x / 3.0 * lag / (half * half)
    e = math.exp(-x)
    return ((1.0 - e) * (1.0 + e) - 2.0 * x * e) / (1.0 - e) ** 2


@compiled
def excess(arc: ScaledArc) -> tuple[float, float]:
    """Integral of W - 1 over the arc in x, and its slope in the traction."""
    role, a, d = arc.role, arc.growth, arc.state.gradient
    total = slope = relative_slope = 0.0  # slopes are those in ln D
    tension = 1.0
    if arc.begin > 0.0:
        total = slope = role * arc.gain * _sinh_lag(arc.begin)
        tension = 1.0 + role * arc.gain
        relative_slope = role * arc.gain / tension
    slid = arc.end - arc.begin
    sliding = role * tension * math.expm1(role * a * slid) / a
    total += sliding - slid
    slope += relative_slope * sliding
    past = arc.wrap - arc.end
    if past > 0.0:
        tension *= math.exp(role * a * slid)
        sinh, half = math.sinh(past), math.sinh(0.5 * past)
        pushed = 2.0 * a * half * half
        total += tension * (a * a * sinh + pushed) - d * past
        slope += relative_slope * tension * (sinh + pushed) + d * (sinh - past)
    if slope == 0.0:  # the whole arc slides; its slope in ln D, which is without bound
        return total, 0.0
    log_slope = arc.state.slope / d if d > _LEAST_GRADIENT else 1.0 / a
    return total, slope * log_slope


@compiled
def _relaxed_cosh(first: float, q: float, x: float, rise: float) -> float:
    """Integral of 1 / (first + q (cosh x - 1)) from 0 to x; `rise` is q (e^x - 1).

    The primitive by logarithms keeps its digits at large x; where q is large it has none, and the
    one by the half-angle has, x being small there.
    """
    if abs(q) < _SMALL * first:
        root = math.sqrt(first * (first - 2.0 * q))
        ratio = q / (first - q + root)
        near = math.log1p(ratio * math.exp(-x)) - math.log1p(ratio)
        return (x + near - math.log1p(rise / (first + root))) / root
    t = math.tanh(0.5 * x)
    z = (first - 2.0 * q) / first * t * t
    if abs(z) < 1e-4:
        return 2.0 * t / first * (1.0 + z / 3.0 + z * z / 5.0 + z * z * z / 7.0)
    root = math.sqrt(abs(z))
    return 2.0 * t / first * (math.atanh(root) if z > 0.0 else math.atan(root)) / root


@compiled
def relaxed_length(arc: ScaledArc, strain: float, grip: float) -> float:
    """Integral of 1 / (1 + T/EA) over the arc in x: how much belt, unstretched, lies on it.

    `strain` is T/EA and `grip` w/K at the inlet [-]; along the arc T/EA = strain + grip (W - 1).
    """
    role, a, d = arc.role, arc.growth, arc.state.gradient
    base = 1.0 + strain - grip
    total, tension = 0.0, 1.0
    if arc.begin > 0.0:
        tension = 1.0 + role * arc.gain
        amplitude = role * grip * d
        rise = -2.0 * role * grip * arc.gain / math.expm1(-arc.begin)
        total = _relaxed_cosh(base + grip, amplitude, arc.begin, rise)
    slid = arc.end - arc.begin
    growth = grip * tension * math.expm1(role * a * slid)
    total += (slid - role * math.log1p(growth / (base + grip * tension)) / a) / base
    past = arc.wrap - arc.end
    if past > 0.0:
        # a^2 cosh y + a sinh y is one cosine hyperbolicus, shifted.
        shift = math.atanh(1.0 / a)
        amplitude = grip * tension * math.exp(role * a * slid)
        amplitude *= a * math.sqrt((a - 1.0) * (a + 1.0))
        first = base + grip * (1.0 - d) + amplitude
        for sign, x in ((1.0, shift + past), (-1.0, shift)):
            total += sign * _relaxed_cosh(first, amplitude, x, amplitude * math.expm1(x))
    return total
