"""The finite element belt in compiled code: truss elements, contact, friction, time marching.

The belt is a closed chain of lumped masses joined by corotational truss elements. Node i carries
element i to node i + 1; the last slot of the nodal arrays is a copy of node 0. Velocities live half
a step after positions (central differences), and with them the pulley speeds.

Coordinates: the driven pulley's centre is the origin, the driver's lies on the positive x axis,
positive rotation is counter-clockwise and nodes are numbered along it.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]


_LEAST_HELD = 1e-3  # of a node's length, while it touches a rim at all


class Rim(NamedTuple):
    """One pulley as its contact sees it."""

    centre: float  # x of its axis [m]
    radius: float  # of the circle the nodes run on [m]
    friction: float  # mu [-]
    stiffness: float  # kf [N/m2]
    inlet: float  # polar angle where contact begins at positive rotation [rad]
    wrap: float  # [rad]


class Mesh(NamedTuple):
    """Constants of a discretised drive."""

    elements: int
    driven: Rim
    driver: Rim
    inertia: float  # of the driven pulley [kg m2]
    time_step: float  # [s]
    axial_stiffness: float  # EA [N]
    rest_length: float  # of an element [m]
    node_mass: float  # [kg]
    retardation: float  # of the Kelvin-Voigt belt [s]
    penalty: float  # contact stiffness of a node [N/m]
    contact_damping: float  # of a node [N s/m]
    span_damping: float  # decay rate of lateral velocity on the spans [1/s]
    middle: float  # x halfway between the pulleys [m]
    span_start: float  # x where the spans leave the driven pulley [m]
    span_end: float  # x where they reach the driver [m]
    normal_x: float  # unit normal of the upper span; the lower one's is mirrored
    normal_y: float


class State(NamedTuple):
    """What moves, as arrays that `advance` overwrites; n nodes."""

    x: _Floats  # (n + 1,) [m]
    y: _Floats
    vx: _Floats  # (n + 1,) [m/s], half a step later than x
    vy: _Floats
    stretch: _Floats  # (n,) of the friction spring [m], positive where the belt leads the rim
    length: _Floats  # (n,) of the elements [m]
    tension: _Floats  # (n,) of the elements [N]
    pull_x: _Floats  # (n,) force of element i on node i [N]
    pull_y: _Floats
    friction: _Floats  # (n,) of the rim on node i, counter-clockwise [N]
    normal: _Floats  # (n,) of the rim on node i, outward [N]
    driven_speed: _Floats  # (1,) [rad/s]


class Profile(NamedTuple):
    """Sums over nodes by angle from a pulley's inlet, (bins,) each."""

    friction: _Floats  # [N/m]
    normal: _Floats  # [N/m]
    tension: _Floats  # [N]
    visits: _Floats  # of nodes [-]


class _Contact(NamedTuple):
    """What a pulley, or on a span the damping, does to one node."""

    stretch: float  # of the friction spring [m]
    normal: float  # outward [N]
    friction: float  # counter-clockwise [N]
    x: float  # the whole force [N]
    y: float
    torque: float  # of the friction on the pulley [N m]


@compiled
def _stretch_elements(mesh: Mesh, s: State) -> None:
    """Lengths, tensions and forces of the elements; a belt pulls but never pushes."""
    x, y, vx, vy = s.x, s.y, s.vx, s.vy
    lengths, tensions, pull_x, pull_y = s.length, s.tension, s.pull_x, s.pull_y
    n = mesh.elements
    x[n], y[n], vx[n], vy[n] = x[0], y[0], vx[0], vy[0]
    stiffness = mesh.axial_stiffness / mesh.rest_length
    viscosity = stiffness * mesh.retardation
    for i in range(n):
        dx, dy = x[i + 1] - x[i], y[i + 1] - y[i]
        length = math.sqrt(dx * dx + dy * dy)
        cos, sin = dx / length, dy / length
        rate = cos * (vx[i + 1] - vx[i]) + sin * (vy[i + 1] - vy[i])
        tension = max(stiffness * (length - mesh.rest_length) + viscosity * rate, 0.0)
        lengths[i] = length
        tensions[i] = tension
        pull_x[i] = tension * cos
        pull_y[i] = tension * sin


@compiled
def _on_arc(inside: float, tributary: float) -> tuple[float, float]:
    """How much of a node's `tributary` length is on an arc, and how fast its middle moves on.

    A node stands for half an element on either side of it, which come onto the arc one after the
    other, and leave it so: meanwhile what is on it is shorter, and its middle half as fast as the
    node. Taken as on or off in one, nodes are held for 0.6 elements too long, and slip at a soft
    contact, whose friction grows all along the arc, is too small by twice that share of the arc.

    `inside` is how far [m] the node is from where the nearer span touches, negative on the span.
    """
    if inside >= 0.5 * tributary:
        return tributary, 1.0
    return max(0.5 * tributary + inside, _LEAST_HELD * tributary), 0.5


@compiled
def _contact(
    mesh: Mesh,
    rim: Rim,
    speed: float,
    x: float,
    y: float,
    vx: float,
    vy: float,
    stretch: float,
    held: float,
    pace: float,
) -> _Contact:
    """Contact of a node with a pulley at `speed` [rad/s]; x counts from the pulley's centre.

    `held` is the belt [m] that the node holds on it, and `pace` the share of the node's motion over
    the rim that its middle makes.
    """
    radius = math.sqrt(x * x + y * y)
    ex, ey = x / radius, y / radius
    normal = mesh.penalty * (rim.radius - radius) - mesh.contact_damping * (ex * vx + ey * vy)
    normal = max(normal, 0.0)
    spring = rim.stiffness * held
    limit = rim.friction * normal / spring
    stretch += pace * mesh.time_step * (ex * vy - ey * vx - speed * radius)
    stretch = min(max(stretch, -limit), limit)
    friction = -spring * stretch
    return _Contact(
        stretch,
        normal,
        friction,
        normal * ex - friction * ey,
        normal * ey + friction * ex,
        -friction * radius,
    )


@compiled
def _free(mesh: Mesh, x: float, y: float, vx: float, vy: float) -> _Contact:
    """No contact; on the spans, damping of a velocity that a transported straight span has not."""
    if x < mesh.span_start or x > mesh.span_end:
        return _Contact(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    nx = mesh.normal_x
    ny = mesh.normal_y if y > 0.0 else -mesh.normal_y
    drag = -mesh.node_mass * mesh.span_damping * (vx * nx + vy * ny)
    return _Contact(0.0, 0.0, 0.0, drag * nx, drag * ny, 0.0)


@compiled
def _step(mesh: Mesh, s: State, driver_speed: float, load: float) -> tuple[float, float]:
    """Advance by one step; return friction's torques on the driven and the driver pulley [N m]."""
    x, y, vx, vy, stretch, length = s.x, s.y, s.vx, s.vy, s.stretch, s.length
    pull_x, pull_y, friction, normal = s.pull_x, s.pull_y, s.friction, s.normal
    n = mesh.elements
    for i in range(n):
        x[i] += mesh.time_step * vx[i]
        y[i] += mesh.time_step * vy[i]
    _stretch_elements(mesh, s)
    rate = mesh.time_step / mesh.node_mass
    driven_speed = s.driven_speed[0]
    driven_torque = driver_torque = 0.0
    for i in range(n):
        before = i - 1 if i > 0 else n - 1
        near_driven = x[i] < mesh.middle
        rim = mesh.driven if near_driven else mesh.driver
        dx = x[i] - rim.centre
        if dx * dx + y[i] * y[i] < rim.radius * rim.radius:
            speed = driven_speed if near_driven else driver_speed
            inside = abs(y[i]) * mesh.normal_x - dx * mesh.normal_y
            inside = inside if near_driven else -inside
            on_arc = _on_arc(inside, 0.5 * (length[i] + length[before]))
            hold = _contact(mesh, rim, speed, dx, y[i], vx[i], vy[i], stretch[i], *on_arc)
        else:
            hold = _free(mesh, x[i], y[i], vx[i], vy[i])
        stretch[i], normal[i], friction[i] = hold.stretch, hold.normal, hold.friction
        driven_torque += hold.torque if near_driven else 0.0
        driver_torque += 0.0 if near_driven else hold.torque
        vx[i] += rate * (pull_x[i] - pull_x[before] + hold.x)
        vy[i] += rate * (pull_y[i] - pull_y[before] + hold.y)
    s.driven_speed[0] += mesh.time_step * (driven_torque - load) / mesh.inertia
    return driven_torque, driver_torque


@compiled
def _span_tensions(mesh: Mesh, s: State) -> tuple[float, float]:
    """Mean tension of the elements on the lower and on the upper span [N]."""
    lower, upper = 0.0, 0.0
    lower_count, upper_count = 0, 0
    for i in range(mesh.elements):
        a, b = s.x[i], s.x[i + 1]
        if min(a, b) < mesh.span_start or max(a, b) > mesh.span_end:
            continue
        if s.y[i] < 0.0:
            lower += s.tension[i]
            lower_count += 1
        else:
            upper += s.tension[i]
            upper_count += 1
    return lower / lower_count, upper / upper_count


@compiled
def _add_node(s: State, i: int, rim: Rim, profile: Profile) -> None:
    """Add node i to the bin of its angle on a pulley, if it is within the wrap."""
    angle = math.atan2(s.y[i], s.x[i] - rim.centre) - rim.inlet
    if angle < 0.0:
        angle += 2.0 * math.pi
    k = int(angle / rim.wrap * profile.visits.size)
    if k >= profile.visits.size:
        return
    tributary = 0.5 * (s.length[i] + s.length[i - 1])
    held, _ = _on_arc(min(angle, rim.wrap - angle) * rim.radius, tributary)
    profile.friction[k] -= s.friction[i] / held
    profile.normal[k] += s.normal[i] / held
    profile.tension[k] += 0.5 * (s.tension[i] + s.tension[i - 1])
    profile.visits[k] += 1.0


@compiled
def _add_profiles(mesh: Mesh, s: State, driven: Profile, driver: Profile) -> None:
    for i in range(mesh.elements):
        if s.x[i] <= mesh.span_start:
            _add_node(s, i, mesh.driven, driven)
        elif s.x[i] >= mesh.span_end:
            _add_node(s, i, mesh.driver, driver)


@compiled
def advance(
    mesh: Mesh,
    s: State,
    driver_speed: _Floats,
    load: _Floats,
    stride: int,
    driven: Profile,
    driver: Profile,
) -> tuple[float, float, float, float, float, float]:
    """Advance by as many steps as `driver_speed` and `load` have entries.

    Parameters
    ----------
    mesh : Mesh
    s : State
        Overwritten.
    driver_speed, load : ndarray
        (steps,) omega2 [rad/s] and load torque [N m], taken half a step before each step's end.
    stride : int
        Steps between two observations of tensions and profiles; `steps` is a multiple of it.
    driven, driver : Profile
        Added to; without bins, nothing is.

    Returns
    -------
    tuple
        Means over these steps: driver speed, driven speed [rad/s], torque of friction on the driver
        and on the driven pulley [N m], tension of the lower and of the upper span [N].
    """
    steps = driver_speed.size
    driven_speed = driven_torque = driver_torque = lower = upper = 0.0
    for step in range(steps):
        torques = _step(mesh, s, driver_speed[step], load[step])
        driven_torque += torques[0]
        driver_torque += torques[1]
        driven_speed += s.driven_speed[0]
        if (step + 1) % stride == 0:
            tensions = _span_tensions(mesh, s)
            lower += tensions[0]
            upper += tensions[1]
            if driven.visits.size > 0:
                _add_profiles(mesh, s, driven, driver)
    return (
        driver_speed.mean(),
        driven_speed / steps,
        driver_torque / steps,
        driven_torque / steps,
        lower / (steps // stride),
        upper / (steps // stride),
    )
