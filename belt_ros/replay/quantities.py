"""Values of a summary: a quantity with its interval, and the most remarkable value of one."""

import math
from dataclasses import dataclass

from belt_ros.estimation import Quantity
from belt_ros.estimation.estimate import log_spread

LOG_NORMAL = ("friction_stiffness", "friction_coefficient")
_SIGMAS_95 = 1.96


@dataclass(frozen=True)
class Extreme:
    """The most remarkable value of a quantity, and when: `time` [s] after the first measurement."""

    value: float
    stddev: float
    stamp_ns: int
    time: float


@dataclass(frozen=True)
class FinalQuantity:
    """A quantity, at the end unless said otherwise, with its 95 % interval."""

    value: float
    stddev: float
    low: float
    high: float
    unit: str


@dataclass(frozen=True)
class BestKnown(FinalQuantity):
    """A quantity when it was known best: `time` [s] after the first measurement."""

    stamp_ns: int
    time: float


def interval_95(name: str, quantity: Quantity) -> tuple[float, float]:
    """95 % interval of a quantity; friction is log-normal, its value the median."""
    if name not in LOG_NORMAL:
        return quantity.interval()
    factor = math.exp(_SIGMAS_95 * log_spread(quantity))
    return quantity.value / factor, quantity.value * factor


def with_interval(name: str, quantity: Quantity, unit: str) -> FinalQuantity:
    """Return a quantity with its 95 % interval."""
    return FinalQuantity(*quantity, *interval_95(name, quantity), unit)
