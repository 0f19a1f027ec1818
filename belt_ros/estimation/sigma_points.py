"""An unscented filter whose points are moved together and whose covariance stays positive.

filterpy's `UnscentedKalmanFilter` carries the filter. Three things differ from the stock class, and
tests hold the result against it: all sigma points go through the process model in one call; the
square root is taken of the correlation matrix, since the states' scales differ by ten decades; and
a measurement that reads states directly is taken in with Joseph's form, which is what the
unscented transform of a linear function gives, exactly, for any subset of the sensors.
"""

from collections.abc import Callable

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter
from numpy.typing import NDArray

_Floats = NDArray[np.float64]
_JITTER = (0.0, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2)


def symmetric(matrix: _Floats) -> _Floats:
    """Return the symmetric part of a matrix."""
    return np.asarray(0.5 * (matrix + matrix.T))


def scaled_cholesky(covariance: _Floats) -> _Floats:
    """Upper Cholesky factor U with U.T U = P, taken on the correlation matrix.

    Rounding can leave a correlation matrix a little indefinite; the least addition to its diagonal
    that helps is made, which only ever widens the estimate.
    """
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    correlation = covariance / scale / scale[:, None]
    identity = np.eye(len(scale))
    for jitter in _JITTER:
        try:
            lower = np.linalg.cholesky(correlation + jitter * identity)
        except np.linalg.LinAlgError:
            continue
        return np.asarray(lower.T * scale)
    return np.diag(scale)


class BatchedUnscentedFilter(UnscentedKalmanFilter):  # type: ignore[misc]
    """Unscented filter over `propagate(states, dt)`, with all its states read directly.

    Parameters
    ----------
    dim : int
        Number of states.
    propagate : callable
        Moves an array of states (points, dim) by dt [s] and returns it.
    """

    def __init__(self, dim: int, propagate: Callable[[_Floats, float], _Floats]) -> None:
        # alpha = 1: a smaller one makes the centre weight hugely negative. beta = 0 and kappa = 1
        # keep every weight positive, so that a sum of them is a covariance.
        points = MerweScaledSigmaPoints(dim, 1.0, 0.0, 1.0, sqrt_method=scaled_cholesky)
        super().__init__(dim, dim, 1.0, None, None, points)
        self._propagate = propagate

    def posterior_points(self) -> _Floats:
        """Sigma points (2 dim + 1, dim) of the present state."""
        return np.asarray(self.points_fn.sigma_points(self.x, self.P))

    def compute_process_sigmas(self, dt: float, fx: object = None, **fx_args: object) -> None:
        """Draw points from the present state and move them all at once."""
        self.sigmas_f = self._propagate(self.posterior_points(), dt)

    def predict(self, dt: float, **_: object) -> None:
        """Advance state and covariance by `dt` [s]; `Q` is what `dt` adds."""
        self.compute_process_sigmas(dt)
        self.x = self.Wm @ self.sigmas_f
        spread = self.sigmas_f - self.x
        self.P = symmetric((spread.T * self.Wc) @ spread + self.Q)

    def innovation(self, z: _Floats, variance: _Floats, seen: NDArray[np.intp]) -> float:
        """Normalised innovation squared of readings `z` of the states `seen`, not yet taken in."""
        self.y = z - self.x[seen]
        self.S = self.P[np.ix_(seen, seen)] + np.diag(variance)
        self.K = np.linalg.solve(self.S, self.P[seen]).T
        return float(self.y @ np.linalg.solve(self.S, self.y))

    def update(self, z: _Floats, variance: _Floats, seen: NDArray[np.intp]) -> float:
        """Take in readings of the states `seen`; return their normalised innovation squared."""
        squared = self.innovation(z, variance, seen)
        keep = np.eye(len(self.x))
        keep[:, seen] -= self.K
        self.x = self.x + self.K @ self.y
        self.P = symmetric(keep @ self.P @ keep.T + (self.K * variance) @ self.K.T)
        return squared
