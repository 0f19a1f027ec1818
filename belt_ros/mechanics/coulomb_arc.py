"""Friction and tension along one arc in classical creep theory: adhesion, then the capstan law."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from belt_ros.mechanics.drive import DriveError

_Floats = NDArray[np.float64]


class CoulombProfile(NamedTuple):
    """Friction and tension at points of an arc, arrays of one common shape."""

    friction: _Floats  # [N/m], positive where it raises the tension along the travel
    tension: _Floats  # [N]


def _reject(bad: NDArray[np.bool_], message: str, *values: _Floats) -> None:
    """Raise with the values at the first of the bad points, if there is one."""
    if np.any(bad):
        first = int(np.flatnonzero(bad)[0])
        raise DriveError(message.format(*(f"{value.flat[first]:g}" for value in values)))


def coulomb_profile(
    role: ArrayLike,
    radius: ArrayLike,
    wrap_angle: ArrayLike,
    friction_coefficient: ArrayLike,
    axial_stiffness: ArrayLike,
    mass_per_length: ArrayLike,
    inlet_speed: ArrayLike,
    inlet_tension: ArrayLike,
    outlet_tension: ArrayLike,
    angle: ArrayLike,
) -> CoulombProfile:
    """Friction and tension along an arc that adheres, then slides. Arguments broadcast.

    Over the adhesion arc friction is zero and tension that of the inlet; beyond, with the effective
    tension w = T - m v^2, friction is mu w/R and w grows as exp(+-mu angle) (Johnson 1985, Contact
    Mechanics, section 8.3).

    Parameters
    ----------
    role : array_like of Role
        +1 where tension rises along the arc, -1 where it falls.
    radius, wrap_angle, friction_coefficient : array_like
        R [m], phi [rad], mu [-].
    axial_stiffness, mass_per_length : array_like
        EA [N], m [kg/m].
    inlet_speed : array_like
        Belt speed at the inlet [m/s].
    inlet_tension, outlet_tension : array_like
        T at either end [N].
    angle : array_like
        Where, from the inlet [rad].

    Returns
    -------
    CoulombProfile

    Raises
    ------
    DriveError
        For a value not finite, a belt at its critical speed or lifted off, tensions against the
        role, a tension ratio beyond the capacity or an angle off the arc.
    """
    sigma, r, phi, mu, ea, m, v, t_in, t_out, at = np.broadcast_arrays(
        *(
            np.asarray(value, dtype=np.float64)
            for value in (
                role,
                radius,
                wrap_angle,
                friction_coefficient,
                axial_stiffness,
                mass_per_length,
                inlet_speed,
                inlet_tension,
                outlet_tension,
                angle,
            )
        )
    )
    lift = m * v**2
    share = 1.0 - lift / ea
    _reject(~(share > 0.0), "m v^2 {} N is not below EA {} N: critical speed", lift, ea)
    w_in = t_in - lift
    change = share * (t_out - t_in)
    lifted = ~((w_in > 0.0) & (w_in + change > 0.0))
    least = np.minimum(t_in, t_out)
    _reject(lifted, "the belt lifts off: tension {} N is not above m v^2 {} N", least, lift)
    against = ~(sigma * change >= 0.0)
    _reject(against, "tensions {} -> {} N run against the arc's role", t_in, t_out)
    traction = sigma * np.log1p(change / w_in)
    beyond = ~(traction <= mu * phi)
    _reject(beyond, "traction {} is beyond mu phi = {}: gross slip", traction, mu * phi)
    _reject(~((at >= 0.0) & (at <= phi)), "angle {} rad is not on the arc of {} rad", at, phi)
    slid = at - (phi - traction / mu)
    sliding = (slid >= 0.0) & (traction > 0.0)
    rise = np.expm1(np.where(sliding, sigma * mu * slid, 0.0))
    return CoulombProfile(
        friction=np.where(sliding, sigma * mu * w_in * (1.0 + rise) / r, 0.0),
        tension=t_in + w_in * rise / share,
    )
