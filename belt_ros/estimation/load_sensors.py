"""What load sensors read, hub loads and the tension of a span, and how a filter takes them in.

A belt that turns round anything, a pulley or the roller of a tension sensor, presses on it by
w = T - m v^2 only: the rest of its tension turns its own momentum round. On a pulley with wrap phi
the two spans together pull the shaft by the vector w_H t_H + w_L t_L, t along the spans. Its part
along the bisector of the spans, which is what a load cell under the bearing or the rod of a
tensioner carries and what balances between the two pulleys, is

    (w_H + w_L) sin(phi / 2)

The part across, (w_H - w_L) cos(phi / 2), is nothing at a wrap of pi. The roller of a span that it
bends by delta carries 2 w sin(delta / 2); calibrated at standstill it reads w.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.state import Index, Reading
from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants

_Floats = NDArray[np.float64]
_DRIVER_SPEED = int(Index.DRIVER_SPEED)
_TORQUE = int(Reading.TRANSMITTED_TORQUE)
_TIGHT = int(Reading.TIGHT_TENSION)
_SLACK = int(Reading.SLACK_TENSION)
_LEAST_NET = 1e-3  # of EA, what is left of it above the critical speed, as in `tensions_at_pull`


class Load(IntEnum):
    """Places in a row of load readings; all in newtons."""

    DRIVER_HUB = 0
    DRIVEN_HUB = 1
    SPAN = 2


LOADS = len(Load)


@compiled
def loads_of_tensions(
    c: DriveConstants, tight: float, slack: float, pull: float, belt_speed: float
) -> tuple[float, float, float]:
    """Return what load sensors read, in the order of `Load` [N].

    Parameters
    ----------
    c : DriveConstants
    tight, slack : float
        T_H, T_L [N].
    pull : float
        Effective pull [N] or its torque [N m], of which the sign counts: where it turns the driven
        pulley in its positive sense, the span with the sensor is the tight one, else the slack.
    belt_speed : float
        v [m/s].

    Notes
    -----
    w_L = T_L - m v^2 and w_H = w_L + M/R, the effective pull M/R being (T_H - T_L)(1 - m v^2/EA):
    the stretched belt of the tight span is the faster one (docs/mechanics.md).
    """
    lift = c.mass_per_length * belt_speed * belt_speed
    low = slack - lift
    high = low + max(1.0 - lift / c.axial_stiffness, _LEAST_NET) * (tight - slack)
    return (
        (low + high) * math.sin(0.5 * c.driver_wrap),
        (low + high) * math.sin(0.5 * c.driven_wrap),
        high if pull >= 0.0 else low,
    )


@compiled
def load_readings(c: DriveConstants, states: _Floats, readings: _Floats) -> _Floats:
    """Rows (n, 3) of `Load` from rows of states and what `state.read` reads off them.

    The belt's inertia is taken at the first row's speed, as in `state.read`.
    """
    speed = abs(c.driver_radius * states[0, _DRIVER_SPEED])
    out = np.empty((readings.shape[0], LOADS))
    for i in range(readings.shape[0]):
        row = readings[i]
        out[i, 0], out[i, 1], out[i, 2] = loads_of_tensions(
            c, row[_TIGHT], row[_SLACK], row[_TORQUE], speed
        )
    return out


class Observed(NamedTuple):
    """A Gaussian after one scalar reading, and how well that was foretold."""

    x: _Floats  # (n,)
    covariance: _Floats  # (n, n)
    innovation: float  # reading less its mean prediction
    variance: float  # of the innovation, sensor noise included


@compiled
def _foretold(
    x: _Floats, points: _Floats, weights: _Floats, predicted: _Floats
) -> tuple[float, float, _Floats]:
    """Mean and variance of predictions, and their covariance (n,) with the state."""
    count, n = points.shape
    mean, spread = 0.0, 0.0
    cross = np.zeros(n)
    for p in range(count):
        mean += weights[p] * predicted[p]
    for p in range(count):
        weighted = weights[p] * (predicted[p] - mean)
        spread += weighted * (predicted[p] - mean)
        for i in range(n):
            cross[i] += weighted * (points[p, i] - x[i])
    return mean, spread, cross


@compiled
def _left(deviations: _Floats, weights: _Floats, gain: _Floats, variance: float) -> _Floats:
    """Covariance (n, n) of weighted deviations (p, n), and of a noise that enters by a gain."""
    count, n = deviations.shape
    out = np.empty((n, n))
    for i in range(n):
        for j in range(i + 1):
            total = variance * gain[i] * gain[j]
            for p in range(count):
                total += weights[p] * deviations[p, i] * deviations[p, j]
            out[i, j] = total
            out[j, i] = total
    return out


@compiled
def observe(
    x: _Floats,
    covariance: _Floats,
    points: _Floats,
    weights: _Floats,
    predicted: _Floats,
    z: float,
    variance: float,
) -> Observed:
    """Take in one scalar reading of any function of the state, by unscented transform.

    With d the points' distances from x, e those of what they predict from its mean, c and s their
    covariance and the predictions' variance, the gain is k = c / (s + r), and

        P = sum of weight (d - k e)(d - k e)^T + k r k^T

    which is Joseph's form: P - k (s + r) k^T for points drawn from P, as in filterpy's stock
    filter, but positive semidefinite whatever rounding does.

    Parameters
    ----------
    x, covariance : ndarray
        Mean (n,) and covariance (n, n), as a missing reading leaves them.
    points, weights : ndarray
        Sigma points (p, n) drawn from them, and their weights (p,), none negative.
    predicted : ndarray
        The reading at each point (p,).
    z : float
        The reading. NaN, and predictions that are not finite, change nothing: innovation 0.
    variance : float
        r > 0 of the sensor's noise.
    """
    mean, spread, cross = _foretold(x, points, weights, predicted)
    innovation, total = z - mean, spread + variance
    if not (math.isfinite(innovation) and math.isfinite(total)):
        return Observed(x.copy(), covariance.copy(), 0.0, variance)
    gain, seen, rest = np.empty(x.size), np.empty(x.size), np.empty(points.shape)
    for i in range(x.size):
        gain[i] = cross[i] / total
        seen[i] = x[i] + gain[i] * innovation
        for p in range(points.shape[0]):
            rest[p, i] = points[p, i] - x[i] - (predicted[p] - mean) * gain[i]
    return Observed(seen, _left(rest, weights, gain, variance), innovation, total)
