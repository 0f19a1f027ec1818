"""Where creep turns into sliding: the friction stiffness that parts the two regimes, Eqs. 57-60.

The paper calls it kf_min, the least stiffness that can transmit a given change of tension. Its own
equations say otherwise: a softer contact transmits it too, stays under the Coulomb limit all along
the arc, and creeps elastically from inlet to outlet. So kf_min is the boundary of two regimes, not
of what a belt can carry; what a belt can carry is the capstan limit exp(mu phi) for any stiffness.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.arc import checked_arcs

_STEPS = 200
_SOFTEST = 1e-6  # stretch lengths on the arc, below which nothing changes any more
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@compiled
def elastic_traction(growth: float, wrap: float, role: int) -> float:
    """Greatest traction ln(w_H/w_L) [-] at which an arc of groups a and X does not slide anywhere.

    On a driven arc with a > 1 the Coulomb limit is first met inside the arc, where tanh x = 1/a.
    """
    if role > 0 and growth > 1.0 and math.atanh(1.0 / growth) < wrap:
        half = math.sinh(0.5 * wrap)
        gradient = growth * (growth + math.sqrt((growth - 1.0) * (growth + 1.0)))
        return math.log1p(2.0 * gradient * half * half)
    return -role * math.log1p(-role * growth * math.tanh(0.5 * wrap))


@compiled
def _most_elastic_wrap(limit: float) -> float:
    """X at which a driven arc of traction limit `limit` > 1 carries most without sliding.

    Golden section in ln X; the elastic traction has one maximum there.
    """
    low, high = math.log(_SOFTEST), math.log(limit)
    inner, outer = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    for _ in range(_STEPS):
        at_inner = elastic_traction(limit / math.exp(inner), math.exp(inner), 1)
        if at_inner < elastic_traction(limit / math.exp(outer), math.exp(outer), 1):
            low = inner
        else:
            high = outer
        inner, outer = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
        if high - low <= 1e-9:
            break
    return math.exp(0.5 * (low + high))


@compiled
def _wrap_at_onset(role: int, limit: float, traction: float) -> float:
    """X above which an arc slides; 0 where it slides at any."""
    low = _most_elastic_wrap(limit) if role > 0 and limit > 1.0 else _SOFTEST
    if elastic_traction(limit / low, low, role) <= traction:
        return 0.0
    high = max(2.0 * limit / abs(math.expm1(-role * traction)), 2.0 * low)
    for _ in range(_STEPS):
        middle = math.sqrt(low * high)
        if elastic_traction(limit / middle, middle, role) > traction:
            low = middle
        else:
            high = middle
        if high - low <= 4e-16 * high:
            break
    return math.sqrt(low * high)


@compiled
def _wraps_at_onset(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows (role, mu phi, traction) to X at the onset of sliding."""
    out = np.zeros(rows.shape[0])
    for i in range(rows.shape[0]):
        if rows[i, 2] > 0.0:
            out[i] = _wrap_at_onset(1 if rows[i, 0] > 0.0 else -1, rows[i, 1], rows[i, 2])
    return out


def slip_onset_stiffness(
    role: ArrayLike,
    radius: ArrayLike,
    wrap_angle: ArrayLike,
    friction_coefficient: ArrayLike,
    axial_stiffness: ArrayLike,
    mass_per_length: ArrayLike,
    inlet_speed: ArrayLike,
    inlet_tension: ArrayLike,
    outlet_tension: ArrayLike,
) -> NDArray[np.float64]:
    """Friction stiffness kf [N/m2] above which the belt slides somewhere on the arc.

    Parameters are those of `solve_arc` but for the stiffness, and broadcast likewise.

    Returns
    -------
    ndarray
        The paper's kf_min; 0 where the belt slides however soft the contact is, inf where the
        tensions are equal. A driven arc with mu phi > 1 can slide at much softer contacts again,
        where the Coulomb limit is met inside the arc; this is the upper end of the range in which
        it does not.

    Raises
    ------
    DriveError
        As `solve_arc`.
    """
    arcs = checked_arcs(
        role,
        radius,
        wrap_angle,
        friction_coefficient,
        1.0,
        axial_stiffness,
        mass_per_length,
        inlet_speed,
        inlet_tension,
        outlet_tension,
    )
    limit = arcs.friction_coefficient * arcs.wrap_angle
    rows = np.stack([arcs.role, limit, arcs.traction], axis=-1).reshape(-1, 3)
    wrap = _wraps_at_onset(rows).reshape(limit.shape)
    stiffness = arcs.net_stiffness * (wrap / (arcs.radius * arcs.wrap_angle)) ** 2
    return np.where(arcs.traction > 0.0, stiffness, np.inf)
