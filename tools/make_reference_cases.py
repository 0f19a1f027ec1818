#!/usr/bin/env python3
"""Write `tests/data/epp_reference.csv`: single pulleys solved without a line of belt_ros.

Each case is solved twice from the paper's own equations (Kim, Leamy and Ferri 2011):

* by integrating from the inlet and shooting for the outlet tension, which is what is written;
* as the boundary value problem of Eqs. 47-54, with `scipy.integrate.solve_bvp`.

A case is written only where both agree to 1e-8 in u'(0) and in the transition angle. Arcs that
re-stick have a third zone, which Eqs. 47-54 do not know: there the same is asked of two
integrations with different methods.

Along the arc everything is divided by the inlet's effective tension w_in = T_in - m v^2:

    f = kf u R / w_in        friction per radian
    h = K u' / w_in          strain gradient, K = EA - m v^2
    W = w / w_in             effective tension

    f' = b^2 h,   h' = W' = f (elastic)   or   h' = W' = sigma mu W (sliding),   b^2 = kf R^2 / K
"""

import argparse
import csv
import math
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_bvp, solve_ivp
from scipy.optimize import brentq

SEED = 20110803
RESTICK_CASES = 15
# Role, range of a = mu/b, zones, how many cases.
KINDS = (
    (1, (0.03, 1.0), 1, 5),
    (1, (0.03, 1.0), 2, 11),
    (1, (1.0, 3.0), 1, 6),
    (1, (1.0, 3.0), 2, 9),
    (-1, (0.03, 1.0), 1, 4),
    (-1, (0.03, 1.0), 2, 12),
    (-1, (1.0, 3.0), 1, 4),
    (-1, (1.0, 3.0), 2, 9),
)
CONFIRMED = 1e-8
BVP_TOLERANCE = 1e-10
OUTPUT = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "tests", "data")

COLUMNS = (
    "arc_role",
    "pulley_radius_m",
    "wrap_angle_rad",
    "friction_coefficient",
    "friction_stiffness_n_m2",
    "axial_stiffness_n",
    "belt_mass_kg_m",
    "belt_speed_m_s",
    "tension_in_n",
    "tension_out_n",
    "zones",
    "slide_from_rad",
    "restick_from_rad",
    "inlet_gradient",
    "limit_growth",
    "deviation",
)

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


def solve_as_bvp(case: Case, guess_gradient: float, guess: Arc) -> tuple[float, float]:
    """Solve Eqs. 47-54 for |h(0)| and the transition angle; the guesses need only be rough.

    In the elastic zone f = F e^(b (theta - theta*)), and likewise h: a change of variables that
    keeps the unknowns of one size however fast the spring's stretch grows. The unknown parameters
    are the transition angle and the tension T_o of the unstretched state, here tau = W - h.
    """
    b, sigma, mu = case.b, case.sigma, case.friction
    partial = guess.zones == 2
    end = guess.slide_from
    mesh = np.unique(
        np.concatenate([np.linspace(0.0, 1.0, 60), np.geomspace(1e-3, 1.0, 60) / max(b, 1.0)])
    )
    decay = np.exp(b * end * (mesh - 1.0))
    stretched = guess_gradient * b * np.sinh(b * end * mesh) / np.maximum(decay, 1e-300)
    steepness = guess_gradient * np.cosh(b * end * mesh) / np.maximum(decay, 1e-300)
    rows = [sigma * stretched, sigma * steepness]

    def elastic(y: Floats, length: float) -> list[Floats]:
        return [length * (b**2 * y[1] - b * y[0]), length * (y[0] - b * y[1])]

    if partial:
        h_at = sigma * guess_gradient * math.cosh(b * end)
        h_out = h_at + case.ratio - (1.0 + h_at - sigma * guess_gradient)
        rows.append(sigma * guess_gradient * b * math.sinh(b * end) * (1.0 + 0.0 * mesh))
        rows.append(h_at + (h_out - h_at) * mesh)
        start = [end, 1.0 - sigma * guess_gradient]
    else:
        start = [1.0 - sigma * guess_gradient]

    def rates(_: Floats, y: Floats, p: Floats) -> Floats:
        if not partial:
            return np.vstack(elastic(y, case.wrap))
        rest = case.wrap - p[0]
        slide = [rest * b**2 * y[3], rest * sigma * mu * (p[1] + y[3])]
        return np.vstack(elastic(y, p[0]) + slide)

    def conditions(inlet: Floats, outlet: Floats, p: Floats) -> Floats:
        if not partial:
            shrink = math.exp(-b * case.wrap)
            return np.array(
                [
                    p[0] + inlet[1] * shrink - 1.0,  # Eq. 49
                    p[0] + outlet[1] - case.ratio,  # Eq. 52
                    inlet[0],  # Eq. 53
                ]
            )
        shrink = math.exp(-b * p[0])
        return np.array(
            [
                p[1] + inlet[1] * shrink - 1.0,  # Eq. 49, the inlet's tension
                outlet[0] - inlet[2],  # Eq. 50, one displacement at the transition
                outlet[1] - inlet[3],  # Eq. 51, one tension there
                p[1] + outlet[3] - case.ratio,  # Eq. 52, the outlet's tension
                inlet[0],  # Eq. 53, the spring starts unstretched
                outlet[0] - sigma * mu * (p[1] + outlet[1]),  # Eq. 54, at its limit
            ]
        )

    solved = solve_bvp(
        rates,
        conditions,
        mesh,
        np.vstack(rows),
        p=start,
        tol=BVP_TOLERANCE,
        bc_tol=1e-12,
        max_nodes=60000,
    )
    if not solved.success:
        raise NotConfirmedError(solved.message)
    theta = float(solved.p[0]) if partial else case.wrap
    return abs(float(solved.y[1, 0])) * math.exp(-b * theta), theta


def confirm(case: Case, gradient: float, arc: Arc) -> float:
    """Solve a case in the other way; return the largest relative deviation."""
    if arc.zones == 3:
        again, second = shoot(case, "LSODA")
        theta = second.slide_from
        if second.zones != 3:
            raise NotConfirmedError("different zones")
        deviations = [abs(second.restick_from / arc.restick_from - 1.0)]
    else:
        rough = Arc(arc.ratio, arc.zones, min(0.98 * arc.slide_from, case.wrap), math.nan)
        again, theta = solve_as_bvp(case, 1.05 * gradient, rough if arc.zones == 2 else arc)
        deviations = []
    deviations += [abs(again / gradient - 1.0), abs(theta / arc.slide_from - 1.0)]
    if not max(deviations) < CONFIRMED:
        raise NotConfirmedError(f"deviation {max(deviations):.1e}")
    return max(deviations)


def _rounded(value: float, digits: int = 4) -> float:
    return float(f"{value:.{digits}g}")


def draw(rng: np.random.Generator, sigma: int, growth: tuple[float, float]) -> Case:
    """Draw a case with a = mu/b in the range `growth`, all but the outlet tension."""

    def spread(low: float, high: float) -> float:
        return float(math.exp(rng.uniform(math.log(low), math.log(high))))

    axial = spread(3e3, 3e6)
    tension = axial * spread(1e-4, 8e-2)
    heavy = rng.random() < 0.5
    lift = tension * (rng.uniform(0.2, 0.8) if heavy else spread(1e-4, 1e-1))
    speed = spread(1.0, 40.0)
    radius, mu = spread(0.02, 0.6), rng.uniform(0.2, 1.4)
    b = mu / spread(*growth)
    return Case(
        sigma=sigma,
        radius=_rounded(radius),
        wrap=_rounded(rng.uniform(1.0, 5.5)),
        friction=_rounded(mu),
        stiffness=_rounded((b / radius) ** 2 * (axial - lift)),
        axial=_rounded(axial),
        mass=_rounded(lift / speed**2),
        speed=_rounded(speed),
        tension_in=_rounded(tension),
    )


def load(case: Case, ratio: float) -> Case:
    """Return the case with the outlet tension, to eight digits, that belongs to W there."""
    tension = _rounded(case.tension_at(ratio), 8)
    return Case(**{**case.__dict__, "tension_out": tension})


def row(case: Case, gradient: float, arc: Arc, deviation: float) -> list[str]:
    """Format one case as `COLUMNS`."""
    slope = case.sigma * gradient * case.inlet / case.axial_net
    given = (
        case.radius,
        case.wrap,
        case.friction,
        case.stiffness,
        case.axial,
        case.mass,
        case.speed,
        case.tension_in,
        case.tension_out,
    )
    solved = (arc.slide_from, arc.restick_from, slope, case.friction / case.b)
    return [
        "driven" if case.sigma > 0 else "driver",
        *(f"{value:.12g}" for value in given),
        str(arc.zones),
        *(f"{value:.12g}" for value in solved),
        f"{deviation:.1e}",
    ]


def plain_cases(rng: np.random.Generator) -> list[list[str]]:
    """Arcs of one and two zones: both roles, the limit outgrowing the spring or not."""
    rows: list[list[str]] = []
    dropped = 0
    for sigma, growth, zones, wanted in KINDS:
        kept = 0
        while kept < wanted:
            case = draw(rng, sigma, growth)
            share = rng.uniform(0.02, 0.97 if zones == 2 else 0.7)
            case = load(case, math.exp(sigma * share * case.friction * case.wrap))
            if not case.tension_out > case.lift:
                continue
            try:
                gradient, arc = shoot(case)
                if arc.zones != zones:
                    continue
                rows.append(row(case, gradient, arc, confirm(case, gradient, arc)))
            except NotConfirmedError as error:
                dropped += 1
                print(f"left out: {error}", file=sys.stderr)
            else:
                kept += 1
    print(f"{len(rows)} arcs of one and two zones, {dropped} left out")
    return rows


def restick_cases(rng: np.random.Generator) -> list[list[str]]:
    """Driven arcs of three zones."""
    rows: list[list[str]] = []
    while len(rows) < RESTICK_CASES:
        case = draw(rng, 1, (1.05, 4.0))
        growth = case.friction / case.b
        onset = growth**2 + growth * math.sqrt(max(growth**2 - 1.0, 0.0))
        try:
            trial = integrate_arc(case, onset * math.exp(rng.uniform(0.02, 1.5)))
            if trial.zones != 3 or trial.restick_from < 1.02 * trial.slide_from:
                continue
            case = load(case, trial.ratio)
            gradient, arc = shoot(case)
            rows.append(row(case, gradient, arc, confirm(case, gradient, arc)))
        except NotConfirmedError as error:
            print(f"left out: {error}", file=sys.stderr)
    print(f"{len(rows)} arcs that re-stick")
    return rows


def main() -> None:
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", default=os.path.join(OUTPUT, "epp_reference.csv"))
    output = parser.parse_args().output
    rng = np.random.default_rng(SEED)
    rows = plain_cases(rng) + restick_cases(rng)
    with open(output, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)


if __name__ == "__main__":
    main()
