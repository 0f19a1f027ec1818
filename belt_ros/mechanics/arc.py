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

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.arc_state import arc_state
from belt_ros.mechanics.drive import DriveError


class Role(IntEnum):
    """Sense of the tension along the arc, in the direction of belt travel."""

    DRIVEN = 1  # tension rises
    DRIVER = -1  # tension falls


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
    arcs = checked_arcs(
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
    root = np.sqrt(arcs.friction_stiffness / arcs.net_stiffness)
    per_radian = root * arcs.radius
    wrap = per_radian * arcs.wrap_angle
    growth = arcs.friction_coefficient / per_radian
    groups = np.stack([arcs.traction, growth, wrap], axis=-1).reshape(-1, 3)
    solved = _solve_many(groups, arcs.role.astype(np.int64).ravel())
    gradient, transition, restick = (column.reshape(wrap.shape) for column in solved.T)
    elastic_only = transition >= wrap
    strain = arcs.inlet_effective_tension / arcs.net_stiffness
    return ArcSolution(
        transition_angle=np.where(elastic_only, arcs.wrap_angle, transition / per_radian),
        restick_angle=restick / per_radian,
        inlet_strain_gradient=arcs.role * gradient * strain,
        elastic_only=elastic_only,
    )


class CheckedArcs(NamedTuple):
    """Arcs that can exist, arrays of one shape, SI units."""

    role: NDArray[np.float64]
    radius: NDArray[np.float64]
    wrap_angle: NDArray[np.float64]
    friction_coefficient: NDArray[np.float64]
    friction_stiffness: NDArray[np.float64]
    net_stiffness: NDArray[np.float64]  # K = EA - m v^2 [N]
    inlet_effective_tension: NDArray[np.float64]  # w_in [N]
    traction: NDArray[np.float64]  # ln(w_H/w_L) [-]


def checked_arcs(
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
) -> CheckedArcs:
    """Return arcs with what decides their state; parameters and errors as of `solve_arc`."""
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
    return CheckedArcs(sigma, r, phi, mu, kf, stiffness, w_in, traction)


def _check_positive(*named: tuple[str, NDArray[np.float64]]) -> None:
    for name, value in named:
        if np.any(bad := ~(np.isfinite(value) & (value > 0.0))):
            raise DriveError(f"{name} is {_first_bad(bad, value)[0]:g}; it must be finite and > 0")
