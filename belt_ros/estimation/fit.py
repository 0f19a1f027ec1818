"""Whether innovations are as large as the filter says they may be.

Squared and normalised by its covariance, the innovation of a filter that is right is chi-square
distributed, with as many degrees of freedom as there are sensors. Its mean over the last seconds
is then 1 per degree of freedom, within limits that the number of samples sets.

Each sample is clipped at what one in a thousand would exceed, so that a single outlier, or a load
step, does not make a verdict; mean and variance of what is left are accounted for. A mean of
several is therefore reported as too small, a sustained one above the limits still as above.

Even a right filter is not exactly chi-square: after a change of the load it deliberately takes
loads for livelier than they are. Verdicts leave room for that, more on the harmless side.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtr, chdtrc, chdtri

from belt_ros.estimation.estimate import UNKNOWN_FIT, Consistency, Fit
from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]

_CLIPPED = 1e-3  # share of samples that are clipped
_MEMORY = 10.0  # [s]
_FEWEST = 20.0  # samples within the memory for a verdict; slower than 2 a second there is none
_LOWEST, _HIGHEST = 0.3, 1.25  # means that are consistent however many the samples
SPEEDS = ("driver speed", "driven speed")
BOTH_SPEEDS = "both speeds"
_ALIKE = 1.5  # times another's mean, up to which none stands out
_MANY = 500.0  # degrees of freedom from which on the limits are these
LIMIT_95 = 1.959964  # deviations of a normal distribution
LIMIT_999 = 3.290527


class _Clipped(NamedTuple):
    """A chi-square variable, clipped and scaled to its mean before."""

    clip: float
    scale: float
    variance: float


@lru_cache(maxsize=64)
def _clipped(degrees_of_freedom: int) -> _Clipped:
    n = degrees_of_freedom
    clip = float(chdtri(n, _CLIPPED))
    beyond = float(chdtrc(n, clip))
    mean = n * float(chdtr(n + 2, clip)) + clip * beyond
    square = n * (n + 2) * float(chdtr(n + 4, clip)) + clip * clip * beyond
    scale = n / mean
    return _Clipped(clip, scale, scale * scale * (square - mean * mean))


_SINGLE = _clipped(1)


def _degrees(expected: float, variance: float) -> float:
    """Degrees of freedom of a chi-square variable, scaled to this mean and variance."""
    return 2.0 * expected**2 / variance if variance > 0.0 else 0.0


def chi_square_limit(degrees_of_freedom: float, deviations: float) -> float:
    """Quantile of chi-square over its degrees of freedom, by Wilson and Hilferty.

    Parameters
    ----------
    degrees_of_freedom : float
        Need not be whole.
    deviations : float
        Of the normal distribution at that quantile; see `LIMIT_95`, `LIMIT_999`.

    Returns
    -------
    float
        [-], within 2 % from 20 degrees of freedom on, up to `LIMIT_999`. DOI
        10.1073/pnas.17.12.684.
    """
    variance = 2.0 / (9.0 * degrees_of_freedom)
    return float(max(1.0 - variance + deviations * math.sqrt(variance), 0.0) ** 3)


class InnovationFit:
    """Forgetting mean of innovations squared, and what it says of the filter.

    Parameters
    ----------
    memory : float
        Time in which a sample's weight falls to 1/e [s]. Samples may come at any times, each with
        its own degrees of freedom.
    """

    def __init__(self, memory: float = _MEMORY) -> None:
        self._memory = memory
        self._count = 0.0
        self._squared = 0.0
        self._expected = 0.0
        self._variance = 0.0  # of the sum of squares, if the filter is right

    def update(self, squared: float, degrees_of_freedom: int, dt: float) -> None:
        """Take in one sample, `dt` [s] after the one before; one that says nothing only ages."""
        kept = math.exp(-max(dt, 0.0) / self._memory)
        self._count *= kept
        self._squared *= kept
        self._expected *= kept
        self._variance *= kept * kept
        if degrees_of_freedom > 0 and squared >= 0.0:
            level = _clipped(degrees_of_freedom)
            self._count += 1.0
            self._squared += level.scale * min(squared, level.clip)
            self._expected += degrees_of_freedom
            self._variance += level.variance

    @property
    def degrees_of_freedom(self) -> float:
        """Of the chi-square distribution whose mean and variance the weighted sum has, scaled."""
        return _degrees(self._expected, self._variance)

    def limits(self, deviations: float) -> tuple[float, float]:
        """Two-sided chi-square limits of the mean, of `LIMIT_95` or `LIMIT_999`, without room."""
        n = self.degrees_of_freedom
        if n <= 0.0:
            return math.nan, math.nan
        return chi_square_limit(n, -deviations), chi_square_limit(n, deviations)

    @property
    def fit(self) -> Fit:
        """Mean, the limits of the verdict, and the verdict."""
        return _judged(self._count, self._squared, self._expected, self.degrees_of_freedom)


def _judged(count: float, squared: float, expected: float, degrees_of_freedom: float) -> Fit:
    """Return the verdict on weighted sums: of samples, of squares, of what these should be."""
    if count < _FEWEST:
        return UNKNOWN_FIT
    mean = squared / expected
    low, high = _LOWEST, _HIGHEST
    if degrees_of_freedom < _MANY:
        low = min(low, chi_square_limit(degrees_of_freedom, -LIMIT_999))
        high = max(high, chi_square_limit(degrees_of_freedom, LIMIT_999))
    if mean > high:
        return Fit(Consistency.OVERCONFIDENT, mean, low, high)
    if mean < low:
        return Fit(Consistency.UNDERCONFIDENT, mean, low, high)
    return Fit(Consistency.CONSISTENT, mean, low, high)


@compiled
def _age_and_add(
    sums: _Floats, seen: _Places, squared: _Floats, kept: float, clip: float, scale: float
) -> None:
    """Age rows of weighted sums (samples, squared weights, squares), and add a sample to some."""
    for row in sums:
        row[0] *= kept
        row[1] *= kept * kept
        row[2] *= kept
    for i in range(seen.shape[0]):
        if squared[i] >= 0.0:
            row = sums[seen[i]]
            row[0] += 1.0
            row[1] += 1.0
            row[2] += scale * min(squared[i], clip)


class SensorFits:
    """What `InnovationFit` is, for each sensor by itself, to find the one that does not fit.

    Parameters
    ----------
    sensors : sequence of str
        Their names, in words.
    memory : float
        As of `InnovationFit` [s].
    """

    def __init__(self, sensors: Sequence[str], memory: float = _MEMORY) -> None:
        self._sensors = tuple(sensors)
        self._memory = memory
        self._sums = np.zeros((len(self._sensors), 3))

    def update(self, seen: _Places, squared: _Floats, dt: float) -> None:
        """Take in a sample, `dt` [s] after the one before.

        Parameters
        ----------
        seen : ndarray of int
            Places of the sensors (k,) that are there; the others only age.
        squared : ndarray
            Squares of their innovations (k,), each over its own variance.
        dt : float
        """
        kept = math.exp(-max(dt, 0.0) / self._memory)
        _age_and_add(self._sums, seen, squared, kept, _SINGLE.clip, _SINGLE.scale)

    @property
    def fits(self) -> tuple[tuple[str, Fit], ...]:
        """Name and fit of every sensor."""
        return tuple(
            (sensor, _judged(count, total, count, _degrees(count, _SINGLE.variance * squares)))
            for sensor, (count, squares, total) in zip(
                self._sensors, self._sums.tolist(), strict=True
            )
        )


def worst_sensor(fits: Sequence[tuple[str, Fit]]) -> tuple[str, Fit] | None:
    """Return the sensor farthest above its limits, or None if none is.

    It is where a contradiction shows, which need not be its cause: noise shows in the sensor that
    is noisy, but a wrong torque in the speeds, which do not follow from it. If a speed is worst and
    does not stand out from the other, both are named: what the pulleys gain does not follow.
    """
    over = [pair for pair in fits if pair[1].consistency is Consistency.OVERCONFIDENT]
    if not over:
        return None
    name, worst = max(over, key=lambda pair: pair[1].mean)
    others = [fit.mean for sensor, fit in fits if sensor in SPEEDS and sensor != name]
    if name in SPEEDS and others and worst.mean < _ALIKE * others[0]:  # NaN: never read
        return BOTH_SPEEDS, worst
    return name, worst
