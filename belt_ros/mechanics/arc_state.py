"""One pulley arc in scaled form, compiled: traction in, inlet gradient and transition out.

The groups and regimes are those of `belt_ros.mechanics.arc`, which is the way in for users.
"""

import math
from typing import NamedTuple

from belt_ros.mechanics._compile import compiled, inlined
from belt_ros.mechanics.exponentials import exp_minus_one, log_one_plus

_NEWTON_STEPS = 60
_BISECTION_STEPS = 200
_NEWTON_ENOUGH = 1e-8
_HALLEY_ENOUGH = 3e-5


class ArcShape(NamedTuple):
    """What of an arc its load does not change."""

    role: int  # +1 driven, -1 driver
    growth: float  # a
    wrap: float  # X
    inverse_stretch: float  # 1 / (cosh X - 1)
    elastic_limit: float  # traction up to which the whole arc creeps [-]
    elastic_inverse: float  # 1/D at it, where a driven arc has a >= 1 [-]


class ArcState(NamedTuple):
    """State of an arc in scaled form, as the compiled functions pass it."""

    gradient: float  # D = K |u'(0)| / w_in [-]
    slope: float  # dD / d traction [-]
    transition: float  # x* [-]
    restick: float  # x2 [-], NaN where the belt does not re-stick
    traction: float  # at which it was solved [-]
    rate: float  # d x* / d traction where the belt slides to the outlet [-]


UNKNOWN_ARC = ArcState(math.nan, math.nan, math.nan, math.nan, math.nan, 0.0)


@compiled
def _gradient_at_transition(x: float, a: float, role: int) -> tuple[float, float]:
    """D for which sliding begins at x, and d ln D / dx there.

    Solves D sinh x = a (1 -+ D +- D cosh x), written so that nothing overflows.
    """
    e = math.exp(-x)
    one_minus_e = -exp_minus_one(-x, e)
    denominator = one_minus_e * ((1.0 + e) - role * a * one_minus_e)
    log_slope = -(1.0 + e * e - role * a * one_minus_e * (1.0 + e)) / denominator
    return 2.0 * a * e / denominator, log_slope


@compiled
def _two_zone_traction(x: float, a: float, wrap: float, role: int) -> tuple[float, float]:
    """Traction ln(w_H/w_L) of an arc that creeps up to x and slides from there, and its slope in x.

    The slope is negative wherever the two zones are admissible.
    """
    e = math.exp(-x)
    t = -exp_minus_one(-x, e) / (1.0 + e)  # tanh(x/2)
    held = 1.0 - role * a * t
    traction = a * (wrap - x) - role * log_one_plus(-role * a * t)
    return traction, -0.5 * a * (1.0 - role * 2.0 * a * t + t * t) / held


@compiled
def _elastic_arc(traction: float, shape: ArcShape) -> ArcState:
    """Elastic-only arc: W - 1 = +-D (cosh X - 1)."""
    risen = shape.role * traction
    growth = math.exp(risen)
    gained = exp_minus_one(risen, growth)
    slope = growth * shape.inverse_stretch
    gradient = shape.role * gained * shape.inverse_stretch
    return ArcState(gradient, slope, shape.wrap, math.nan, traction, 0.0)


@compiled
def _two_zone_arc(traction: float, shape: ArcShape, start: float) -> ArcState:
    """Creep and slip zone: safeguarded Halley iteration for the transition x*.

    The error of `_two_zone_traction` is +-ln r, r = e^E / (1 -+ a tanh(x/2)), E = +-(a (X - x) -
    traction). Near r = 1 it is +-2 (r - 1)/(r + 1), up to the third power of r - 1, which needs no
    logarithm that waits for the exponentials.
    """
    role, a, wrap = shape.role, shape.growth, shape.wrap
    low, high, x = 0.0, wrap, start
    if not (low < x < high):
        x = wrap - (traction + role * log_one_plus(-role * a)) / a  # were tanh one
    if not (low < x < high):
        x = min(2.0 * (a * wrap - traction) / a, 0.5 * wrap)  # near gross slip
    twice = 2.0 / a
    e, one_minus_e = 0.0, 0.0
    for _ in range(_NEWTON_STEPS):
        e = math.exp(-x)
        one_minus_e = -exp_minus_one(-x, e)
        excess = a * (wrap - x) - traction
        push = exp_minus_one(role * excess, math.exp(role * excess))
        t = one_minus_e / (1.0 + e)
        held = 1.0 - role * a * t
        error = 2.0 * (a * t + role * push) / (held + 1.0 + push)
        if not abs(error) < 0.5:
            error = excess - role * math.log(held)
        rise = 0.5 * (1.0 - t) * (1.0 + t)
        steepness = 1.0 - role * 2.0 * a * t + t * t
        inverse = 1.0 / (held * steepness)  # one division for all: they are what takes time here
        if error > 0.0:
            low = x
        else:
            high = x
        newton = error * twice * held * held * inverse
        bent = rise * (t - role * a * rise * steepness * inverse) * held * inverse
        step = newton / min(max(1.0 + newton * bent, 0.5), 2.0)
        if not (low <= x + step <= high):
            step = 0.5 * (low + high) - x
        x += step
        # Such a step triples the digits, so the one after this would only add rounding.
        if abs(step) <= _HALLEY_ENOUGH * min(x, 1.0):
            shrink = step * (1.0 - 0.5 * step * (1.0 - step / 3.0))  # 1 - e^-step
            one_minus_e += e * shrink
            e -= e * shrink
            break
    t = one_minus_e / (1.0 + e)
    held = 1.0 - role * a * t
    rate = -twice * held / (1.0 - role * 2.0 * a * t + t * t)
    inverse = 1.0 / (one_minus_e * (1.0 + e) * held)
    gradient = 2.0 * a * e * inverse
    log_slope = -(1.0 + e * e - role * a * one_minus_e * (1.0 + e)) * inverse
    return ArcState(gradient, gradient * log_slope * rate, x, math.nan, traction, rate)


@compiled
def _transition_of_gradient(inverse: float, a: float) -> float:
    """Least x where a driven arc of gradient D = 1/inverse begins to slide; inf if nowhere.

    The condition is a quadratic in e^x; written for its smaller root so that x stays accurate
    near gross slip, where e^x is 1 + a/D.
    """
    excess = 2.0 * a * a * inverse - a * a * inverse * inverse
    if excess > 1.0:
        return math.inf
    root = math.sqrt(1.0 - excess)
    denominator = a - a * inverse + root
    if denominator <= 0.0:
        return math.inf
    shortfall = a * inverse + excess / (1.0 + root)  # 1 + a - denominator
    return log_one_plus(shortfall / denominator)


@compiled
def _zones(inverse: float, a: float, wrap: float) -> tuple[float, float, float, float]:
    """Transition x1, re-stick point x2, cosh x1 - 1 and ln W(x1); a >= 1 and D = 1/inverse.

    x1 is X where nothing slides, x2 is NaN where nothing re-sticks.
    """
    x1 = min(_transition_of_gradient(inverse, a), wrap)
    half_sinh = math.sinh(0.5 * x1)
    stretch = 2.0 * half_sinh * half_sinh
    log_w1 = log_one_plus(stretch / inverse)
    if x1 >= wrap or a == 1.0:
        return x1, math.nan, stretch, log_w1
    w2 = (1.0 / inverse - 1.0) / ((a - 1.0) * (a + 1.0))
    x2 = x1 + max(math.log(w2) - log_w1, 0.0) / a
    return x1, x2 if x2 < wrap else math.nan, stretch, log_w1


@compiled
def _traction_of_gradient(inverse: float, a: float, wrap: float) -> tuple[float, float]:
    """Traction of a driven arc with a >= 1 and D = 1/inverse, and d traction / dD."""
    d = 1.0 / inverse
    x1, x2, stretch, log_w1 = _zones(inverse, a, wrap)
    if x1 >= wrap:
        return log_w1, stretch / (1.0 + d * stretch)
    x1_slope = inverse / _gradient_at_transition(x1, a, 1)[1]
    if math.isnan(x2):
        return log_w1 + a * (wrap - x1), _two_zone_traction(x1, a, wrap, 1)[1] * x1_slope
    w2 = (d - 1.0) / ((a - 1.0) * (a + 1.0))
    rest = wrap - x2
    cosh, sinh, half = math.cosh(rest), math.sinh(rest), a * math.sinh(0.5 * rest)
    growth = 2.0 * half * half + a * sinh  # a^2 (cosh - 1) + a sinh: large a would lose digits
    log_w1_slope = (stretch + d * math.sinh(x1) * x1_slope) / (1.0 + d * stretch)
    log_w2_slope = 1.0 / (d - 1.0)
    x2_slope = x1_slope + (log_w2_slope - log_w1_slope) / a
    slope = log_w2_slope - x2_slope * (a * a * sinh + a * cosh) / (1.0 + growth)
    return math.log(w2) + log_one_plus(growth), slope


@compiled
def _compliant_arc(traction: float, shape: ArcShape, start: float) -> ArcState:
    """Sliding driven arc with a >= 1: solve for 1/D, in which the traction falls monotonically."""
    a, wrap = shape.growth, shape.wrap
    largest, at_largest = shape.elastic_inverse, shape.elastic_limit
    low, high, x = 0.0, largest, start
    if not (low < x < high):
        # Near gross slip the traction falls short of its limit in proportion to 1/D.
        x = largest * (a * wrap - traction) / (a * wrap - at_largest)
    slope = math.inf
    for _ in range(_BISECTION_STEPS):
        found, rate = _traction_of_gradient(x, a, wrap)
        error = found - traction
        if error > 0.0:
            low = x
        else:
            high = x
        slope = 1.0 / rate
        candidate = x + error * x * x * slope
        if not (low <= candidate <= high):  # also where the slope is not finite
            candidate = 0.5 * (low + high)
        change = abs(candidate - x)
        x = candidate
        if change <= _NEWTON_ENOUGH * x:
            break
    transition, restick, _, _ = _zones(x, a, wrap)
    return ArcState(1.0 / x, slope, transition, restick, traction, 0.0)


@compiled
def arc_shape(a: float, wrap: float, role: int) -> ArcShape:
    """Return what an arc's load does not change; parameters as of `arc_state`."""
    e = math.exp(-wrap)
    one_minus_e = -exp_minus_one(-wrap, e)
    inverse_stretch = 2.0 * e / (one_minus_e * one_minus_e)
    if role < 0 or a < 1.0:
        limit = _two_zone_traction(wrap, a, wrap, role)[0]
        return ArcShape(role, a, wrap, inverse_stretch, limit, math.nan)
    # All of it creeps up to the least D at which the limit is met, inside the arc or at its outlet.
    critical = math.atanh(1.0 / a) if a > 1.0 else math.inf
    if critical < wrap:
        inverse = 1.0 / (a * (a + math.sqrt((a - 1.0) * (a + 1.0))))
    else:
        inverse = 1.0 / _gradient_at_transition(wrap, a, 1)[0]
    limit = log_one_plus(1.0 / (inverse * inverse_stretch))
    return ArcShape(role, a, wrap, inverse_stretch, limit, inverse)


@inlined
def loaded_arc(traction: float, shape: ArcShape, near: ArcState) -> ArcState:
    """Solve an arc from the state `near`, of the same arc or one like it, or `UNKNOWN_ARC`."""
    if traction >= shape.growth * shape.wrap:
        return ArcState(math.inf, math.inf, 0.0, math.nan, traction, 0.0)
    if traction <= shape.elastic_limit:
        return _elastic_arc(traction, shape)
    if shape.role > 0 and shape.growth >= 1.0:
        return _compliant_arc(traction, shape, 1.0 / near.gradient)
    start = near.transition + near.rate * (traction - near.traction)
    return _two_zone_arc(traction, shape, start)


@compiled
def arc_state(traction: float, a: float, wrap: float, role: int) -> ArcState:
    """Solve one arc in scaled form.

    Parameters
    ----------
    traction : float
        ln(w_H/w_L) >= 0 between its two ends [-].
    a, wrap : float
        The groups a and X of the module's docstring [-].
    role : int
        +1 driven, -1 driver.

    Returns
    -------
    ArcState
        D is inf at and beyond the traction limit a X.
    """
    return loaded_arc(traction, arc_shape(a, wrap, role), UNKNOWN_ARC)
