"""One arc as the boundary value problem of Eqs. 47-54, for `scipy.integrate.solve_bvp`.

Angles in radians from the inlet, everything else divided by the inlet's effective tension w_in:

    f = kf u R / w_in      friction per radian        f' = b^2 h
    h = K u' / w_in        strain gradient            h' = f
    W = w / w_in           effective tension          W' = sigma mu W where the belt slides

with b = R sqrt(kf/K). The transition angle and the tension T_o of the unstretched friction spring,
here W - h, are the unknown parameters. In the creep zone f and h grow as e^(b theta); they are
divided by that, without which no tolerance would resolve an inlet gradient of 1e-20.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_bvp

Floats = NDArray[np.float64]


class ScaledArc(NamedTuple):
    """One arc in scaled form."""

    sense: float  # sigma, +1 driven, -1 driver
    friction: float  # mu [-]
    stretch: float  # b [-]
    wrap: float  # phi [rad]
    ratio: float  # w_out / w_in [-]


class Guess(NamedTuple):
    """Where the solver starts."""

    gradient: float  # h(0) [-], signed
    transition: float  # theta* [rad], the wrap angle if the belt nowhere slides


class NotSolvedError(Exception):
    """`solve_bvp` did not reach the tolerance."""


def inlet_gradient(arc: ScaledArc, guess: Guess, tolerance: float, nodes: int) -> float:
    """Solve one arc for h(0) = K u'(0) / w_in.

    Raises
    ------
    NotSolvedError
        If the solver gives up.
    """
    slides = guess.transition < arc.wrap
    mesh = np.linspace(0.0, 1.0, nodes)
    angle = arc.stretch * guess.transition
    creep = 0.5 * guess.gradient * math.exp(angle)
    faded = np.exp(-2.0 * angle * mesh)
    start = [arc.stretch * creep * (1.0 - faded), creep * (1.0 + faded)]
    unknown = [1.0 - guess.gradient]
    if slides:
        rest = arc.wrap - guess.transition
        start.append(arc.ratio * np.exp(arc.sense * arc.friction * rest * (mesh - 1.0)))
        unknown.append(guess.transition)
    solved = solve_bvp(
        lambda _, y, p: _rates(arc, y, p),
        lambda inlet, outlet, p: _conditions(arc, inlet, outlet, p),
        mesh,
        np.vstack(start),
        p=unknown,
        tol=tolerance,
        max_nodes=20_000,
    )
    if not solved.success:
        raise NotSolvedError(solved.message)
    transition = solved.p[1] if slides else arc.wrap
    return float(solved.y[1, 0]) * math.exp(-arc.stretch * transition)


def _rates(arc: ScaledArc, y: Floats, p: Floats) -> Floats:
    """Return the slopes over [0, 1], to which both zones are stretched."""
    creep = arc.wrap if len(p) == 1 else p[1]
    b = arc.stretch
    rates = [creep * b * (b * y[1] - y[0]), creep * (y[0] - b * y[1])]
    if len(p) == 2:
        rates.append((arc.wrap - creep) * arc.sense * arc.friction * y[2])
    return np.vstack(rates)


def _conditions(arc: ScaledArc, inlet: Floats, outlet: Floats, p: Floats) -> Floats:
    creep = arc.wrap if len(p) == 1 else p[1]
    ends = [
        inlet[0],  # Eq. 53, the spring starts unstretched
        p[0] + inlet[1] * math.exp(-arc.stretch * creep) - 1.0,  # Eq. 49, the inlet's tension
    ]
    if len(p) == 1:
        ends.append(p[0] + outlet[1] - arc.ratio)  # Eq. 52, the outlet's tension
    else:
        ends += [
            p[0] + outlet[1] - inlet[2],  # Eq. 51, one tension at the transition
            outlet[0]
            - arc.sense * arc.friction * inlet[2],  # Eq. 54, where friction is at its limit
            outlet[2] - arc.ratio,  # Eq. 52
        ]
    return np.array(ends)
