"""One pulley arc in equilibrium under EPP friction: tensions in, transition and slip out.

All of Eqs. 47-60 collapse to two groups and one unknown. With lambda = sqrt(kf/K),
K = EA - m v^2, the arc is described by

    a = mu / (R lambda)                 how fast the Coulomb limit grows against the spring
    X = lambda R phi                    wrap angle in stretch lengths

and everything along it is explicit in the dimensionless inlet strain gradient
D = K |u'(0)| / w_in, where w = T - m v^2 is the effective tension. A scaled distance x = lambda s
runs from the inlet; the elastic creep zone ends at the transition x*.

Regimes of a driven arc (tension rises from inlet to outlet):

* elastic only: the friction spring never meets the Coulomb limit;
* partial slip: elastic creep up to x*, sliding beyond it;
* re-stick, only for a > 1: elastic, sliding, and elastic again from x2, because far from the
  inlet the limit outgrows the spring.

A driver arc (tension falls) has the first two regimes only. As D grows without bound, x* goes to
zero and the traction ln(w_H/w_L) to its limit mu phi = a X: gross slip.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.drive import DriveError

_NEWTON_STEPS = 60
_BISECTION_STEPS = 200
_NEWTON_ENOUGH = 1e-8


class Role(IntEnum):
    """Sense of the tension along the arc, in the direction of belt travel."""

    DRIVEN = 1  # tension rises
    DRIVER = -1  # tension falls


class ArcState(NamedTuple):
    """State of an arc in scaled form, as the compiled functions pass it."""

    gradient: float  # D = K |u'(0)| / w_in [-]
    slope: float  # dD / d traction [-]
    transition: float  # x* [-]
    restick: float  # x2 [-], NaN where the belt does not re-stick


class ArcSolution(NamedTuple):
    """Equilibrium of pulley arcs, arrays of one common shape.

    Attributes
    ----------
    transition_angle : ndarray
        theta* [rad] from the inlet, where sliding begins; the wrap angle if it never does.
    restick_angle : ndarray
        Angle [rad] from the inlet where sliding ends again; NaN if it does not (always for a < 1).
    inlet_strain_gradient : ndarray
        u'(0) [-], positive on a driven arc, negative on a driver arc.
    elastic_only : ndarray of bool
        Whether the Coulomb limit is nowhere reached.
    """

    transition_angle: NDArray[np.float64]
    restick_angle: NDArray[np.float64]
    inlet_strain_gradient: NDArray[np.float64]
    elastic_only: NDArray[np.bool_]


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


@compiled
def _solve_many(groups: NDArray[np.float64], roles: NDArray[np.int64]) -> NDArray[np.float64]:
    """Rows (traction, a, X) to rows (D, x*, x2)."""
    out = np.empty((groups.shape[0], 3))
    for i in range(groups.shape[0]):
        state = arc_state(groups[i, 0], groups[i, 1], groups[i, 2], roles[i])
        out[i, 0] = state.gradient
        out[i, 1] = state.transition
        out[i, 2] = state.restick
    return out


def _first_bad(bad: NDArray[np.bool_], *values: NDArray[np.float64]) -> tuple[float, ...]:
    index = int(np.flatnonzero(bad)[0])
    return tuple(float(value.flat[index]) for value in values)


def solve_arc(
    role: ArrayLike,
    radius: ArrayLike,
    wrap_angle: ArrayLike,
    friction_coefficient: ArrayLike,
    friction_stiffness: ArrayLike,
    axial_stiffness: ArrayLike,
    mass_per_length: ArrayLike,
    inlet_speed: ArrayLike,
    inlet_tension: ArrayLike,
    outlet_tension: ArrayLike,
) -> ArcSolution:
    """Equilibrium of pulley arcs with given tensions at both ends, Eqs. 47-60.

    All arguments broadcast against each other.

    Parameters
    ----------
    role : array_like of Role
        +1 where tension rises along the arc, -1 where it falls.
    radius, wrap_angle : array_like
        R [m], phi [rad].
    friction_coefficient, friction_stiffness : array_like
        mu [-], kf [N/m2].
    axial_stiffness, mass_per_length : array_like
        EA [N], m [kg/m].
    inlet_speed : array_like
        Belt speed at the inlet [m/s].
    inlet_tension, outlet_tension : array_like
        T at either end [N].

    Returns
    -------
    ArcSolution

    Raises
    ------
    DriveError
        For a parameter that is not positive, a belt above its critical speed or lifted off by
        inertia, tensions against the role, or a tension ratio beyond the friction capacity.
    """
    arrays = np.broadcast_arrays(
        *(
            np.asarray(value, dtype=np.float64)
            for value in (
                role,
                radius,
                wrap_angle,
                friction_coefficient,
                friction_stiffness,
                axial_stiffness,
                mass_per_length,
                inlet_speed,
                inlet_tension,
                outlet_tension,
            )
        )
    )
    sigma, r, phi, mu, kf, ea, m, v, t_in, t_out = arrays
    _check_positive(("radius", r), ("wrap angle", phi), ("friction coefficient mu", mu))
    _check_positive(("friction stiffness kf", kf), ("axial stiffness EA", ea))
    if np.any(bad := ~np.isin(sigma, (Role.DRIVEN, Role.DRIVER))):
        raise DriveError(f"role is {_first_bad(bad, sigma)[0]:g}; it must be 1 or -1")
    if np.any(bad := ~(np.isfinite(m) & (m >= 0.0))):
        raise DriveError(
            f"mass per length is {_first_bad(bad, m)[0]:g}; it must be finite and >= 0"
        )
    stiffness = ea - m * v**2
    if np.any(bad := ~(stiffness > 0.0)):
        speed, limit = _first_bad(bad, v, np.sqrt(ea / m))
        raise DriveError(f"belt speed {speed:g} m/s is not below the critical speed {limit:g} m/s")
    w_in = t_in - m * v**2
    change = stiffness / ea * (t_out - t_in)
    if np.any(bad := ~((w_in > 0.0) & (w_in + change > 0.0))):
        tension, lift = _first_bad(bad, np.minimum(t_in, t_out), m * v**2)
        raise DriveError(f"the belt lifts off: tension {tension:g} N is not above m v^2 {lift:g} N")
    if np.any(bad := ~(sigma * change >= 0.0)):
        values = _first_bad(bad, t_in, t_out)
        raise DriveError(f"tensions {values[0]:g} -> {values[1]:g} N run against the arc's role")
    traction = sigma * np.log1p(change / w_in)
    if np.any(bad := traction >= mu * phi):
        ratio, limit = _first_bad(bad, np.exp(traction), np.exp(mu * phi))
        raise DriveError(
            f"effective tension ratio {ratio:g} is not below exp(mu phi) = {limit:g}: gross slip"
        )
    root = np.sqrt(kf / stiffness)
    groups = np.stack([traction, mu / (r * root), root * r * phi], axis=-1).reshape(-1, 3)
    solved = _solve_many(groups, sigma.astype(np.int64).ravel())
    gradient, transition, restick = (column.reshape(r.shape) for column in solved.T)
    elastic_only = transition >= root * r * phi
    return ArcSolution(
        transition_angle=np.where(elastic_only, phi, transition / (root * r)),
        restick_angle=restick / (root * r),
        inlet_strain_gradient=sigma * gradient * w_in / stiffness,
        elastic_only=elastic_only,
    )


def _check_positive(*named: tuple[str, NDArray[np.float64]]) -> None:
    for name, value in named:
        if np.any(bad := ~(np.isfinite(value) & (value > 0.0))):
            raise DriveError(f"{name} is {_first_bad(bad, value)[0]:g}; it must be finite and > 0")
