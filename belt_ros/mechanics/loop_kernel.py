"""Arcs of a loop and the tension level of fixed centres, compiled.

A state of the loop is written by its jumps (F_i = M_i/R_i, the change of effective tension from the
span before pulley i to the one after it), the rises of the spans' effective tensions over that of
the slackest, and one unknown, the level: the effective tension of the slackest span. There the
effective tension is w = T - m v^2 with the belt's inertia at the driver's rim speed; elsewhere
tension differs by T - T_slackest = (EA/K)(w - w_slackest), K = EA - m v^2, because the belt's own
speed grows with its strain.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.arc_profile import ScaledArc, excess, relaxed_length, scaled_arc

_Floats = NDArray[np.float64]
_SOLVE_STEPS = 100
_ROUNDING = 4e-16


class LoopConstants(NamedTuple):
    """A loop as plain numbers for compiled code; one entry per pulley, SI units."""

    axial_stiffness: float
    radius: _Floats
    wrap: _Floats
    friction: _Floats  # mu
    stiffness: _Floats  # kf
    span_length: _Floats
    exact_strain: bool


class LoopLoad(NamedTuple):
    """What one state of a loop is asked to carry."""

    jump: _Floats  # F_i [N]
    rise: _Floats  # of the span after pulley i over the slackest [N]
    lift: float  # m v^2 [N]
    forward: bool  # whether the belt travels in the order of the pulleys


@compiled
def _arc(c: LoopConstants, load: LoopLoad, level: float, i: int) -> ScaledArc:
    """Solve the arc of pulley i."""
    low = level + min(load.rise[i - 1], load.rise[i])
    traction = math.log1p(abs(load.jump[i]) / low)
    role = 1 if (load.jump[i] >= 0.0) == load.forward else -1
    net = c.axial_stiffness - load.lift
    return scaled_arc(traction, c.radius[i], c.wrap[i], c.friction[i], c.stiffness[i], net, role)


@compiled
def _surplus(
    c: LoopConstants, load: LoopLoad, level: float, scale: float, installed: float
) -> float:
    """Unstretched belt [m] on the path beyond what lies there at the installed tension.

    `scale` multiplies the load and the level with it, which leaves the arcs' tractions as they are.
    The surplus falls as either rises. With linear kinematics a length holds 1 - T/EA of itself.
    """
    ea = c.axial_stiffness
    net = ea - load.lift
    held = path = 0.0
    for i in range(c.radius.size):
        inlet, outlet = load.rise[i - 1], load.rise[i]
        if not load.forward:
            inlet, outlet = outlet, inlet
        slackest = (load.lift + scale * level) / ea
        strain = slackest + scale * inlet / net
        span_strain = slackest + scale * load.rise[i] / net
        grip = scale * (level + inlet) / net
        arc = _arc(c, load, level, i)
        if c.exact_strain:
            held += c.span_length[i] / (1.0 + span_strain)
            held += arc.unit * relaxed_length(arc, strain, grip)
        else:
            held -= c.span_length[i] * span_strain
            held -= arc.unit * (strain * arc.wrap + grip * excess(arc)[0])
        path += c.span_length[i] + c.radius[i] * c.wrap[i]
    if c.exact_strain:
        return held - path / (1.0 + installed / ea)
    return held + path * installed / ea


@compiled
def _fit(
    c: LoopConstants,
    load: LoopLoad,
    installed: float,
    slacker: tuple[float, float],
    tauter: tuple[float, float],
) -> float:
    """Share of the way between two pairs (level, scale) where the path holds just the belt.

    0 if it stretches the belt more even at the slacker one. False position (Illinois) on a function
    that falls almost linearly.
    """
    low, high = 0.0, 1.0
    at_low = _surplus(c, load, slacker[0], slacker[1], installed)
    if at_low <= 0.0:
        return 0.0
    at_high = _surplus(c, load, tauter[0], tauter[1], installed)
    enough = _ROUNDING * c.axial_stiffness / installed
    x, last = 1.0, 0
    for _ in range(_SOLVE_STEPS):
        before = x
        x = (at_low * high - at_high * low) / (at_low - at_high)
        level = slacker[0] + x * (tauter[0] - slacker[0])
        scale = slacker[1] + x * (tauter[1] - slacker[1])
        found = _surplus(c, load, level, scale, installed)
        side = 1 if found > 0.0 else -1
        if side > 0:
            low, at_low = x, found
            at_high *= 0.5 if last > 0 else 1.0
        else:
            high, at_high = x, found
            at_low *= 0.5 if last < 0 else 1.0
        if abs(x - before) <= enough or found == 0.0:
            break
        last = side
    return x


@compiled
def fixed_centre_levels(
    c: LoopConstants,
    jumps: _Floats,
    rises: _Floats,
    least: _Floats,
    installed: _Floats,
    lifts: _Floats,
    forward: NDArray[np.bool_],
) -> _Floats:
    """Levels of fixed centres [N], and the scales of the load that use the capacity up.

    Parameters
    ----------
    c : LoopConstants
    jumps, rises : ndarray, (m, n)
        As in `LoopLoad`.
    least : ndarray, (m,)
        Level [N] at which the first pulley slips; 0 without load.
    installed : ndarray, (m,)
        Tension of the belt without load and at standstill [N], above `lifts`.
    lifts : ndarray, (m,)
        m v^2 [N].
    forward : ndarray of bool, (m,)

    Returns
    -------
    ndarray, (m, 2)
        Level, not below `least`, and scale.
    """
    out = np.empty((jumps.shape[0], 2))
    for k in range(jumps.shape[0]):
        load = LoopLoad(jumps[k], rises[k], lifts[k], forward[k])
        slackest = least[k]
        top = installed[k] - lifts[k]  # no span would be slacker than installed
        if slackest == 0.0:
            out[k] = top, math.inf
            continue
        largest = top / slackest
        out[k, 1] = largest * _fit(c, load, installed[k], (slackest, 0.0), (slackest, largest))
        out[k, 0] = slackest
        if out[k, 1] > 1.0:
            share = _fit(c, load, installed[k], (slackest, 1.0), (top, 1.0))
            out[k, 0] += share * (top - slackest)
    return out


@compiled
def loop_arcs(
    c: LoopConstants,
    jumps: _Floats,
    rises: _Floats,
    levels: _Floats,
    lifts: _Floats,
    forward: NDArray[np.bool_],
) -> _Floats:
    """Transition angle, re-stick angle [rad] (NaN where none) and u'(0) of every arc, (m, n, 3)."""
    count = c.radius.size
    out = np.empty((jumps.shape[0], count, 3))
    for k in range(jumps.shape[0]):
        load = LoopLoad(jumps[k], rises[k], lifts[k], forward[k])
        for i in range(count):
            arc = _arc(c, load, levels[k], i)
            inlet = load.rise[i - 1] if load.forward else load.rise[i]
            grip = (levels[k] + inlet) / (c.axial_stiffness - load.lift)
            sliding = arc.begin < arc.wrap
            out[k, i, 0] = arc.begin * arc.unit / c.radius[i] if sliding else c.wrap[i]
            out[k, i, 1] = arc.state.restick * arc.unit / c.radius[i]
            out[k, i, 2] = arc.role * arc.state.gradient * grip
    return out
