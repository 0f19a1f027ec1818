"""What was learned of a belt, kept from one run to the next, and how it ages in between.

Kept is the belief about what the belt is: tension, kf, mu and the ratio bias, with all that they
have to do with each other. What moves is gone when the drive stops, and the model's error in creep
is another one after its correlation time.

In between, two things happen to it, both as laws over time that compose: ageing by a and then by b
is ageing by a + b.

* It wanders about its prior, by the law of `process.drift_processes`.
* The tension may have been changed. Then nothing is left of it but its prior, while kf, mu and the
  ratio bias are as they were. The share exp(-changes t) of each member stays; the rest has its
  tension at the prior. So a belt that was re-tensioned, or that has slackened, without anyone
  saying so, finds a hypothesis waiting, and the longer the pause, the heavier.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.assumptions import Drift
from belt_ros.estimation.condensing import MEMBERS, condensed, renewed
from belt_ros.estimation.fingerprint import Fingerprint, fingerprint
from belt_ros.estimation.gaussian_sum import Component, normalised
from belt_ros.estimation.installed import Installed
from belt_ros.estimation.process import STANDING
from belt_ros.estimation.state import Index
from belt_ros.mechanics.drive import BeltDrive

_Floats = NDArray[np.float64]
REMEMBERED = (Index.LOG_TENSION, Index.LOG_STIFFNESS, Index.LOG_FRICTION, Index.RATIO_BIAS)
_TENSION = REMEMBERED.index(Index.LOG_TENSION)
_BEND = (_TENSION, REMEMBERED.index(Index.LOG_STIFFNESS))  # where members must stay apart
_YEAR = 365.25 * 86400.0  # [s]
_RATIO_BIAS_TIME = _YEAR  # in which a ratio bias is forgotten
_OLD = 10.0 * _YEAR
_LONGEST_NAME = 200
_FARTHEST = 100.0  # mean, and
_LEAST_VARIANCE, _GREATEST_VARIANCE = 1e-30, 1e4  # variance that a member can sensibly have
_ROUNDING = 1e-9


class MemoryRefusedError(ValueError):
    """What was learned that cannot be used; the message, one line, says why."""


@dataclass(frozen=True, eq=False)
class Learned:
    """What was learned of one belt.

    Parameters
    ----------
    name : str
        Of the drive.
    date : float
        When it was known [s], since the Unix epoch.
    drive : Fingerprint
        What it holds for.
    weights : ndarray
        Of the members of a Gaussian sum (k,), k up to `MEMBERS`.
    means, covariances : ndarray
        Of (ln tension, ln kf, ln mu, ratio bias), (k, 4) and (k, 4, 4).
    installed : Installed or None
        With which traction is compared; None: with what is told.

    Raises
    ------
    MemoryRefusedError
        If this is no belief that an estimator can have.
    """

    name: str
    date: float
    drive: Fingerprint
    weights: _Floats
    means: _Floats
    covariances: _Floats
    installed: Installed | None = None

    def __post_init__(self) -> None:
        if not (0 < len(self.name) <= _LONGEST_NAME and self.name.isprintable()):
            raise MemoryRefusedError(
                f"a drive's name is 1 to {_LONGEST_NAME} printable characters, not {self.name!a}"
            )
        if not math.isfinite(self.date):
            raise MemoryRefusedError(f"the date is {self.date}; it must be finite")
        if self.installed is not None and not self.installed.possible:
            raise MemoryRefusedError(f"no belt can be installed as {tuple(self.installed)}")
        _check_members(self.weights, self.means, self.covariances)
        for field in ("weights", "means", "covariances"):
            array = getattr(self, field).copy()
            array.setflags(write=False)
            object.__setattr__(self, field, array)

    @property
    def components(self) -> list[Component]:
        """The members, over `REMEMBERED`."""
        return [
            Component(math.log(weight), mean, covariance)
            for weight, mean, covariance in zip(
                self.weights.tolist(), self.means, self.covariances, strict=True
            )
        ]


def _check_members(weights: _Floats, means: _Floats, covariances: _Floats) -> None:
    """Raise `MemoryRefusedError` unless these make a Gaussian sum."""
    k, n = len(weights), len(REMEMBERED)
    if not 1 <= k <= MEMBERS:
        raise MemoryRefusedError(f"there are {k} members; there must be 1 to {MEMBERS}")
    if weights.shape != (k,) or means.shape != (k, n) or covariances.shape != (k, n, n):
        raise MemoryRefusedError(f"weights, means and covariances must be of {k} members")
    if not (np.all(weights > 0.0) and abs(np.sum(weights) - 1.0) <= _ROUNDING):
        raise MemoryRefusedError("the weights must be positive and sum to one")
    if not np.all(np.abs(means) <= _FARTHEST):
        raise MemoryRefusedError(f"the means must lie within {_FARTHEST:g} of nought")
    variances = np.diagonal(covariances, axis1=1, axis2=2)
    if not np.all((variances >= _LEAST_VARIANCE) & (variances <= _GREATEST_VARIANCE)):
        raise MemoryRefusedError(
            f"the variances must lie between {_LEAST_VARIANCE:g} and {_GREATEST_VARIANCE:g}"
        )
    if not np.array_equal(covariances, covariances.transpose(0, 2, 1)):
        raise MemoryRefusedError("the covariances must be symmetric")
    deviations = np.sqrt(variances)
    correlations = covariances / (deviations[:, :, None] * deviations[:, None, :])
    possible = bool(np.all(np.abs(correlations) <= 1.0 + _ROUNDING))
    if not (possible and np.min(np.linalg.eigvalsh(correlations)) >= -_ROUNDING):
        raise MemoryRefusedError("the covariances must be positive semi-definite")


def learned_from(
    components: Sequence[Component],
    name: str,
    drive: BeltDrive,
    date: float,
    installed: Installed | None = None,
) -> Learned:
    """Return what a filter's members, over `state.Index`, say of the belt.

    Parameters
    ----------
    components : sequence of Component
    name : str
        Of the drive.
    drive : BeltDrive
    date : float
        Of the last measurement taken in [s], since the Unix epoch.
    installed : Installed, optional
        With which traction is compared.

    Raises
    ------
    MemoryRefusedError
        If that is nothing worth remembering, such as numbers that are not finite.
    """
    places = np.ix_(REMEMBERED, REMEMBERED)
    sane = [
        Component(c.log_weight, c.mean[list(REMEMBERED)], _proper(c.covariance[places]))
        for c in components
        if _is_sane(c)
    ]
    if not sane:
        raise MemoryRefusedError("no member of the filter is within reason")
    members = condensed(sane, _BEND)
    return Learned(
        name,
        date,
        fingerprint(drive),
        normalised(np.array([member.log_weight for member in members])),
        np.stack([member.mean for member in members]),
        np.stack([member.covariance for member in members]),
        installed,
    )


def _is_sane(component: Component) -> bool:
    """Whether what a member says of the belt is within what a memory may hold."""
    at = list(REMEMBERED)
    variances = np.diagonal(component.covariance)[at]
    near = np.all(np.abs(component.mean[at]) <= _FARTHEST)
    return bool(near and np.all(variances <= _GREATEST_VARIANCE)) and math.isfinite(
        component.log_weight
    )


def _proper(covariance: _Floats) -> _Floats:
    """Return a covariance with what rounding has taken from it, where quantities are as certain."""
    variances = np.maximum(np.diagonal(covariance), 2.0 * _LEAST_VARIANCE)
    deviations = np.sqrt(variances)
    scale = np.outer(deviations, deviations)
    values, vectors = np.linalg.eigh(0.5 * (covariance + covariance.T) / scale)
    if values[0] >= 0.0 and np.array_equal(variances, np.diagonal(covariance)):
        return covariance
    correlations = (vectors * np.maximum(values, _ROUNDING)) @ vectors.T
    widths = np.sqrt(np.diagonal(correlations))
    correlations /= np.outer(widths, widths)
    np.fill_diagonal(correlations, 1.0)
    return np.asarray(correlations * scale)


class Forgetting(NamedTuple):
    """How what was learned ages: prior mean and deviation (4,), and rates [1/s]."""

    mean: _Floats
    stddev: _Floats
    rates: _Floats  # at which the distance from the prior fades (4,)
    changes: float  # of tension, to its prior


def forgetting(
    prior_mean: _Floats, prior_stddev: _Floats, drift: Drift, pace: float = STANDING
) -> Forgetting:
    """Return how a belt of a given prior ages.

    Parameters
    ----------
    prior_mean, prior_stddev : ndarray
        Of the state, from `process.prior_state`.
    drift : Drift
        That of the running drive, by which 1 s counts as 1 s at pace 1.
    pace : float
        Ageing relative to that. `Drift` says how fast a drive that is watched may go off, by
        default with tension changing every quarter of an hour, so that a fault is found soon. At
        that pace no tension outlasts an hour's rest; but a drive that stands is not worn, heated
        or shaken.

    Notes
    -----
    The ratio bias, a constant while running, fades over a year whatever the pace: radii wear, and
    with a memory no run is ever the first, so that what never faded could never be learned anew.
    """
    mean, stddev = prior_mean[list(REMEMBERED)], prior_stddev[list(REMEMBERED)]
    wander = np.array([drift.tension, drift.friction_stiffness, drift.friction_coefficient, 0.0])
    rates = 0.5 * pace * (wander / stddev) ** 2
    rates[REMEMBERED.index(Index.RATIO_BIAS)] = 1.0 / _RATIO_BIAS_TIME
    return Forgetting(mean, stddev, rates, pace * drift.tension_changes)


def aged(components: Sequence[Component], law: Forgetting, elapsed: float) -> list[Component]:
    """Return what members over `REMEMBERED` have become after `elapsed` >= 0 [s], or for ever.

    For each there are two: the one in which the tension has not been changed, and the one in which
    it has.
    """
    with np.errstate(over="ignore"):  # infinite is what it is
        forgotten = law.rates * elapsed
    memory = np.exp(-forgotten)
    gained = np.diag(law.stddev**2 * -np.expm1(-2.0 * forgotten))
    stayed = -law.changes * elapsed
    changed = -math.expm1(stayed)
    log_changed = math.log(changed) if changed > 0.0 else -math.inf
    tension = [_TENSION]
    out = []
    for component in components:
        mean = law.mean + memory * (component.mean - law.mean)
        covariance = np.outer(memory, memory) * component.covariance + gained
        out.append(Component(component.log_weight + stayed, mean, covariance))
        other = Component(component.log_weight + log_changed, mean, covariance)
        out.append(renewed(other, tension, law.mean[tension], law.stddev[tension] ** 2))
    return out


class Restored(NamedTuple):
    """Members to start a filter from, and a note for the log, empty where there is none."""

    components: list[Component]
    note: str


def restore(
    learned: Learned,
    drive: BeltDrive,
    prior_mean: _Floats,
    prior_stddev: _Floats,
    drift: Drift,
    elapsed: float,
    pace: float = STANDING,
) -> Restored:
    """Return what is left of `learned` after `elapsed` [s], all other states at their prior.

    Parameters
    ----------
    learned : Learned
    drive : BeltDrive
        The present drive, which must be the one that was learned.
    prior_mean, prior_stddev : ndarray
        Of the present state (12,), from `process.prior_state`.
    drift : Drift
    elapsed : float
        Since `learned.date` [s]. Where it is negative or NaN the clock was set back, as it is on
        computers without a battery; then no time has passed, and the note says so.
    pace : float
        See `forgetting`; 1 where the drive ran on unwatched.

    Raises
    ------
    MemoryRefusedError
        If `drive` has another belt, other pulleys or another tensioning.
    """
    differences = learned.drive.differences(fingerprint(drive))
    if differences:
        raise MemoryRefusedError(
            f"what was learned of {learned.name!r} is of another drive: {'; '.join(differences)}"
        )
    note = ""
    if not elapsed >= 0.0:
        note = f"the memory's age is {elapsed:.3g} s: the clock was set back; taken as fresh"
        elapsed = 0.0
    elif elapsed > _OLD:
        note = f"the memory is {elapsed / _YEAR:.0f} years old: was the clock set when it was kept?"
    law = forgetting(prior_mean, prior_stddev, drift, pace)
    places = np.ix_(REMEMBERED, REMEMBERED)
    components = []
    for member in condensed(aged(learned.components, law, elapsed), _BEND):
        mean, covariance = prior_mean.copy(), np.diag(prior_stddev**2)
        mean[list(REMEMBERED)] = member.mean
        covariance[places] = member.covariance
        components.append(Component(member.log_weight, mean, covariance))
    return Restored(components, note)
