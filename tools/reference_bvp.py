"""The same pulleys as `reference_arcs`, as the boundary value problem of Eqs. 47-54."""

import math

import numpy as np
from reference_arcs import Arc, Case, Floats, NotConfirmedError
from scipy.integrate import solve_bvp

BVP_TOLERANCE = 1e-10


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
