"""What a bag says of its belt, and what it does not."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation import Prior
from belt_ros.identify.curve import Curve

_Floats = NDArray[np.float64]
QUANTITIES = ("tension", "friction_stiffness", "friction_coefficient", "ratio_bias")
_SIGMAS_95 = 1.959964
_UNLIKELY = 0.01
_TOLD = 0.8  # of the prior's interval: wider than that, the data do not tell


@dataclass(frozen=True)
class Interval:
    """A quantity with its 95 % interval by profile likelihood, prior included."""

    value: float
    low: float
    high: float
    prior_low: float
    prior_high: float
    unit: str
    log_stddev: float | None  # of the logarithm; None: not a logarithm

    @property
    def share(self) -> float:
        """Width of the interval over that of the prior [-]."""
        if self.log_stddev is None:
            return (self.high - self.low) / (self.prior_high - self.prior_low)
        return math.log(self.high / self.low) / math.log(self.prior_high / self.prior_low)

    @property
    def told(self) -> bool:
        """Whether the data say more than the prior."""
        return self.share < _TOLD

    @property
    def stddev(self) -> float:
        """Standard deviation of the normal or log-normal with this interval [the unit]."""
        if self.log_stddev is None:
            return 0.5 * (self.high - self.low) / _SIGMAS_95
        return self.mean * math.sqrt(math.expm1(self.log_stddev**2))

    @property
    def mean(self) -> float:
        """Mean of the normal or log-normal with this interval."""
        if self.log_stddev is None:
            return self.median
        return self.median * math.exp(0.5 * self.log_stddev**2)

    @property
    def median(self) -> float:
        """Middle of the interval: `value`, unless the data bend it."""
        if self.log_stddev is None:
            return 0.5 * (self.low + self.high)
        return math.sqrt(self.low * self.high)


class Goodness(NamedTuple):
    """How well the model fits the loads."""

    squares: float  # sum of squares, priors included
    loads: int  # its expectation, if all is as assumed
    probability: float  # of a sum that large or larger
    scatter: float  # of points of one load, over that of the sensors' noise

    @property
    def fits(self) -> bool:
        """Whether the model fits as well as chance allows; else no interval is to be believed."""
        return self.probability >= _UNLIKELY


@dataclass(frozen=True)
class Identified:
    """What a bag says of a belt.

    Attributes
    ----------
    bag, drive : str
        Names.
    begin_ns : int
        When the bag begins, on the sensors' clock.
    tension, friction_stiffness, friction_coefficient, ratio_bias, capacity : Interval
        Tension [N] held by the tensioning, kf [N/m2], mu [-], relative error of R1/R2 [-], and
        torque [N m] on the driven pulley at gross slip.
    correlation : ndarray
        (4, 4), of ln T, ln kf, ln mu and ratio bias, to first order.
    goodness : Goodness
    curve : Curve
        The loads it is made from.
    greatest_torque : float
        On the driven pulley, among them [N m].
    warnings : tuple of str
    """

    bag: str
    drive: str
    begin_ns: int
    tension: Interval
    friction_stiffness: Interval
    friction_coefficient: Interval
    ratio_bias: Interval
    capacity: Interval
    correlation: _Floats
    goodness: Goodness
    curve: Curve
    greatest_torque: float
    warnings: tuple[str, ...]

    def prior(self, before: Prior) -> dict[str, float]:
        """Return the parameters ``prior.*`` that are to be replaced: of what the data tell.

        The ratio bias has no parameter of its own but its deviation; the bias itself belongs into
        the radii, see `with_identified`.
        """
        changed: dict[str, float] = {}
        if self.tension.told:
            changed |= {"tension": self.tension.mean, "tension_stddev": self.tension.stddev}
        if self.friction_stiffness.told:
            spread = self.friction_stiffness.log_stddev or 0.0
            changed["friction_stiffness"] = self.friction_stiffness.median
            changed["friction_stiffness_decades"] = spread / math.log(10.0)
        if self.friction_coefficient.told:
            changed["friction_coefficient"] = self.friction_coefficient.mean
            changed["friction_coefficient_stddev"] = self.friction_coefficient.stddev
        if self.ratio_bias.told:
            changed["ratio_bias_stddev"] = min(self.ratio_bias.stddev, before.ratio_bias_stddev)
        return changed


def log_interval(
    value: float, ends: tuple[float, float], prior: tuple[float, float], unit: str
) -> Interval:
    """Return an interval from logarithms: of value and ends, and the prior's mean and deviation."""
    mean, stddev = prior
    reach = _SIGMAS_95 * stddev
    return Interval(
        math.exp(value),
        math.exp(ends[0]),
        math.exp(ends[1]),
        math.exp(mean - reach),
        math.exp(mean + reach),
        unit,
        0.5 * (ends[1] - ends[0]) / _SIGMAS_95,
    )


def plain_interval(value: float, ends: tuple[float, float], stddev: float, unit: str) -> Interval:
    """Return the interval of a quantity whose prior is about zero."""
    reach = _SIGMAS_95 * stddev
    return Interval(value, *ends, -reach, reach, unit, None)
