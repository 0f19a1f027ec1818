"""From which mode a member of a Gaussian sum came, judged by where its tension was.

When modes change, the state does not. A smoothed member of a mode is what the mode's own moments
say, times what the measurements after it say of the state; parts of the mode that came from
different modes differ in the former only. So each origin's part of the member is the member, times
the origin's density, over the normal density of the mode's moments. A member whose tension the
settled part of the belief ruled out was changing already. The smoother of C.-J. Kim
(doi:10.1016/0304-4076(94)90036-1) takes the origin as independent of the state.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.gaussian_sum import Component, normalised

_Floats = NDArray[np.float64]
_MODES = 2
_LEAST_VARIANCE = 1e-30
_PLACES = np.linspace(-6.0, 6.0, 401)  # in a member, in its standard deviations
_NORMAL = np.exp(-0.5 * _PLACES**2) / np.sum(np.exp(-0.5 * _PLACES**2))
_PLACES = _PLACES / math.sqrt(float(_NORMAL @ _PLACES**2))  # a variance of one, to rounding
_LEAST_WIDTH = (_PLACES[1] - _PLACES[0]) ** 2 / 12.0


class Origins(NamedTuple):
    """Of the belief's members that came from mode i (row) into mode j (column), (2, 2) each."""

    share: _Floats  # of all weight
    mean: _Floats  # of the state in which modes differ
    variance: _Floats


def origins_of(members: list[Component], came_from: Sequence[bool], axis: int) -> Origins:
    """Sum up members, each of which was changing or not just before, as `came_from` says.

    `axis` is the state in which modes differ.
    """
    weights = normalised(np.array([member.log_weight for member in members]))
    values = np.array([member.mean[axis] for member in members])
    widths = np.array([member.covariance[axis, axis] for member in members])
    before = np.array(came_from, dtype=np.int64)
    after = np.array([member.changing for member in members], dtype=np.int64)
    shape = _MODES, _MODES
    origins = Origins(np.zeros(shape), np.zeros(shape), np.full(shape, _LEAST_VARIANCE))
    for at in np.ndindex(shape):
        here = (before == at[0]) & (after == at[1])
        total = float(np.sum(weights[here]))
        if total > 0.0:
            origins.share[at] = total
            mean, variance = _moments(weights[here] / total, values[here], widths[here])
            origins.mean[at], origins.variance[at] = mean, variance
    return origins


def traced(belief: list[Component], origins: Origins, axis: int) -> list[Component]:
    """Split every member into the parts that were in either mode before; its weight stays."""
    return [part for member in belief for part in _parts(member, origins, axis)]


def _moments(weights: _Floats, means: _Floats, variances: _Floats) -> tuple[float, float]:
    mean = float(weights @ means)
    variance = float(weights @ (variances + (means - mean) ** 2))
    return mean, max(variance, _LEAST_VARIANCE)


def _log_normal(x: _Floats, mean: _Floats | float, variance: _Floats | float) -> _Floats:
    return np.asarray(-0.5 * ((x - mean) ** 2 / variance + np.log(variance)))


def _parts(member: Component, origins: Origins, axis: int) -> list[Component]:
    mode = int(member.changing)
    possible = np.flatnonzero(origins.share[:, mode] > 0.0)
    variance = float(member.covariance[axis, axis])
    if len(possible) == 0 or not variance > 0.0:
        return [member]
    column = member.covariance[:, axis] / math.sqrt(variance)
    parts = []
    for origin, shares in zip(possible.tolist(), _shares(member, origins, axis), strict=True):
        total = float(np.sum(shares))
        if total > 0.0:
            place = float(shares @ _PLACES) / total
            width = max(float(shares @ (_PLACES - place) ** 2) / total, _LEAST_WIDTH)
            parts.append(
                Component(
                    member.log_weight + math.log(total),
                    member.mean + place * column,
                    member.covariance + (width - 1.0) * np.outer(column, column),
                    bool(origin),
                )
            )
    return parts


def _shares(member: Component, origins: Origins, axis: int) -> _Floats:
    """Share of each possible origin in the member's weight at each of `_PLACES`; the sum is 1."""
    mode = int(member.changing)
    possible = origins.share[:, mode] > 0.0
    share = origins.share[possible, mode] / np.sum(origins.share[possible, mode])
    mean, variance = origins.mean[possible, mode], origins.variance[possible, mode]
    x = member.mean[axis] + _PLACES * math.sqrt(member.covariance[axis, axis])
    log_shares = _log_normal(x, mean[:, None], variance[:, None]) + np.log(share)[:, None]
    log_shares = log_shares - _log_normal(x, *_moments(share, mean, variance)) + np.log(_NORMAL)
    shares = np.exp(log_shares - np.max(log_shares))
    return np.asarray(shares / np.sum(shares))
