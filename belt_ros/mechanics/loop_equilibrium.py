"""A belt on any number of pulleys in steady state: given torques to tensions, slips and margin.

One pulley drives at a given speed and all others have given torques. The effective tension w jumps
across pulley i by F_i = M_i/R_i; the driver closes the balance. With the jumps known all tensions
hang on one level, which the tensioning sets: explicitly for a held span or hub load, through the
belt's unstretched length for fixed centres. Every arc is then explicit, and mass conservation gives
the speeds: along the belt

    R_i omega_i / ((1 - u_i'(0)) (1 + T_in,i/EA))

is the same for all pulleys (`Kinematics.LINEAR`: with T_in,i less the slackest tension, which for
two pulleys is the paper's form). Belt inertia is taken at the driver's rim speed.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from belt_ros.mechanics.drive import DriveError, Kinematics
from belt_ros.mechanics.loop import BeltLoop, FixedCentres, HeldSpan, HubLoad
from belt_ros.mechanics.loop_kernel import LoopConstants, fixed_centre_levels, loop_arcs

_Floats = NDArray[np.float64]
_LARGEST_EXPONENT = 500.0


class LoopEquilibrium(NamedTuple):
    """Steady states of a loop of n pulleys; arrays (..., n), the last three (...).

    Torques and speeds are positive in the sense in which the belt, travelling in the order of the
    pulleys, turns each of them. Span i lies between pulley i and the next. Angles count from each
    pulley's inlet, which is at span i if the speed is negative.
    """

    torque: _Floats  # that the belt puts on the pulley, the driver's from the balance [N m]
    span_tension: _Floats  # T [N]
    effective_tension: _Floats  # w = T - m v^2, what pulls on the hubs [N]
    slip: _Floats  # 1 - (R_i omega_i)/(R_d omega_d), 0 for the driver [-]
    speed: _Floats  # [rad/s]
    transition_angle: _Floats  # where sliding begins, the wrap if it does not [rad]
    restick_angle: _Floats  # where sliding ends before the outlet, else NaN [rad]
    inlet_gradient: _Floats  # u'(0), positive where tension rises along the arc [-]
    utilisation: _Floats  # |ln(w_out/w_in)| / (mu phi) [-]
    friction_loss: _Floats  # (...) power that the driver gives less what the others take [W]
    margin: _Floats  # (...) 1 - 1/scale, at `scale` times all torques the first pulley slips [-]
    first_to_slip: NDArray[np.intp]  # (...) its place in the list; -1 if none does at any scale


class _Asked(NamedTuple):
    """Checked states, flattened."""

    shape: tuple[int, ...]
    torque: _Floats  # (m, n)
    held: _Floats  # (m,)
    speed: _Floats  # (m,)
    lift: _Floats  # (m,) m v^2


class _Statics(NamedTuple):
    """What follows from torques alone, before the level is known; states flattened to (m, ...)."""

    jump: _Floats  # (m, n) F_i [N]
    rise: _Floats  # (m, n) effective tension over that of the slackest span [N]
    least: _Floats  # (m,) level at which the first pulley slips [N]
    first: NDArray[np.intp]  # (m,)


class _Level(NamedTuple):
    slackest: _Floats  # effective tension of the slackest span [N]
    scale: _Floats  # of all torques, at which the first pulley slips [-]


def _statics(loop: BeltLoop, torque: _Floats) -> _Statics:
    """Tensions over the slackest one, and the level below which a pulley slips."""
    jump = torque / np.array([p.pulley.radius for p in loop.pulleys])
    driver = loop.index(loop.driver)
    jump[:, driver] = 0.0
    jump[:, driver] = 0.0 - np.sum(jump, axis=-1)
    rise = np.cumsum(jump, axis=-1)
    rise -= np.min(rise, axis=-1, keepdims=True)
    limit = np.array([p.pulley.traction_limit for p in loop.pulleys])
    slack_side = np.minimum(rise, np.roll(rise, 1, axis=-1))
    needed = np.abs(jump) / np.expm1(np.minimum(limit, _LARGEST_EXPONENT)) - slack_side
    loaded = np.any(jump != 0.0, axis=-1)
    return _Statics(
        jump=jump,
        rise=rise,
        least=np.where(loaded, np.max(needed, axis=-1), 0.0),
        first=np.where(loaded, np.argmax(needed, axis=-1), -1),
    )


def _constants(loop: BeltLoop) -> LoopConstants:
    def column(values: list[float]) -> _Floats:
        return np.array(values, dtype=np.float64)

    return LoopConstants(
        axial_stiffness=loop.belt.axial_stiffness,
        radius=column([p.pulley.radius for p in loop.pulleys]),
        wrap=column([p.pulley.wrap_angle for p in loop.pulleys]),
        friction=column([p.pulley.friction_coefficient for p in loop.pulleys]),
        stiffness=column([p.pulley.friction_stiffness for p in loop.pulleys]),
        span_length=column([p.span_length for p in loop.pulleys]),
        exact_strain=loop.kinematics is Kinematics.EXACT,
    )


def _level(loop: BeltLoop, statics: _Statics, asked: _Asked) -> _Level:
    """Tension level from what the tensioning holds, and the load's scale at the capacity."""
    held, lift = asked.held, asked.lift
    if isinstance(loop.tensioning, FixedCentres):
        jump, rise, least, _ = statics
        forward = asked.speed >= 0.0
        solved = fixed_centre_levels(_constants(loop), jump, rise, least, held, lift, forward)
        return _Level(solved[:, 0].copy(), solved[:, 1].copy())
    if isinstance(loop.tensioning, HeldSpan):
        unloaded = held - lift
        ea = loop.belt.axial_stiffness
        drop = statics.rise[:, loop.index(loop.tensioning.after)] * ea / (ea - lift)
    else:
        index, angle = loop.index(loop.tensioning.on), loop.tensioning.angle
        half = 0.5 * loop.pulleys[index].pulley.wrap_angle
        arriving, leaving = np.sin(half - angle), np.sin(half + angle)
        unloaded = held / (arriving + leaving)
        drop = arriving * statics.rise[:, index - 1] + leaving * statics.rise[:, index]
        drop /= arriving + leaving
    needed = statics.least + drop
    scale = np.full_like(unloaded, np.inf)
    np.divide(unloaded, needed, out=scale, where=needed > 0.0)
    return _Level(unloaded - drop, scale)


def _asked(loop: BeltLoop, torque: ArrayLike, tension: ArrayLike, speed: ArrayLike) -> _Asked:
    """Check and flatten the states asked for."""
    moments, count = np.asarray(torque, dtype=np.float64), len(loop.pulleys)
    if moments.ndim == 0 or moments.shape[-1] != count:
        raise DriveError(f"torque has shape {moments.shape}; it must be (..., {count})")
    held, omega = np.asarray(tension, dtype=np.float64), np.asarray(speed, dtype=np.float64)
    try:
        shape = np.broadcast_shapes(moments.shape[:-1], held.shape, omega.shape)
    except ValueError:
        raise DriveError(
            f"torque {moments.shape}, tension {held.shape} and speed {omega.shape} do not "
            "broadcast: torque has one axis more, for the pulleys"
        ) from None
    if not all(np.all(np.isfinite(array)) for array in (moments, held, omega)):
        raise DriveError("the state asked for contains NaN or infinity")
    given = moments[..., loop.index(loop.driver)]
    if np.any(given != 0.0):
        raise DriveError(
            f"the driver {loop.driver!r} is given {given[given != 0.0].flat[0]:g} N m; its torque "
            "follows from the others: give 0"
        )
    # Copies, for compiled functions are compiled once more for arrays that are read-only.
    held, omega = (np.broadcast_to(array, shape).flatten() for array in (held, omega))
    rim_speed = np.abs(omega) * loop.pulleys[loop.index(loop.driver)].pulley.radius
    if np.any(bad := ~(rim_speed < loop.belt.critical_speed)):
        raise DriveError(
            f"belt speed {rim_speed[bad][0]:g} m/s is not below the critical speed "
            f"{loop.belt.critical_speed:g} m/s"
        )
    lift = loop.belt.mass_per_length * rim_speed**2
    _check_tensioned(loop, held, lift)
    moments = np.broadcast_to(moments, (*shape, count)).reshape(-1, count)
    return _Asked(shape, moments, held, omega, lift)


def _check_tensioned(loop: BeltLoop, held: _Floats, lift: _Floats) -> None:
    if isinstance(loop.tensioning, HubLoad):
        if np.any(bad := ~(held > 0.0)):
            raise DriveError(f"hub load is {held[bad][0]:g} N; it must be > 0")
    elif np.any(bad := ~(held > lift)):
        raise DriveError(
            f"the belt lifts off: tension {held[bad][0]:g} N is not above "
            f"m v^2 = {lift[bad][0]:g} N; tension it more or run slower"
        )


def loop_margin(
    loop: BeltLoop, torque: ArrayLike, tension: ArrayLike, driver_speed: ArrayLike = 0.0
) -> _Floats:
    """Torque reserve 1 - 1/scale [-], negative beyond capacity.

    `scale` times all given torques, at the tensioning at hand, bring the first pulley to gross
    slip; for two pulleys this is 1 - |M|/M_max. It is 1 without load, and where the tensioning
    tightens the belt faster than the load needs it. Parameters and errors as `solve_loop`, which
    also refuses what is beyond capacity.
    """
    asked = _asked(loop, torque, tension, driver_speed)
    statics = _statics(loop, asked.torque)
    level = _level(loop, statics, asked)
    return np.asarray(1.0 - 1.0 / level.scale).reshape(asked.shape)


def solve_loop(
    loop: BeltLoop, torque: ArrayLike, tension: ArrayLike, driver_speed: ArrayLike
) -> LoopEquilibrium:
    """Steady state at given torques. States broadcast against each other.

    Wraps and spans are as given, whatever a tensioner's travel.

    Parameters
    ----------
    loop : BeltLoop
    torque : array_like, (..., n)
        Torque that the belt puts on each pulley [N m], positive in the sense in which the belt,
        travelling in the order of the pulleys, turns it: positive where it takes power, 0 for an
        idler, and 0 for the driver, whose torque follows. See `BeltLoop.torques`.
    tension : array_like, (...)
        What the tensioning holds [N]: the installed tension, the span's tension or the hub load.
    driver_speed : array_like, (...)
        Of the driver [rad/s]; negative where the belt travels against the order of the pulleys, at
        standstill the limit of slow positive speed.

    Returns
    -------
    LoopEquilibrium

    Raises
    ------
    DriveError
        Where the belt lifts off or runs above its critical speed, a pulley is beyond its capacity,
        a pulley would have to turn against the belt, the driver is given a torque, or the arrays
        do not fit or are not finite.
    """
    asked = _asked(loop, torque, tension, driver_speed)
    c = _constants(loop)
    statics = _statics(loop, asked.torque)
    level = _level(loop, statics, asked)
    _check_load(loop, statics, level)
    effective = level.slackest[:, None] + statics.rise
    arcs = loop_arcs(c, statics.jump, statics.rise, level.slackest, asked.lift, asked.speed >= 0.0)
    lift = asked.lift[:, None]
    tension_rise = statics.rise * c.axial_stiffness / (c.axial_stiffness - lift)
    tensions = lift + level.slackest[:, None] + tension_rise
    gradient = arcs[..., 2]
    _check_sliding(loop, gradient)
    slip = _slip(loop, gradient, tensions, tension_rise, asked.speed)
    driver_rim = asked.speed[:, None] * c.radius[loop.index(loop.driver)]
    moment, speed = statics.jump * c.radius, driver_rim * (1.0 - slip) / c.radius
    slack_side = np.minimum(effective, np.roll(effective, 1, axis=-1))
    traction = np.log1p(np.abs(statics.jump) / slack_side)

    def shaped(values: _Floats) -> _Floats:
        return values.reshape(asked.shape + values.shape[1:])

    return LoopEquilibrium(
        torque=shaped(moment),
        span_tension=shaped(tensions),
        effective_tension=shaped(effective),
        slip=shaped(slip),
        speed=shaped(speed),
        transition_angle=shaped(arcs[..., 0]),
        restick_angle=shaped(arcs[..., 1]),
        inlet_gradient=shaped(gradient),
        utilisation=shaped(traction / (c.friction * c.wrap)),
        friction_loss=shaped(driver_rim[:, 0] * np.sum(statics.jump * slip, axis=-1)),
        margin=shaped(1.0 - 1.0 / level.scale),
        first_to_slip=np.where(np.isinf(level.scale), -1, statics.first).reshape(asked.shape),
    )


def _check_load(loop: BeltLoop, statics: _Statics, level: _Level) -> None:
    """Raise where there is no steady state at the torques asked for."""
    if not np.any(bad := ~(level.scale > 1.0)):
        return
    k = int(np.flatnonzero(bad)[0])
    if not level.slackest[k] > 0.0:
        before = loop.names[np.argmin(statics.rise[k])]
        raise DriveError(
            f"the belt lifts off in the span that leaves {before!r}: its effective tension would "
            f"be {level.slackest[k]:g} N and must be > 0; tension the belt more, or load it less "
            f"than {level.scale[k]:g} times what is asked"
        )
    first = loop.pulleys[statics.first[k]]
    moment = float(statics.jump[k, statics.first[k]]) * first.pulley.radius
    share = float(level.scale[k])
    raise DriveError(
        f"pulley {first.name!r} slips: its torque of {moment:g} N m is not within its capacity of "
        f"{moment * share:g} N m, which {share:g} times all torques use up; tension the belt more, "
        "wrap it further round that pulley, or load it less"
    )


def _slip(
    loop: BeltLoop, gradient: _Floats, tension: _Floats, rise: _Floats, speed: _Floats
) -> _Floats:
    """Slip against the driver; `rise` is the spans' tension over that of the slackest, (m, n)."""
    driver = [loop.index(loop.driver)]
    stretching = tension if loop.kinematics is Kinematics.EXACT else rise
    stretched = loop.belt.axial_stiffness + _inlet(stretching, speed)
    ratio = stretched / stretched[:, driver]
    inlet = _inlet(rise, speed)
    deficit = (inlet[:, driver] - inlet) / stretched[:, driver]
    return (gradient * ratio - gradient[:, driver] + deficit) / (1.0 - gradient[:, driver])


def _inlet(span: _Floats, speed: _Floats) -> _Floats:
    """Values of the spans where they enter the pulleys: the one before, or after in reverse."""
    return np.where(speed[:, None] >= 0.0, np.roll(span, 1, axis=-1), span)


def _check_sliding(loop: BeltLoop, gradient: _Floats) -> None:
    """Raise where a pulley would have to turn against the belt that runs on it."""
    if np.any(bad := ~(gradient < 1.0)):
        k, i = (int(place) for place in np.argwhere(bad)[0])
        raise DriveError(
            f"pulley {loop.names[i]!r} would have to turn backwards: its strain gradient u'(0) is "
            f"{gradient[k, i]:g} and must be < 1; tension the belt more or load it less"
        )
