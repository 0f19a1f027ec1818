"""Whether traction has been lost, and whether tension or friction is to blame.

Traction is the pull that the drive can carry, at rest: held tension times what friction makes of
it, ln capacity = ln T + gain(ln mu). It is lost when it has fallen below a stated share of what it
was at a reference: the belt as installed, as told or set at maintenance.

Slip and torque show the product. What it is made of they hardly show, and the estimate of mu then
is its prior, that of a sound surface. Just when traction is lost this cannot be relied on: oil on a
pulley is outside any such prior, and a filter that holds on to it blames the tension for
everything. So the question of blame is asked with a prior of mu as wide as a spoilt surface may be.
The loss itself is judged from the posterior as it is.

A cause counts if, with the other one left as at the reference, it alone would amount to the loss.
A name is given only where, of what the posterior allows once traction is lost, most has that cause
and no other; else it is traction that is lost, and not said which.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.estimate import LostTraction
from belt_ros.estimation.state import Index
from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import HELD_SLACK, DriveConstants, traction_limit

_Floats = NDArray[np.float64]
_TENSION = int(Index.LOG_TENSION)
_FRICTION = int(Index.LOG_FRICTION)
SHARE = 0.8  # of the reference's traction below which it is lost
SPOILT = 1.0  # standard deviation of ln mu of a surface that may be spoilt
_NEGLIGIBLE = 1e-3  # weight of a member, or probability of a loss, that need not be looked into
_REACH, _NODES = 3.0, 11  # of the integral over ln mu, in deviations either way
_STRAIGHT = 0.1  # deviation of ln mu within which the gain is straight
_LEARNED = 0.5  # of the prior's standard deviation
_FARTHEST = 6.0  # ln mu either way


class Loss(IntEnum):
    """What has been lost; the numbers are those of the conditions of belt_msgs/SlipAlarm."""

    NONE = 0
    TRACTION = 4
    TENSION = 5
    FRICTION = 6


class Reference(NamedTuple):
    """What the belt is compared with, and where loss begins."""

    grip: float  # traction limit ln(w_H/w_L) per mu of the driven pulley [-]
    slack_held: int  # 1: the slack tension is held, 0: the mean
    log_friction: float  # of a sound surface ...
    log_friction_stddev: float  # ... as the filter's prior has it
    lost_log_traction: float  # below which traction is lost [ln N]
    lost_log_tension: float  # below which tension alone would do [ln N]
    lost_log_friction: float  # below which friction alone would do
    tension_measured: int  # 1: by a hub load or span tension sensor


@compiled
def _log_gain(grip: float, slack_held: int, log_friction: float) -> tuple[float, float]:
    """Logarithm of the capacity per held tension, and its slope in ln mu.

    With a held mean, of half of it.
    """
    limit = grip * math.exp(min(max(log_friction, -_FARTHEST), _FARTHEST))
    share = -math.expm1(-limit)
    if slack_held:
        return limit + math.log(share), limit / share
    both = 2.0 - share  # of tanh(limit / 2) = share / both
    return math.log(share / both), 2.0 * limit * (1.0 - share) / (share * both)


def _log_friction_at(grip: float, log_gain: float, slack_held: int) -> float:
    """Inverse of `_log_gain`."""
    if slack_held:
        # ln(1 + e^g), without overflow
        limit = max(log_gain, 0.0) + math.log1p(math.exp(-abs(log_gain)))
    else:
        limit = 2.0 * math.atanh(math.exp(log_gain))
    return math.log(limit / grip)


def traction_reference(
    constants: DriveConstants,
    log_tension: float,
    log_friction: float,
    log_friction_stddev: float,
    share: float = SHARE,
    *,
    tension_measured: bool = False,
) -> Reference:
    """Return what the belt is compared with.

    Parameters
    ----------
    constants : DriveConstants
        Wraps and tensioning. Held hub load and fixed centres count as a held mean: between fixed
        centres the capacity is somewhat larger, but by nearly the same share.
    log_tension, log_friction : float
        ln of the held tension [N] and of the driven pulley's mu, at the reference.
    log_friction_stddev : float
        Standard deviation of ln mu in the filter's prior.
    share : float
        Of the reference's traction, below which it counts as lost; in (0, 1).
    tension_measured : bool
        Whether a sensor tells tension apart from friction: hub load or span tension.
    """
    slack_held = int(constants.tensioning == HELD_SLACK)
    grip = traction_limit(constants, 1.0)
    gain, _ = _log_gain(grip, slack_held, log_friction)
    lost = math.log(share)
    return Reference(
        grip,
        slack_held,
        log_friction,
        log_friction_stddev,
        log_tension + gain + lost,
        log_tension + lost,
        _log_friction_at(grip, gain + lost, slack_held),
        int(tension_measured),
    )


@compiled
def _normal_below(limit: float) -> float:
    return 0.5 * math.erfc(-limit * math.sqrt(0.5))


class _Belief(NamedTuple):
    """ln T and ln mu of one member: ln mu is normal, ln T is normal about a curve in it."""

    friction: float  # mean of ln mu
    spread: float  # its deviation
    slope: float  # of ln T in ln mu, at the filter's mean ...
    at_friction: float
    at_tension: float
    share: float  # ... and how much of it is that the capacity is known
    rest: float  # deviation of ln T beside


@compiled
def _belief(mean: _Floats, covariance: _Floats, at: Reference) -> _Belief:
    variance = max(covariance[_FRICTION, _FRICTION], 1e-30)
    slope = covariance[_TENSION, _FRICTION] / variance
    rest = covariance[_TENSION, _TENSION] - slope * covariance[_TENSION, _FRICTION]
    gaining = _log_gain(at.grip, at.slack_held, mean[_FRICTION])[1]
    share = min(max(-slope / gaining, 0.0), 1.0) if gaining > 0.0 else 0.0
    return _Belief(
        mean[_FRICTION],
        math.sqrt(variance),
        slope,
        mean[_FRICTION],
        mean[_TENSION],
        share,
        math.sqrt(max(rest, 1e-30)),
    )


@compiled
def _in_doubt(belief: _Belief, at: Reference, spoilt: float) -> _Belief:
    """Return the belief with the prior of ln mu, which it contains, made wider.

    What the data have said of ln mu stays where tension is measured as well, or ln mu clearly
    learned. Else a slight narrowing comes from what the filter assumes of tension, and does not
    count. What is known of ln T at each ln mu stays.
    """
    prior, wide = 1.0 / at.log_friction_stddev**2, 1.0 / spoilt**2
    told = at.tension_measured or belief.spread < _LEARNED * at.log_friction_stddev
    from_data = max(1.0 / belief.spread**2 - prior, 0.0) if told else 0.0
    total = from_data + wide
    most = from_data * _FARTHEST  # information on the mean adds up as well
    off = (belief.friction - at.log_friction) / belief.spread**2
    friction = at.log_friction + min(max(off, -most), most) / total
    return _Belief(
        friction,
        1.0 / math.sqrt(total),
        belief.slope,
        belief.at_friction,
        belief.at_tension,
        belief.share,
        belief.rest,
    )


@compiled
def _chance_of_loss(belief: _Belief, at: Reference) -> float:
    """Probability of a loss."""
    if belief.spread > _STRAIGHT:
        return _chances(belief, at)[0]
    gain, slope = _log_gain(at.grip, at.slack_held, belief.friction)
    spread = math.sqrt(belief.rest**2 + ((belief.slope + slope) * belief.spread) ** 2)
    return _normal_below((at.lost_log_traction - gain - belief.at_tension) / spread)


@compiled
def _chances(belief: _Belief, at: Reference) -> tuple[float, float, float]:
    """Probabilities of a loss; of one that tension, and one that friction alone amounts to.

    Integrated over ln mu, however wide. Each node stands for a cell, and what varies within the
    cell widens what is normal beside.

    Of ln T at a value of ln mu a filter knows a line. Where that is there because the capacity is
    known, it is followed beyond the filter's reach: what mu does not give, tension does.
    """
    step = 2.0 * _REACH / (_NODES - 1)
    cell = step * belief.spread
    within, rest = cell * cell / 12.0, belief.rest**2
    here, slope_here = _log_gain(at.grip, at.slack_held, belief.at_friction)
    whole = lost = by_tension = by_friction = 0.0
    for i in range(_NODES):
        place = i * step - _REACH
        weight = math.exp(-0.5 * place * place)
        y = belief.friction + place * belief.spread
        far = y - belief.at_friction
        gain, slope = _log_gain(at.grip, at.slack_held, y)
        bend = gain - here - slope_here * far
        tension = belief.at_tension + belief.slope * far - belief.share * bend
        along = belief.slope - belief.share * (slope - slope_here)
        spread = math.sqrt(rest + (slope + along) ** 2 * within)
        chance = _normal_below((at.lost_log_traction - gain - tension) / spread)
        spread = math.sqrt(rest + along**2 * within)
        alone = _normal_below((at.lost_log_tension - tension) / spread)
        below = min(max((at.lost_log_friction - y) / cell + 0.5, 0.0), 1.0)
        whole += weight
        lost += weight * chance
        by_tension += weight * min(chance, alone)
        by_friction += weight * chance * below
    return lost / whole, by_tension / whole, by_friction / whole


@compiled
def _lost(
    weights: _Floats, means: _Floats, covariances: _Floats, at: Reference, spoilt: float
) -> tuple[float, float, float]:
    whole = lost = 0.0
    for k in range(weights.shape[0]):
        if weights[k] >= _NEGLIGIBLE:
            whole += weights[k]
            lost += weights[k] * _chance_of_loss(_belief(means[k], covariances[k], at), at)
    lost = lost / whole if whole > 0.0 else 0.0
    if lost < _NEGLIGIBLE:
        return lost, 0.0, 0.0
    possible = by_tension = by_friction = 0.0
    for k in range(weights.shape[0]):
        if weights[k] >= _NEGLIGIBLE:
            doubted = _in_doubt(_belief(means[k], covariances[k], at), at, spoilt)
            each, tension, friction = _chances(doubted, at)
            possible += weights[k] * each
            by_tension += weights[k] * tension
            by_friction += weights[k] * friction
    if not possible > 0.0:
        return lost, 0.0, 0.0
    return lost, lost * by_tension / possible, lost * by_friction / possible


def lost_traction(
    weights: _Floats,
    means: _Floats,
    covariances: _Floats,
    reference: Reference,
    spoilt: float = SPOILT,
) -> LostTraction:
    """Probabilities that traction has been lost, and that one cause alone amounts to it.

    Parameters
    ----------
    weights : ndarray
        Of the members of a Gaussian sum (k,), summing to one.
    means, covariances : ndarray
        Of the state, (k, n) and (k, n, n), in the order of `state.Index`.
    reference : Reference
    spoilt : float
        Standard deviation of ln mu when the question is what to blame.

    Returns
    -------
    LostTraction
        The causes' probabilities are at most that of the loss, and 0 where it has next to none;
        they are integrated to 0.07, that of the loss to 0.03. Both can be high, where both have
        been lost, and both low, where either has been lost by half or they cannot be told apart.
    """
    return LostTraction(*_lost(weights, means, covariances, reference, spoilt))


def named_loss(lost: LostTraction, confidence: float = 0.8) -> Loss:
    """Say what has been lost, as far as it can be told.

    Parameters
    ----------
    lost : LostTraction
    confidence : float
        Probability from which on traction counts as lost, and probability of a cause, given that
        it is, from which on the cause counts as known. A loss is named after a cause only if the
        other is not as probable as not.
    """
    if not lost.traction >= confidence:
        return Loss.NONE
    by_tension = lost.tension >= confidence * lost.traction
    by_friction = lost.friction >= confidence * lost.traction
    if by_tension and not lost.friction >= 0.5 * lost.traction:
        return Loss.TENSION
    if by_friction and not lost.tension >= 0.5 * lost.traction:
        return Loss.FRICTION
    return Loss.TRACTION
