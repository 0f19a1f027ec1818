"""Least squares, and how far each quantity may be off: profiles of the sum of squares."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, least_squares
from scipy.stats import chi2

from belt_ros.identify.model import BELT, SlipModel

_Floats = NDArray[np.float64]
Function = Callable[[_Floats], float]  # of the belt's four unknowns, in deviations of its prior
_CONFIDENCE = 0.95
_RISE = float(chi2.ppf(_CONFIDENCE, 1))
_HELD = 1e3  # weight by which a quantity is held
_FARTHEST = 12.0  # deviations from the best value at which an interval ends at the latest
_FINE = 1e-2  # of the deviation, to which an end of an interval is found
# Of ln T and ln kf, in deviations of their priors.
_STARTS = ((0.0, 0.0), (-1.5, 0.0), (1.5, 0.0), (0.0, -1.5), (0.0, 1.5))


class Fit(NamedTuple):
    """The most probable values, in standard deviations of the priors."""

    unknowns: _Floats
    squares: float
    covariance: _Floats  # (4, 4) of the belt's, to first order


def fitted(model: SlipModel) -> Fit:
    """Return the least squares, the best of several starts."""
    best: Fit | None = None
    for near in _STARTS:
        start = model.start
        start[: len(near)] = near
        found = least_squares(model.residuals, start, model.jacobian, max_nfev=100)
        squares = 2.0 * float(found.cost)
        if best is None or squares < best.squares:
            information = found.jac.T @ found.jac
            covariance = np.linalg.inv(information)[: len(BELT), : len(BELT)]
            best = Fit(found.x, squares, covariance)
    assert best is not None
    return best


class Profile:
    """The least sum of squares where a function of the belt is held at a value."""

    def __init__(self, model: SlipModel, fit: Fit, function: Function) -> None:
        self._model = model
        self._fit = fit
        self._function = function
        self.best = function(fit.unknowns[: len(BELT)])
        gradient = self._gradient(fit.unknowns)
        self.stddev = math.sqrt(float(gradient @ fit.covariance @ gradient))
        self._near = fit.unknowns

    def interval(self) -> tuple[float, float]:
        """Return the values between which 95 % lie, by the rise of the sum of squares."""
        return self._end(-1.0), self._end(1.0)

    def _end(self, side: float) -> float:
        self._near = self._fit.unknowns

        def above(distance: float) -> float:
            return self._squares(self.best + side * distance) - self._fit.squares - _RISE

        inner, outer = 0.0, math.sqrt(_RISE) * self.stddev
        while above(outer) < 0.0:
            inner, outer = outer, 1.5 * outer
            if outer > _FARTHEST * max(self.stddev, 1.0):
                return self.best + side * outer
        distance = brentq(
            lambda at: -_RISE if at == 0.0 else above(at), inner, outer, xtol=_FINE * self.stddev
        )
        return self.best + side * float(distance)

    def _squares(self, value: float) -> float:
        """Least sum of squares at `value`."""
        found = least_squares(
            lambda x: np.append(self._model.residuals(x), _HELD * (self._value(x) - value)),
            self._near,
            lambda x: np.concatenate([self._model.jacobian(x), self._held_gradient(x)]),
            max_nfev=30,
        )
        self._near = found.x
        return 2.0 * float(found.cost)

    def _value(self, unknowns: _Floats) -> float:
        return self._function(unknowns[: len(BELT)])

    def _gradient(self, unknowns: _Floats) -> _Floats:
        belt = unknowns[: len(BELT)]
        here = self._function(belt)
        step = 1e-4
        return np.array(
            [(self._function(row) - here) / step for row in belt + step * np.eye(len(belt))]
        )

    def _held_gradient(self, unknowns: _Floats) -> _Floats:
        row = np.zeros((1, len(unknowns)))
        row[0, : len(BELT)] = _HELD * self._gradient(unknowns)
        return row
