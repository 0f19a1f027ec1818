"""One pulley arc in scaled form, compiled: traction in, inlet gradient and transition out.

The groups and regimes are those of `belt_ros.mechanics.arc`, which is the way in for users.
"""

import math
from typing import NamedTuple

from belt_ros.mechanics._compile import compiled

_NEWTON_STEPS = 60
_BISECTION_STEPS = 200
_NEWTON_ENOUGH = 1e-8


class ArcState(NamedTuple):
    """State of an arc in scaled form, as the compiled functions pass it."""

    gradient: float  # D = K |u'(0)| / w_in [-]
    slope: float  # dD / d traction [-]
    transition: float  # x* [-]
    restick: float  # x2 [-], NaN where the belt does not re-stick


@compiled
def _gradient_at_transition(x: float, a: float, role: int) -> tuple[float, float]:
    """D for which sliding begins at x, and d ln D / dx there.

    Solves D sinh x = a (1 -+ D +- D cosh x), written so that nothing overflows.
    """
    e = math.exp(-x)
    one_minus_e = -math.expm1(-x)
    denominator = one_minus_e * ((1.0 + e) - role * a * one_minus_e)
    log_slope = -(1.0 + e * e - role * a * one_minus_e * (1.0 + e)) / denominator
    return 2.0 * a * e / denominator, log_slope


@compiled
def _two_zone_traction(x: float, a: float, wrap: float, role: int) -> tuple[float, float]:
    """Traction ln(w_H/w_L) of an arc that creeps up to x and slides from there, and its slope in x.

    The slope is negative wherever the two zones are admissible.
    """
    t = math.tanh(0.5 * x)
    held = 1.0 - role * a * t
    traction = a * (wrap - x) - role * math.log1p(-role * a * t)
    return traction, -0.5 * a * (1.0 - role * 2.0 * a * t + t * t) / held


@compiled
def _elastic_arc(traction: float, wrap: float, role: int) -> ArcState:
    """Elastic-only arc: W - 1 = +-D (cosh X - 1)."""
    if wrap < 300.0:
        half_sinh = math.sinh(0.5 * wrap)
        stretch = 2.0 * half_sinh * half_sinh
        inverse = 1.0 / stretch
    else:
        inverse = 2.0 * math.exp(-wrap)
    gradient = role * math.expm1(role * traction) * inverse
    return ArcState(gradient, math.exp(role * traction) * inverse, wrap, math.nan)


@compiled
def _two_zone_arc(traction: float, a: float, wrap: float, role: int) -> ArcState:
    """Creep and slip zone: safeguarded Newton iteration for the transition x*."""
    low, high = 0.0, wrap
    x = (a * wrap - traction) / a
    if not (low < x < high):
        x = 0.5 * wrap
    slope = 0.0
    for _ in range(_NEWTON_STEPS):
        found, slope = _two_zone_traction(x, a, wrap, role)
        error = found - traction
        if error > 0.0:
            low = x
        else:
            high = x
        candidate = x - error / slope
        if not (low <= candidate <= high):
            candidate = 0.5 * (low + high)
        change = abs(candidate - x)
        x = candidate
        # A Newton step doubles the digits, so the one after this would only add rounding.
        if change <= _NEWTON_ENOUGH * x:
            break
    gradient, log_slope = _gradient_at_transition(x, a, role)
    return ArcState(gradient, gradient * log_slope / slope, x, math.nan)


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
    return math.log1p(shortfall / denominator)


@compiled
def _traction_of_gradient(inverse: float, a: float, wrap: float) -> tuple[float, float, float]:
    """Traction, transition and re-stick point of a driven arc with a >= 1 and D = 1/inverse."""
    x1 = _transition_of_gradient(inverse, a)
    if x1 >= wrap:
        half_sinh = math.sinh(0.5 * wrap)
        return math.log1p(2.0 * half_sinh * half_sinh / inverse), wrap, math.nan
    half_sinh = math.sinh(0.5 * x1)
    log_w1 = math.log1p(2.0 * half_sinh * half_sinh / inverse)
    if a == 1.0:
        return log_w1 + a * (wrap - x1), x1, math.nan
    w2 = (1.0 / inverse - 1.0) / ((a - 1.0) * (a + 1.0))
    x2 = x1 + max(math.log(w2) - log_w1, 0.0) / a
    if x2 >= wrap:
        return log_w1 + a * (wrap - x1), x1, math.nan
    rest = wrap - x2
    growth = a * a * math.cosh(rest) + a * math.sinh(rest) - (a - 1.0) * (a + 1.0)
    return math.log(w2) + math.log(growth), x1, x2


@compiled
def _compliant_slope(d: float, a: float, wrap: float, transition: float, restick: float) -> float:
    """Return dD / d traction of a sliding driven arc with a >= 1."""
    transition_slope = 1.0 / (d * _gradient_at_transition(transition, a, 1)[1])
    if math.isnan(restick):
        return 1.0 / (_two_zone_traction(transition, a, wrap, 1)[1] * transition_slope)
    half_sinh = math.sinh(0.5 * transition)
    stretch = 2.0 * half_sinh * half_sinh
    log_w1_slope = (stretch + d * math.sinh(transition) * transition_slope) / (1.0 + d * stretch)
    log_w2_slope = 1.0 / (d - 1.0)
    restick_slope = transition_slope + (log_w2_slope - log_w1_slope) / a
    rest = wrap - restick
    cosh, sinh = math.cosh(rest), math.sinh(rest)
    growth = a * a * cosh + a * sinh - (a - 1.0) * (a + 1.0)
    return 1.0 / (log_w2_slope - restick_slope * (a * a * sinh + a * cosh) / growth)


@compiled
def _compliant_arc(traction: float, a: float, wrap: float) -> ArcState:
    """Driven arc with a >= 1: solve for 1/D, in which the traction falls monotonically."""
    critical = math.atanh(1.0 / a) if a > 1.0 else math.inf
    if critical < wrap:
        largest = 1.0 / (a * (a + math.sqrt((a - 1.0) * (a + 1.0))))
    else:
        largest = 1.0 / _gradient_at_transition(wrap, a, 1)[0]
    at_largest = _traction_of_gradient(largest, a, wrap)[0]
    if traction <= at_largest:
        return _elastic_arc(traction, wrap, 1)
    low, high = 0.0, largest
    # Near gross slip the traction falls short of its limit in proportion to 1/D.
    x = largest * (a * wrap - traction) / (a * wrap - at_largest)
    slope, transition, restick = math.inf, 0.0, math.nan
    for _ in range(_BISECTION_STEPS):
        found, transition, restick = _traction_of_gradient(x, a, wrap)
        error = found - traction
        if error > 0.0:
            low = x
        else:
            high = x
        slope = _compliant_slope(1.0 / x, a, wrap, transition, restick)
        candidate = x + error * x * x * slope
        if not (low <= candidate <= high):  # also where the slope is not finite
            candidate = 0.5 * (low + high)
        change = abs(candidate - x)
        x = candidate
        if change <= _NEWTON_ENOUGH * x:
            break
    _, transition, restick = _traction_of_gradient(x, a, wrap)
    return ArcState(1.0 / x, slope, transition, restick)


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
    if traction >= a * wrap:
        return ArcState(math.inf, math.inf, 0.0, math.nan)
    if role > 0 and a >= 1.0:
        return _compliant_arc(traction, a, wrap)
    if traction <= _two_zone_traction(wrap, a, wrap, role)[0]:
        return _elastic_arc(traction, wrap, role)
    return _two_zone_arc(traction, a, wrap, role)
