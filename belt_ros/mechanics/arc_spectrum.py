"""Eigenvalues of an arc's small vibrations in scaled form: a string on springs, with a dashpot.

With xi = s/L along the wrapped length L = R phi, beta = v/v_cr (Eq. 72) and gamma = 1 - beta^2,
the substitution u = e^(i omega t + beta z xi) f(xi), z = i omega L/(gamma v_cr), takes the
gyroscopic terms out of Eqs. 63-68 and leaves

    f'' - M f' - (z^2 + k) f = 0,     f(0) = 0,     f'(1) + beta z f(1) = 0

with f and f' continuous from zone to zone: k = X^2 = kf L^2/(EA - m v^2), M = 0 where the belt is
sprung, and k = 0, M = sigma mu phi where it slides. The belt's travel is left as a dashpot at the
outlet. In the form (p f')' = p (z^2 + k) f, with p = exp(-integral of M), multiplied by the
conjugate of f and integrated over the arc,

    A z^2 + beta p(1) |f(1)|^2 z + B = 0,    A = int p |f|^2,    B = int p (|f'|^2 + k |f|^2)

with A, B > 0 and f(1) not 0: Re z < 0 for every eigenvalue where 0 < beta < 1, and Re z = 0 where
beta = 0.

The eigenvalues are found by Galerkin's method on Gauss-Lobatto-Legendre elements, which sees all of
them at once, and polished by Newton's method on the exact characteristic function.
"""

from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import Legendre
from numpy.typing import NDArray
from scipy.linalg import cholesky, eigvals

_Floats = NDArray[np.float64]
_Complex = NDArray[np.complex128]

_SPARE = 6  # eigenvalues polished beyond those asked for
_NEWTON_STEPS = 40
_CONVERGED = 1e-8
_FARTHEST_MOVE = 0.5  # of a start, else what it found belongs to another or is none
_CLOSE = 1e-3  # a start this good stands for an eigenvalue of its own
_LAYER = 30.0  # the widest stretch of decay lengths that one element resolves
_LEAST_ZONE = 1e-6  # shorter ones the elements leave to Newton's method
_GRADING = 8.0  # how fast elements shrink towards a boundary layer
_SHAPE_POINTS = 1001


class Zone(NamedTuple):
    """A piece of the arc with one friction state, in the scaled form of the module's docstring."""

    length: float  # share of the arc [-]
    drift: float  # M [-]
    spring: float  # k [-]


class _Element(NamedTuple):
    """A finite element: its zone's numbers, the weight p at its start and its degree."""

    length: float
    drift: float
    spring: float
    weight: float
    degree: int


class _Rule(NamedTuple):
    """Gauss-Lobatto-Legendre nodes on [-1, 1], their weights and the derivative at the nodes."""

    nodes: _Floats
    weights: _Floats
    derivative: _Floats


class _Propagator(NamedTuple):
    """State (f, f') at a zone's end from that at its start, over a positive factor e^log_scale."""

    matrix: _Complex  # (..., 2, 2)
    slope: _Complex  # its derivative in z, at constant scale
    log_scale: _Floats


@lru_cache(maxsize=64)
def _lobatto(degree: int) -> _Rule:
    polynomial = Legendre.basis(degree)
    inner = np.sort(polynomial.deriv().roots().real)
    nodes = np.concatenate([[-1.0], inner, [1.0]])
    at_nodes = polynomial(nodes)
    distance = nodes[:, None] - nodes
    np.fill_diagonal(distance, 1.0)
    derivative = at_nodes[:, None] / at_nodes / distance
    np.fill_diagonal(derivative, 0.0)
    np.fill_diagonal(derivative, -derivative.sum(axis=1))
    return _Rule(nodes, 2.0 / (degree * (degree + 1) * at_nodes**2), derivative)


def _elements(zones: tuple[Zone, ...], count: int) -> list[_Element]:
    """Cut the zones into elements fine enough for `count` modes and for every boundary layer."""
    elements, weight = [], 1.0
    for zone in zones:
        layer = zone.length
        cuts = [0.0]
        while layer * np.sqrt(zone.spring) > _LAYER:
            layer /= _GRADING
            cuts.append(zone.length - layer)
        cuts.append(zone.length)
        for start, end in pairwise(cuts):
            waves = count if start == 0.0 else count / _GRADING
            degree = 16 + int(2.5 * waves)
            at_start = weight * np.exp(-zone.drift * start)
            elements.append(_Element(end - start, zone.drift, zone.spring, at_start, degree))
        weight *= np.exp(-zone.drift * zone.length)
    return elements


def _discrete_eigenvalues(zones: tuple[Zone, ...], beta: float, count: int) -> _Complex:
    """All eigenvalues z of the discretised arc.

    With S = L L^T the problem A z^2 + D z + S = 0, A scaled to one, becomes that of
    [[0, L^T], [-L, -D]]: skew but for the dashpot, so that an undamped arc stays undamped.
    """
    elements = _elements(zones, count)
    size = sum(element.degree for element in elements)
    mass, stiffness = np.zeros(size + 1), np.zeros((size + 1, size + 1))
    first = 0
    for length, drift, spring, weight, degree in elements:
        rule = _lobatto(degree)
        here = slice(first, first + degree + 1)
        density = weight * np.exp(-0.5 * drift * length * (rule.nodes + 1.0)) * rule.weights
        mass[here] += 0.5 * length * density
        stiffness[here, here] += (rule.derivative.T * density) @ rule.derivative * (2.0 / length)
        stiffness[here, here] += np.diag(0.5 * length * spring * density)
        first += degree
    outlet = float(np.exp(-sum(zone.drift * zone.length for zone in zones)))
    scale = 1.0 / np.sqrt(mass[1:])
    factor = cholesky(stiffness[1:, 1:] * scale[:, None] * scale, lower=True)
    system = np.zeros((2 * size, 2 * size))
    system[:size, size:] = factor.T
    system[size:, :size] = -factor
    system[-1, -1] = -beta * outlet / mass[-1]
    return np.asarray(eigvals(system), dtype=np.complex128)


def _propagator(z: _Complex, zone: Zone, distance: _Floats | float) -> _Propagator:
    """Exact solution of the zone's equation over a distance from its start; broadcasts."""
    square = z * z + zone.spring
    rate = np.sqrt(square + 0.25 * zone.drift**2)
    turn = rate * distance
    growth = np.abs(turn.real)
    up, down = np.exp(turn - growth), np.exp(-turn - growth)
    w = turn * turn
    small = np.abs(w) < 1e-3
    near, far = np.where(small, w, 0.0), np.where(small, 1.0, w)
    # cosh, sinh(r d)/r and the derivative of the latter in z, over z
    cosh = 0.5 * (up + down)
    sinhc = distance * np.where(
        small,
        (1.0 + near / 6.0 + near**2 / 120.0 + near**3 / 5040.0) * np.exp(-growth),
        0.5 * (up - down) / np.sqrt(far),
    )
    bend = distance**2 * np.where(
        small,
        distance * (1.0 / 3.0 + near / 30.0 + near**2 / 840.0) * np.exp(-growth),
        (distance * cosh - sinhc) / far,
    )
    half = 0.5 * zone.drift
    matrix = [cosh - half * sinhc, sinhc, square * sinhc, cosh + half * sinhc]
    slope = [
        z * (distance * sinhc - half * bend),
        z * bend,
        z * (2.0 * sinhc + square * bend),
        z * (distance * sinhc + half * bend),
    ]
    return _Propagator(
        np.stack(matrix, axis=-1).reshape(*turn.shape, 2, 2),
        np.stack(slope, axis=-1).reshape(*turn.shape, 2, 2),
        growth + half * distance,
    )


def characteristic(z: _Complex, zones: tuple[Zone, ...], beta: float) -> tuple[_Complex, _Complex]:
    """Exact characteristic function f'(1) + beta z f(1) and its derivative.

    Parameters
    ----------
    z : ndarray, shape (n,)
        Where to evaluate [-].
    zones : tuple of Zone
        From inlet to outlet.
    beta : float
        v/v_cr [-].

    Returns
    -------
    value, slope : ndarray, shape (n,)
        Both over one positive factor, different for each z, so that phase and Newton step hold.
    """
    state = np.zeros((*z.shape, 2, 1), dtype=np.complex128)
    state[..., 1, 0] = 1.0
    change = np.zeros_like(state)
    for zone in zones:
        step = _propagator(z, zone, zone.length)
        state, change = step.matrix @ state, step.slope @ state + step.matrix @ change
        size = np.abs(z)[:, None, None] * np.abs(state[..., :1, :]) + np.abs(state[..., 1:, :])
        state, change = state / size, change / size
    f, gradient = state[..., 0, 0], state[..., 1, 0]
    value = gradient + beta * z * f
    return value, change[..., 1, 0] + beta * (f + z * change[..., 0, 0])


def _polish(start: _Complex, zones: tuple[Zone, ...], beta: float) -> tuple[_Complex, _Floats]:
    """Newton's method from every start; where it ends, and the last relative step."""
    z, change = start.copy(), np.full(start.shape, np.inf)
    with np.errstate(all="ignore"):  # a start that is no eigenvalue may run away
        for _ in range(_NEWTON_STEPS):
            value, slope = characteristic(z, zones, beta)
            step = value / slope
            z = z - step
            change = np.abs(step) / np.abs(z)
            if not np.any(change > 1e-14):
                break
    return z, change


def eigenvalues(zones: tuple[Zone, ...], beta: float, count: int) -> _Complex:
    """Return the `count` eigenvalues z of least Im z >= 0, one of each conjugate pair.

    Parameters
    ----------
    zones : tuple of Zone
        From inlet to outlet, each of positive length.
    beta : float
        v/v_cr, 0 <= beta < 1 [-].
    count : int
        How many.

    Returns
    -------
    ndarray, shape (count,)
        Ordered by Im z, equal ones by -Re z. Real eigenvalues, which decay without oscillation,
        come first, each on its own.
    """
    resolved = tuple(zone for zone in zones if zone.length > _LEAST_ZONE)
    found = _discrete_eigenvalues(resolved, beta, count)
    found = found[found.imag >= 0.0]
    found = found[np.argsort(found.imag, kind="stable")][: count + _SPARE]
    # Near the critical speed a driver's belt creeps off as a whole, u constant where it slides: a
    # layer at the outlet in terms of f, too thin for the elements. All else has its own start.
    whole = beta * zones[-1].drift / ((1.0 - beta) * (1.0 + beta))
    start = np.append(found, whole) if whole < 0.0 else found
    z, change = _polish(start, zones, beta)
    z = np.where(np.abs(z.imag) < 1e-12 * np.abs(z), z.real, z.real + 1j * np.abs(z.imag))
    moved = np.abs(z - start) / np.abs(start)
    converged = (change < _CONVERGED) & (moved < _FARTHEST_MOVE)
    own = (moved < _CLOSE) & (np.arange(start.size) < found.size)
    kept: list[complex] = []
    for i in np.argsort(~own, kind="stable"):
        new = own[i] or not any(abs(z[i] - other) < 1e-6 * abs(other) for other in kept)
        if new and converged[i]:
            kept.append(complex(z[i]))
    kept.sort(key=lambda root: (root.imag, -root.real))
    return np.array(kept[:count])


def _unscaled_shape(z: complex, zones: tuple[Zone, ...], at: _Floats) -> tuple[_Complex, _Floats]:
    """Eigenfunction f with f'(0) = 1, as mantissa and exponent."""
    mantissa, exponent = np.zeros(at.shape, dtype=np.complex128), np.zeros(at.shape)
    state, log_scale, start = np.array([0.0, 1.0], dtype=np.complex128), 0.0, 0.0
    value = np.array([z], dtype=np.complex128)
    for i, zone in enumerate(zones):
        end = start + zone.length
        inside = at >= start if i else np.full(at.shape, fill_value=True)
        here = _propagator(value, zone, at[inside] - start)
        mantissa[inside] = (here.matrix @ state)[..., 0]
        exponent[inside] = log_scale + here.log_scale
        whole = _propagator(value, zone, zone.length)
        state = whole.matrix[0] @ state
        size = float(np.abs(state).max())
        state, log_scale = state / size, log_scale + float(whole.log_scale[0]) + np.log(size)
        start = end
    return mantissa, exponent


def shape(z: complex, zones: tuple[Zone, ...], beta: float, at: _Floats) -> _Complex:
    """Eigenfunction e^(beta z xi) f(xi), at most 1 in magnitude, its slope at the inlet positive.

    Parameters
    ----------
    z : complex
        Eigenvalue [-].
    zones, beta
        As for `eigenvalues`.
    at : ndarray, shape (n,)
        xi, 0 at the inlet to 1 at the outlet [-].
    """

    def log_shape(points: _Floats) -> _Complex:
        mantissa, exponent = _unscaled_shape(z, zones, points)
        with np.errstate(divide="ignore"):  # a node's logarithm is minus infinity
            return np.asarray(np.log(mantissa) + exponent + beta * z * points)

    ends = np.cumsum([0.0, *(zone.length for zone in zones)])
    grid = np.unique(np.linspace(ends[:-1], ends[1:], _SHAPE_POINTS))
    peak = int(np.argmax(log_shape(grid).real))
    fine = np.linspace(grid[max(peak - 1, 0)], grid[min(peak + 1, grid.size - 1)], 101)
    return np.asarray(np.exp(log_shape(at) - log_shape(fine).real.max()))
