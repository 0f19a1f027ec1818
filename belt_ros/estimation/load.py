"""How fast the load wanders, as the sensors tell.

A load mostly stays as it is and now and then changes, at once or by a ramp. Taken to wander faster
than it does, the estimated pull would follow the noise of the torque sensors; that slip does not
follow it would then speak for a belt farther from its knee than it is. Taken to wander slower, a
change would be blamed on the belt. So each signal that a load moves, both torques and the slip, is
followed by scalar Kalman filters that take it for random walks of several paces, weighed by how
well each foretells the sensor, quiet ones being likelier to begin with; a jump that none of them
foretells starts them anew.

A torque that moves is the load. Slip also moves by itself: while creep develops, and near the knee,
where a little of the load makes much of it. It speaks for the load once a torque has been lively,
or once slip is not what was foretold, and until it rests.

Signals need not come at once, nor equally often. While one is missing, what is known of it stays,
and time passes for it; only after a while it is forgotten.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.written import write
from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_Pair = tuple[float, float]  # of driver and driven pulley
# Of each signal (3,) by each pace: means, variances, weights; the time since its last reading; and
# onsets (2, 3): for how long before that reading it may have been moving, and the pace that told.
Tracks = tuple[_Floats, _Floats, _Floats, _Floats, _Floats]
_PACES = np.array([1.0, 0.3, 0.1, 0.01, 0.001])  # of the greatest wander
_PRIOR = np.array([0.02, 0.02, 0.08, 0.28, 0.6])
_ENDING = np.array([2.0, 2.0, 1.0, 0.2, 0.1])  # of each pace [1/s]
_WITHOUT_SPEED = 0.1  # pace
_TELLING = 0.03  # pace above which slip moves ...
_LIVELY = 0.3  # ... and that of a torque above which the load is what moves it
_GREATEST_JUMP = 30.0  # greatest wander of a second, beyond which no load jumps
_JUMP = 25.0  # squared innovation, normalised, at which the load must have jumped
_UNSEEN = 64.0  # variances of a reading, that a walk may lead to before it shows
_FORGOTTEN = 0.5  # [s] without a reading
_UNHEARD = 0.06  # [s] without a slip, after which the load may have begun to move unseen


class Activity(NamedTuple):
    """Wander of the torque on the driver and on the driven pulley, relative to the greatest.

    Above one in a jump.
    """

    taken: _Pair  # by all that tells ...
    shown: _Pair  # ... and by the torque's own sensor, or the other's where it has none
    unseen: _Pair = (math.inf, math.inf)  # how long before this step it may have begun so [s]

    @property
    def most(self) -> float:
        """That of the livelier torque."""
        return max(self.taken)

    def at_least(self, other: "Activity") -> "Activity":
        """Return it raised to another, though not to a jump."""
        return Activity(
            _raised(self.taken, other.taken), _raised(self.shown, other.shown), self.unseen
        )

    def jumping(self) -> "Activity":
        """Return that of a load which has jumped, whatever its sensors show."""
        return self._replace(taken=_raised(self.taken, (1.0, 1.0)))


def _raised(own: _Pair, other: _Pair) -> _Pair:
    return max(own[0], min(other[0], 1.0)), max(own[1], min(other[1], 1.0))


@compiled
def _began(mean: _Floats, variance: _Floats, weight: _Floats, z: float, r: float) -> None:
    mean[:] = z
    variance[:] = r
    write(weight, _PRIOR)


@compiled
def _mix(mean: _Floats, variance: _Floats, weight: _Floats, dt: float) -> None:
    """Let every pace end after a while, and any other follow it, from where it has led to."""
    leaving, total, left, left_variance = np.empty(_PACES.size), 0.0, 0.0, 0.0
    for j in range(_PACES.size):
        leaving[j] = -math.expm1(-_ENDING[j] * dt) * weight[j]
        total += leaving[j]
        left += leaving[j] * mean[j]
    left /= total
    for j in range(_PACES.size):
        left_variance += leaving[j] * (variance[j] + (mean[j] - left) ** 2)
    left_variance /= total
    for j in range(_PACES.size):
        staying, coming = weight[j] - leaving[j], total * _PRIOR[j]
        weight[j] = staying + coming
        share = coming / weight[j]
        apart = left - mean[j]
        mean[j] += share * apart
        variance[j] += share * (left_variance - variance[j]) + share * (1.0 - share) * apart**2


@compiled
def _pace(weight: _Floats) -> float:
    log_pace = 0.0
    for j in range(_PACES.size):
        log_pace += weight[j] * math.log(_PACES[j])
    return math.exp(log_pace)


@compiled
def _followed(
    mean: _Floats,
    variance: _Floats,
    weight: _Floats,
    z: float,
    r: float,
    fastest: float,
    anyway: float,
    since: float,
    dt: float,
) -> float:
    """Take in one reading, `since` after the one before.

    Return the pace that it speaks for, or that at which `dt` would make the jump that it is.
    """
    least = math.inf
    for j in range(_PACES.size):
        variance[j] += ((_PACES[j] * fastest) ** 2 + anyway**2) * since
        least = min(least, (z - mean[j]) ** 2 / (variance[j] + r))
    if least > _JUMP:
        jump: float = abs(z - mean[0]) / (fastest * math.sqrt(dt))
        _began(mean, variance, weight, z, r)
        return max(min(jump, _GREATEST_JUMP / math.sqrt(dt)), 1.0)
    for j in range(_PACES.size):
        spread = variance[j] + r
        squared = (z - mean[j]) ** 2 / spread
        weight[j] *= math.exp(0.5 * (least - squared)) / math.sqrt(spread)
        gain = variance[j] / spread
        mean[j] += gain * (z - mean[j])
        variance[j] *= 1.0 - gain
    total = 0.0
    for j in range(_PACES.size):
        total += weight[j]
    for j in range(_PACES.size):
        weight[j] /= total
    pace: float = _pace(weight)
    _mix(mean, variance, weight, since)
    return pace


@compiled
def _set_in(onset: _Floats, pace: float, to_show: float, since: float) -> None:
    """Date the onset of a movement of this pace, which takes time `to_show`, by a reading.

    It may have begun at any time since the reading before. That it is calmer now says nothing of
    the time before it was liveliest.
    """
    hidden, held = to_show + since, onset[0] + since
    if pace >= onset[1] or hidden < held:
        onset[0], onset[1] = hidden, pace
    else:
        onset[0] = held


@compiled
def follow_paces(
    tracks: Tracks,
    signals: _Floats,
    noise: _Floats,
    fastest: _Floats,
    anyway: _Floats,
    slip_tells: bool,  # noqa: FBT001 - compiled functions take no keywords
    dt: float,
) -> tuple[_Pair, _Pair, _Pair, bool]:
    """Follow paces, see `LoadWander.follow`; `tracks` are changed.

    Returns
    -------
    tuple
        `Activity.taken`, `Activity.shown`, `Activity.unseen`, and whether slip tells from here on.
    """
    mean, variance, weight, since, onset = tracks
    pace, unseen = np.empty(signals.size), np.full(signals.size, math.inf)
    for i in range(signals.size):
        z = signals[i]
        since[i] += dt
        if math.isnan(z):
            if since[i] > _FORGOTTEN:
                mean[i] = math.nan
            pace[i] = math.nan if math.isnan(mean[i, 0]) else _pace(weight[i])
        elif math.isnan(mean[i, 0]):
            _began(mean[i], variance[i], weight[i], z, noise[i])
            pace[i] = 1.0
            onset[0, i], onset[1, i] = math.inf, pace[i]
            since[i] = 0.0
        else:
            pace[i] = _followed(
                mean[i],
                variance[i],
                weight[i],
                z,
                noise[i],
                fastest[i],
                anyway[i],
                since[i],
                dt,
            )
            to_show = _UNSEEN * noise[i] / (pace[i] * fastest[i]) ** 2
            _set_in(onset[:, i], pace[i], to_show, since[i])
            since[i] = 0.0
        unseen[i] = onset[0, i] + since[i] - dt
    for i, other in ((0, 1), (1, 0)):
        if math.isnan(pace[i]):
            pace[i], unseen[i] = pace[other], unseen[other]
    if math.isnan(pace[0]):
        return (1.0, 1.0), (1.0, 1.0), (math.inf, math.inf), slip_tells
    shown = pace[0], pace[1]
    slip = 0.0 if math.isnan(pace[2]) else min(pace[2], 1.0)
    slip_tells = (slip_tells or max(shown[0], shown[1]) > _LIVELY) and slip > _TELLING
    moved = slip if slip_tells else 0.0
    # Without a speed, nothing would tell that it moves but the torques themselves.
    if math.isnan(pace[2]) or since[2] > _UNHEARD:
        moved = max(moved, _WITHOUT_SPEED)
    taken = max(shown[0], moved), max(shown[1], moved)
    return taken, shown, (unseen[0], unseen[1]), slip_tells


class LoadWander:
    """Follow how fast the load wanders, by both torques and the difference of rim speeds.

    Attributes
    ----------
    tracks : Tracks
        What each pace knows of each signal.
    slip_tells : bool
        Whether the load is known to move, so that slip speaks for it.
    """

    def __init__(self) -> None:
        means = np.full((3, _PACES.size), math.nan)
        variances, weights, since = np.zeros_like(means), np.zeros_like(means), np.zeros(3)
        self.tracks: Tracks = means, variances, weights, since, np.zeros((2, 3))
        self.slip_tells = False

    def start(self) -> None:
        """Forget all signals, as before the first reading."""
        means, _, _, since, onset = self.tracks
        means[:] = math.nan
        since[:] = 0.0
        onset[0] = math.inf
        self.slip_tells = False

    def follow(
        self,
        signals: _Floats,
        noise: _Floats,
        fastest: _Floats,
        anyway: _Floats,
        dt: float,
        *,
        unforeseen: bool,
    ) -> Activity:
        """Take in the readings at the end of a step of `dt` [s].

        Parameters
        ----------
        signals : ndarray
            Torque on the driver and on the driven pulley [N m], difference of the rim speeds [m/s];
            NaN where there is no reading.
        noise : ndarray
            Their variances.
        fastest : ndarray
            Greatest wander of each by the load [N m/sqrt(s), N m/sqrt(s), m/s/sqrt(s)].
        anyway : ndarray
            Wander of each that is not the load's.
        dt : float
        unforeseen : bool
            Whether slip is other than was foretold, by all that is known of belt and load.

        Returns
        -------
        Activity
            During the step. A torque that has had no reading for half a second is taken to wander
            like the other; neither, at the greatest.
        """
        taken, shown, unseen, self.slip_tells = follow_paces(
            self.tracks, signals, noise, fastest, anyway, self.slip_tells or unforeseen, dt
        )
        return Activity(taken, shown, unseen)
