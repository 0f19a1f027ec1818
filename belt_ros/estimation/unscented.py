"""The unscented filter's work on points and covariance, compiled.

Two things are done differently from filterpy's stock class, against which tests hold the result:

* the square root is taken of the correlation matrix, since the states' scales differ by ten
  decades, and a pivot that rounding has made negative is lifted, which only widens the estimate;
* measurements read states directly, so each is taken in by Joseph's scalar form. That is what the
  unscented transform of a linear function gives, exactly, for any subset of the sensors.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.written import write
from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]
_SMALLEST_PIVOT = 1e-14
_ROUNDING = 1e-16  # of a variance
_DROWNED = 1e-8  # share of a variance below which differences of covariances are rounding


@compiled
def _factorise(upper: _Floats) -> None:
    """Make of the upper half of a covariance its upper Cholesky factor.

    A pivot made too small by rounding is lifted.
    """
    n = upper.shape[0]
    scales = np.empty((2, n))  # of each row, and one by it
    for i in range(n):
        scale = math.sqrt(max(upper[i, i], 0.0))
        scales[0, i], scales[1, i] = scale, 1.0 / scale if scale > 0.0 else 0.0
    for i in range(n):
        by_pivot = 0.0
        for j in range(i, n):
            rest = min(max(upper[i, j] * scales[1, i] * scales[1, j], -1.0), 1.0)
            for k in range(i):
                rest -= upper[k, i] * upper[k, j]
            if j == i:
                by_pivot = 1.0 / math.sqrt(max(rest, _SMALLEST_PIVOT))
                rest = max(rest, _SMALLEST_PIVOT)
            upper[i, j] = rest * by_pivot
    for i in range(n):
        for j in range(i, n):
            upper[i, j] *= scales[0, j]


@compiled
def upper_root(p: _Floats) -> _Floats:
    """Upper Cholesky factor, by the upper half; a pivot made too small by rounding is lifted."""
    n = p.shape[0]
    upper = np.zeros((n, n))
    for i in range(n):
        for j in range(i, n):
            upper[i, j] = p[i, j]
    _factorise(upper)
    return upper


@compiled
def _placed(upper: _Floats, order: _Places) -> _Floats:
    """Rows of a factor taken in `order`, their entries in the places of the states."""
    n = upper.shape[0]
    columns = np.zeros((n, n))
    for i in range(n):
        for j in range(i, n):
            columns[i, order[j]] = upper[i, j]
    return columns


@compiled
def _root(p: _Floats, order: _Places) -> _Floats:
    """Cholesky factor in `order`, a column a row, its entries in the places of the states."""
    n = p.shape[0]
    upper = np.empty((n, n))
    for i in range(n):
        for j in range(i, n):
            upper[i, j] = p[order[i], order[j]]
    _factorise(upper)
    return _placed(upper, order)


@compiled
def _root_with_sum(p: _Floats, order: _Places, at: int, along: _Floats) -> _Floats:
    """As `_root`, with the sum `along` of states in place of state `at`."""
    n = p.shape[0]
    with_sum, total = np.zeros(n), 0.0
    for j in range(n):
        if along[j] != 0.0:
            for i in range(n):
                with_sum[i] += along[j] * p[j, i]
    upper = np.empty((n, n))
    place = 0
    for i in range(n):
        total += along[i] * with_sum[i]
        if order[i] == at:
            place = i
        for j in range(i, n):
            upper[i, j] = p[order[i], order[j]]
    for i in range(place):
        upper[i, place] = with_sum[order[i]]
    upper[place, place] = total
    for j in range(place + 1, n):
        upper[place, j] = with_sum[order[j]]
    _factorise(upper)
    return _placed(upper, order)


@compiled
def points_about(x: _Floats, columns: _Floats, spread: _Floats) -> _Floats:
    """Points (2 n + 1, n): x, and x +- sqrt(spread[k]) times each of the `columns`, a row each."""
    points = np.empty((2 * x.shape[0] + 1, x.shape[0]))
    lay_points(points, x, columns, spread)
    return points


@compiled
def lay_points(points: _Floats, x: _Floats, columns: _Floats, spread: _Floats) -> None:
    """Set points to what `points_about` returns."""
    n = x.shape[0]
    write(points[0], x)
    for k in range(n):
        distance = math.sqrt(spread[k])
        for i in range(n):
            points[1 + k, i] = x[i] + distance * columns[k, i]
            points[1 + n + k, i] = x[i] - distance * columns[k, i]


@compiled
def sigma_points(x: _Floats, covariance: _Floats, order: _Places, spread: _Floats) -> _Floats:
    """Points x and x +- sqrt(spread[k]) times the k-th column of the Cholesky factor.

    The factor is taken in `order`: its first column is the whole of the first state in it, with all
    that goes with it, the second what is left of the second, and so on.
    """
    return points_about(x, _root(covariance, order), spread)


@compiled
def columns_along(covariance: _Floats, order: _Places, at: int, along: _Floats) -> _Floats:
    """Columns (n, n), a row each, of the Cholesky factor that has a sum in place of state `at`.

    `along` (n,) says how often each state counts in the sum, `at` once. Columns after that of `at`
    leave the sum as it is.
    """
    columns = _root_with_sum(covariance, order, at, along)
    for i in range(along.shape[0]):
        if along[i] != 0.0 and i != at:
            for k in range(columns.shape[0]):
                columns[k, at] -= along[i] * columns[k, i]
    return columns


@compiled
def mean_and_deviation(rows: _Floats, weights: _Floats) -> tuple[_Floats, _Floats]:
    """Weighted mean and standard deviation of rows, column by column."""
    count, n = rows.shape
    mean = np.zeros(n)
    for p in range(count):
        for i in range(n):
            mean[i] += weights[p] * rows[p, i]
    deviation = np.zeros(n)
    for p in range(count):
        for i in range(n):
            deviation[i] += weights[p] * (rows[p, i] - mean[i]) ** 2
    for i in range(n):
        deviation[i] = math.sqrt(deviation[i])
    return mean, deviation


@compiled
def take_in(
    x: _Floats, covariance: _Floats, z: _Floats, variance: _Floats, seen: _Places
) -> tuple[_Floats, _Floats]:
    """Update by readings `z` of the states `seen`, each of its own `variance`."""
    x, p = x.copy(), covariance.copy()
    take_in_place(x, p, z, variance, seen, np.empty((4, x.shape[0])))
    return x, p


@compiled
def take_in_place(
    x: _Floats, p: _Floats, z: _Floats, variance: _Floats, seen: _Places, scratch: _Floats
) -> None:
    """As `take_in`, changing `x` (n,) and its covariance `p` (n, n); `scratch` is (4, n)."""
    n = x.shape[0]
    row, gain, rest, before = scratch[0], scratch[1], scratch[2], scratch[3]
    for reading in range(z.shape[0]):
        at = seen[reading]
        total = p[at, at] + variance[reading]
        innovation = z[reading] - x[at]
        for i in range(n):
            row[i], before[i] = p[at, i], p[i, i]
            gain[i] = row[i] / total
            rest[i] = row[i] - 0.5 * total * gain[i]
            x[i] += gain[i] * innovation
        for i in range(n):
            for j in range(n):
                p[i, j] -= gain[i] * rest[j] + rest[i] * gain[j]
        left = variance[reading] / total
        if left < _DROWNED:
            for i in range(n):
                p[at, i] = p[i, at] = row[i] * left
        for i in range(n):
            if not p[i, i] >= _ROUNDING * before[i]:  # nothing of it is left but rounding
                p[i, :] = p[:, i] = 0.0
                p[i, i] = _ROUNDING * before[i]
        p[at, at] = before[at] * variance[reading] / total


class GradedSigmaPoints:
    """Sigma points nearer where the model bends and farther where it is straight.

    Stock points all lie sqrt(n + kappa) standard deviations out, 3.5 for eleven states, which takes
    a bend seen that far out for one of the member's own width. Here each state has its own
    distance; all weights are positive, and the weighted points have the mean and covariance asked
    for. A points object for filterpy's filters.

    Parameters
    ----------
    order : sequence of int
        All states, in the order in which the Cholesky factor takes them.
    squared_distances : sequence of float
        For the first states in `order`, in variances. The other states share what weight is left.
    at : int
        A state in whose place a sum of states is taken, see `columns_along` ...
    along : callable, optional
        ... from a state (n,) to that sum's coefficients (n,), 1 for `at`. Without it, the state
        itself is taken.

    Raises
    ------
    ValueError
        If the first states leave no weight for the others.
    """

    def __init__(
        self,
        order: Sequence[int],
        squared_distances: Sequence[float],
        at: int = 0,
        along: Callable[[_Floats], _Floats] | None = None,
    ) -> None:
        self.n = len(order)
        self.order = np.array(order, dtype=np.int64)
        near = np.array(squared_distances)
        left = 1.0 - float(np.sum(1.0 / near))
        if not left > 0.0:
            raise ValueError(f"the squared distances {near} leave {left:g} of the weight; want > 0")
        others = self.n - len(near)
        self.spread = np.concatenate([near, np.full(others, others / left)])
        self.Wm = self.Wc = np.concatenate([[0.0], 0.5 / self.spread, 0.5 / self.spread])
        self._at = at
        self._along = along

    def num_sigmas(self) -> int:
        """Return the number of points."""
        return 2 * self.n + 1

    def sigma_points(self, x: _Floats, covariance: _Floats) -> _Floats:
        """Return the points (2 n + 1, n) of mean `x` (n,) and `covariance` (n, n)."""
        if self._along is None:
            return sigma_points(x, covariance, self.order, self.spread)
        along = self._along(x)
        columns = columns_along(covariance, self.order, self._at, along)
        return points_about(x, columns, self.spread)
