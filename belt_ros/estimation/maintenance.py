"""What was done to the belt, and what is known of it then.

All tensions here are the belt's own, at standstill and without load. There the four kinds of
tensioning hold the same: both spans have one tension, which is their mean, the slack one, the
effective one that pulls on the hub (the belt does not move), and the one that fixed centres were
installed with. Under load, or with torque left in a belt that was stopped, only the mean of both
spans may be given, and that not for a held slack tension nor for fixed centres.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.condensing import condensed, renewed
from belt_ros.estimation.estimate import Quantity
from belt_ros.estimation.gaussian_sum import Component, mixture_moments, normalised
from belt_ros.estimation.process import lognormal
from belt_ros.estimation.state import Index
from belt_ros.estimation.unscented import take_in
from belt_ros.mechanics.drive import DriveError

_Floats = NDArray[np.float64]
_BEND = (Index.LOG_TENSION, Index.LOG_STIFFNESS)
_SURFACE = (Index.LOG_STIFFNESS, Index.LOG_FRICTION, Index.CREEP_ERROR)
_LEAST_TENSION, _GREATEST_TENSION = 1e-3, 1e9  # [N]
_LEAST_ERROR = 1e-4  # relative; no gauge is better
_UNBELIEVABLE = 1e-3  # probability below which a measurement is not explained by the belief
_OF_THE_PULLEYS = 0.5  # share of the ratio bias' variance; the rest is the belt's


class MaintenanceKind(IntEnum):
    """What was done; the numbers are those of belt_msgs/RecordMaintenance."""

    RETENSIONED = 1
    BELT_REPLACED = 2
    TENSION_MEASURED = 3


@dataclass(frozen=True)
class Maintenance:
    """What was done to the belt.

    Parameters
    ----------
    kind : MaintenanceKind
    tension : float
        Set, or measured, at standstill without load [N]. NaN: not known, for a belt replaced.
    stddev : float
        Its standard deviation [N]. NaN: as uncertain as the prior, where it was set.

    Raises
    ------
    DriveError
        If tension or deviation are missing, or cannot be.
    """

    kind: MaintenanceKind
    tension: float = math.nan
    stddev: float = math.nan

    def __post_init__(self) -> None:
        if math.isnan(self.tension):
            self._check_needless()
        elif not _LEAST_TENSION <= self.tension <= _GREATEST_TENSION:
            raise DriveError(
                f"the tension is {self.tension:g} N; it must lie between {_LEAST_TENSION:g} and "
                f"{_GREATEST_TENSION:g} N"
            )
        elif math.isnan(self.stddev):
            if self.kind is MaintenanceKind.TENSION_MEASURED:
                raise DriveError("a measured tension needs its standard deviation; it is missing")
        elif not _LEAST_ERROR * self.tension <= self.stddev <= self.tension:
            raise DriveError(
                f"the standard deviation is {self.stddev:g} N; it must lie between "
                f"{_LEAST_ERROR * self.tension:g} N and the tension, {self.tension:g} N"
            )

    def _check_needless(self) -> None:
        if self.kind is not MaintenanceKind.BELT_REPLACED:
            raise DriveError("the tension that was set or measured is missing; give it in N")
        if not math.isnan(self.stddev):
            raise DriveError(
                f"a standard deviation of {self.stddev:g} N needs its tension; give both or none"
            )


class Maintained(NamedTuple):
    """Members as they are after maintenance, all settled, and a sentence for the log."""

    components: list[Component]
    message: str


def maintained(
    components: Sequence[Component],
    maintenance: Maintenance,
    prior_mean: _Floats,
    prior_stddev: _Floats,
) -> Maintained:
    """Return what is known after `maintenance`.

    Parameters
    ----------
    components : sequence of Component
        Members of the filter over `state.Index`.
    maintenance : Maintenance
    prior_mean, prior_stddev : ndarray
        Of the state (12,), from `process.prior_state`.

    Notes
    -----
    Re-tensioned: tension is anew and has nothing to do with what was known before. All else stays;
    that kf and mu are known jointly with the old tension is of no more use.

    Belt replaced: tension, kf, mu and the model's error are anew. The ratio bias is in part that of
    the pulleys, which stay, in part that of the belt, whose neutral line lies half its thickness
    above them: its distance from the prior is halved in variance, the other half made anew.

    Tension measured: an observation of ln tension, and of all that goes with it; members are
    weighed by how well they foretold it. If they would have it as far off or farther in less than
    one case in a thousand, it is not explained by the belief. Then tension is known from the
    measurement alone, and all else follows two hypotheses of equal weight: the tension was changed
    without notice and the rest is right, or the belief was wrong and kf and mu are at their priors.
    """
    act = {
        MaintenanceKind.RETENSIONED: _retension,
        MaintenanceKind.BELT_REPLACED: _replace_belt,
        MaintenanceKind.TENSION_MEASURED: _take_in_tension,
    }[maintenance.kind]
    after, message = act(components, maintenance, prior_mean, prior_stddev)
    return Maintained(condensed(after, _BEND), message)


def _retension(
    components: Sequence[Component], maintenance: Maintenance, mean: _Floats, stddev: _Floats
) -> Maintained:
    tension = _log_tension(maintenance, mean, stddev)
    return Maintained(
        [_with_tension(component, tension) for component in components],
        f"re-tensioned from {_text(_tension_of(components))} to {_text(tension)}; "
        "friction and its stiffness are kept",
    )


def _replace_belt(
    components: Sequence[Component], maintenance: Maintenance, mean: _Floats, stddev: _Floats
) -> Maintained:
    tension = _log_tension(maintenance, mean, stddev)
    return Maintained(
        [
            _with_half_bias(
                _with_tension(_with_new_surface(c, mean, stddev), tension), mean, stddev
            )
            for c in components
        ],
        f"belt replaced; tension is {_text(tension)}, friction and its stiffness are at the priors",
    )


def _take_in_tension(
    components: Sequence[Component], maintenance: Maintenance, mean: _Floats, stddev: _Floats
) -> Maintained:
    measured = _log_tension(maintenance, mean, stddev)
    before = _text(_tension_of(components))
    if _chance_of_as_far(components, measured) >= _UNBELIEVABLE:
        after = [_with_observed(component, measured) for component in components]
        return Maintained(
            after,
            f"tension measured as {_text(measured)}, estimated as {before}; "
            f"now {_text(_tension_of(after))}",
        )
    changed = [_with_tension(component, measured) for component in components]
    mistaken = [_with_new_surface(component, mean, stddev) for component in changed]
    return Maintained(
        changed + mistaken,
        f"tension measured as {_text(measured)}, which an estimate of {before} does not explain; "
        "the measurement is taken for the tension, friction and its stiffness are put in doubt",
    )


def _log_tension(maintenance: Maintenance, mean: _Floats, stddev: _Floats) -> Quantity:
    """Mean and deviation of ln tension that was set or measured; the prior's where unknown."""
    place = Index.LOG_TENSION
    if math.isnan(maintenance.tension):
        return Quantity(float(mean[place]), float(stddev[place]))
    if math.isnan(maintenance.stddev):
        spread = float(stddev[place])
        return Quantity(math.log(maintenance.tension) - 0.5 * spread**2, spread)
    return Quantity(*lognormal(maintenance.tension, maintenance.stddev))


def _with_tension(component: Component, tension: Quantity) -> Component:
    value, variance = np.array([tension.value]), np.array([tension.stddev**2])
    return renewed(component, [Index.LOG_TENSION], value, variance)


def _with_new_surface(component: Component, mean: _Floats, stddev: _Floats) -> Component:
    at = list(_SURFACE)
    return renewed(component, at, mean[at], stddev[at] ** 2)


def _with_half_bias(component: Component, mean: _Floats, stddev: _Floats) -> Component:
    at = Index.RATIO_BIAS
    kept = np.ones(len(component.mean))
    kept[at] = math.sqrt(_OF_THE_PULLEYS)
    covariance = np.outer(kept, kept) * component.covariance
    covariance[at, at] += (1.0 - _OF_THE_PULLEYS) * stddev[at] ** 2
    return Component(component.log_weight, mean + kept * (component.mean - mean), covariance)


def _with_observed(component: Component, measured: Quantity) -> Component:
    """Return a member with the measurement of ln tension taken in, and its weight by likelihood."""
    place = Index.LOG_TENSION
    total = float(component.covariance[place, place]) + measured.stddev**2
    squared = (measured.value - float(component.mean[place])) ** 2 / total
    mean, covariance = take_in(
        component.mean,
        component.covariance,
        np.array([measured.value]),
        np.array([measured.stddev**2]),
        np.array([place], dtype=np.int64),
    )
    log_weight = component.log_weight - 0.5 * (squared + math.log(total))
    return Component(log_weight, mean, covariance)


def _chance_of_as_far(components: Sequence[Component], measured: Quantity) -> float:
    """Probability that the belief gives to measurements as far from its members, or farther."""
    weights = normalised(np.array([component.log_weight for component in components]))
    place = Index.LOG_TENSION
    chance = 0.0
    for weight, component in zip(weights.tolist(), components, strict=True):
        spread = math.sqrt(component.covariance[place, place] + measured.stddev**2)
        off = abs(measured.value - component.mean[place]) / spread
        chance += weight * math.erfc(off / math.sqrt(2.0))
    return chance


def _tension_of(components: Sequence[Component]) -> Quantity:
    """Mean and deviation of ln tension."""
    place = [Index.LOG_TENSION]
    mean, covariance = mixture_moments(
        normalised(np.array([component.log_weight for component in components])),
        np.stack([component.mean[place] for component in components]),
        np.stack([component.covariance[np.ix_(place, place)] for component in components]),
    )
    return Quantity(float(mean[0]), math.sqrt(float(covariance[0, 0])))


def _text(log_tension: Quantity) -> str:
    variance = log_tension.stddev**2
    mean = math.exp(log_tension.value + 0.5 * variance)
    return f"{mean:.4g} +/- {mean * math.sqrt(math.expm1(variance)):.4g} N"
