"""Single pulleys from the paper's equations, by integrating from the inlet; no belt_ros in it.

Along the arc everything is divided by the inlet's effective tension w_in = T_in - m v^2:

    f = kf u R / w_in        friction per radian
    h = K u' / w_in          strain gradient, K = EA - m v^2
    W = w / w_in             effective tension

    f' = b^2 h,   h' = W' = f (elastic)   or   h' = W' = sigma mu W (sliding),   b^2 = kf R^2 / K
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Floats = NDArray[np.float64]


class NotConfirmedError(Exception):
    """The two solutions of a case do not agree, or one of them failed."""


@dataclass(frozen=True)
class Case:
    """One pulley, SI units, with the tensions at both ends of its arc."""

    sigma: int
    radius: float
    wrap: float
    friction: float
    stiffness: float
    axial: float
    mass: float
    speed: float
    tension_in: float
    tension_out: float = math.nan

    @property
    def lift(self) -> float:
        """Tension that inertia takes up, m v^2 [N]."""
        return self.mass * self.speed**2

    @property
    def inlet(self) -> float:
        """Effective tension at the inlet [N]."""
        return self.tension_in - self.lift

    @property
    def axial_net(self) -> float:
        """K = EA - m v^2 [N]."""
        return self.axial - self.lift

    @property
    def b(self) -> float:
        """Radius in stretch lengths."""
        return self.radius * math.sqrt(self.stiffness / self.axial_net)

    @property
    def ratio(self) -> float:
        """W at the outlet that the tensions ask for."""
        return 1.0 + self.axial_net / self.axial * (self.tension_out - self.tension_in) / self.inlet

    def tension_at(self, ratio: float) -> float:
        """Outlet tension [N] that belongs to W there."""
        return self.tension_in + (ratio - 1.0) * self.inlet * self.axial / self.axial_net


@dataclass(frozen=True)
class Arc:
    """Where an integration from the inlet ended, and where its zones meet [rad]."""

    ratio: float
    zones: int
    slide_from: float
    restick_from: float


def _integrate(
    case: Case,
    rate: Callable[[float, Floats], list[float]],
    start: tuple[float, Floats],
    event: Callable[[float, Floats], float] | None,
    method: str,
) -> tuple[float, Floats, bool]:
    """Integrate one zone up to the outlet or to the event; return place, state and which."""
    theta, state = start
    if event is not None:
        event.terminal = True  # type: ignore[attr-defined]
    floor = 1e-17 * np.abs(state).max() if state[0] else 1e-17 * abs(state[1])
    solved = solve_ivp(
        rate,
        (theta, case.wrap),
        state,
        method=method,
        events=event,
        rtol=2.3e-14,
        atol=floor,
    )
    if not solved.success:
        raise NotConfirmedError(solved.message)
    met = bool(solved.status == 1)
    if met:
        return float(solved.t_events[0][0]), np.asarray(solved.y_events[0][0]), True
    return case.wrap, np.asarray(solved.y[:, -1]), False


def integrate_arc(case: Case, gradient: float, method: str = "DOP853") -> Arc:
    """Follow the belt from the inlet with |h| = `gradient` there, zone by zone."""
    b2, sigma, mu = case.b**2, case.sigma, case.friction

    def elastic(_: float, y: Floats) -> list[float]:
        return [b2 * y[1], y[0], y[0]]

    def sliding(_: float, y: Floats) -> list[float]:
        pull = sigma * mu * y[2]
        return [b2 * y[1], pull, pull]

    def limit_met(_: float, y: Floats) -> float:
        return float(sigma * y[0] - mu * y[2])

    def limit_outgrows(_: float, y: Floats) -> float:
        return float(sigma * b2 * y[1] - mu * (sigma * mu * y[2]))

    start = (0.0, np.array([0.0, sigma * gradient, 1.0]))
    slide, state, met = _integrate(case, elastic, start, limit_met, method)
    if not met:
        return Arc(float(state[2]), 1, case.wrap, math.nan)
    restick, state, met = _integrate(case, sliding, (slide, state), limit_outgrows, method)
    if not met:
        return Arc(float(state[2]), 2, slide, math.nan)
    # The spring is at its limit again, and stretches with the belt from there on.
    state[0] = sigma * mu * state[2]
    _, state, _ = _integrate(case, elastic, (restick, state), None, method)
    if limit_met(0.0, state) > 0.0:
        raise NotConfirmedError("slides once more after it re-stuck")
    return Arc(float(state[2]), 3, slide, restick)


def shoot(case: Case, method: str = "DOP853") -> tuple[float, Arc]:
    """Find the inlet gradient |h| whose arc ends at the tension asked for."""
    target = math.log(case.ratio)

    def miss(log_gradient: float) -> float:
        ratio = integrate_arc(case, math.exp(log_gradient), method).ratio
        return (math.log(ratio) if ratio > 0.0 else -math.inf) * case.sigma - target * case.sigma

    low, high = -2.0, 0.0
    while miss(low) > 0.0:
        low -= 3.0
    while miss(high) < 0.0:
        high += 1.0
        if high > 12.0:
            raise NotConfirmedError("too close to gross slip")
    log_gradient = brentq(miss, low, high, xtol=1e-15, rtol=1e-15, maxiter=200)
    gradient = math.exp(log_gradient)
    return gradient, integrate_arc(case, gradient, method)
