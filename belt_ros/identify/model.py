"""What a belt and a radius ratio make of the loads, as residuals of standard normal unknowns.

The unknowns are what the belt is (ln T, ln kf, ln mu, ratio bias), the model's relative error of
creep at each load, and the error of each measured slip; the residuals are those of the measured
pulls, and the unknowns themselves, each over its standard deviation. So the least squares are the
most probable values under the priors, with errors in both slip and pull. Pull is taken as a
function of slip, since that is defined and monotone for every slip, gross slip included, where slip
as a function of pull ends at the capacity.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation import Drift, Prior
from belt_ros.estimation.process import prior_state
from belt_ros.estimation.state import Index
from belt_ros.identify.curve import Curve
from belt_ros.mechanics import BeltDrive
from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants, drive_constants
from belt_ros.mechanics.creep import creep, pull_at_creep, pull_capacity

_Floats = NDArray[np.float64]
BELT = (Index.LOG_TENSION, Index.LOG_STIFFNESS, Index.LOG_FRICTION, Index.RATIO_BIAS)
_WIDE = np.array([1.0, 2.0 * math.log(10.0), 0.5, 5e-3])
_STEP = 1e-4  # of finite differences, in standard deviations
_LEAST_ERROR = -0.9
_DRIVING = True  # the driven pulley receives the power
_ROUNDING = 1e-6  # added to correlations of 1


class Assumed(NamedTuple):
    """Prior of ln T, ln kf, ln mu and ratio bias (4,)."""

    mean: _Floats
    stddev: _Floats


def assumed(prior: Prior, drive: BeltDrive, *, wide: bool = False) -> Assumed:
    """Return the prior; `wide`: with next to nothing known."""
    mean, stddev = prior_state(prior, drive)
    spread = stddev[list(BELT)]
    return Assumed(mean[list(BELT)], np.maximum(spread, _WIDE) if wide else spread)


@compiled
def _pulls_at_slips(c: DriveConstants, rows: _Floats) -> _Floats:
    """Rows (slip, creep error, speed, ln T, ln kf, ln mu) to pulls along the rotation [N]."""
    out = np.empty(rows.shape[0])
    for i in range(rows.shape[0]):
        slip, error, speed, tension, stiffness, friction = rows[i]
        forward = slip >= 0.0
        received = (slip if forward else slip / (slip - 1.0)) / (1.0 + error)
        pull = pull_at_creep(
            c,
            0.0,
            received,
            received * c.axial_stiffness,
            math.exp(tension),
            math.exp(friction),
            math.exp(stiffness),
            speed,
            forward,
        )
        out[i] = pull if forward else -pull
    return out


class SlipModel:
    """Residuals of a curve of slip against load, for `scipy.optimize.least_squares`.

    Parameters
    ----------
    curve : Curve
        Of n loads.
    drive : BeltDrive
    prior : Assumed
    creep_error : float
        Standard deviation of the model's relative error of creep [-].
    error_load : float
        Change of pull [N] over which that error becomes another.

    Notes
    -----
    Unlike in the filter the error of creep does not become another with time: what repeats at
    the same load for an hour does not average out.
    """

    def __init__(
        self,
        curve: Curve,
        drive: BeltDrive,
        prior: Assumed,
        creep_error: float,
        error_load: float,
    ) -> None:
        self.curve = curve
        self.prior = prior
        self.loads = len(curve.pull)
        self.constants = drive_constants(drive)
        apart = np.abs(curve.pull[:, None] - curve.pull)
        alike = np.exp(-apart / error_load) + _ROUNDING * np.eye(self.loads)
        self._errors = creep_error * np.linalg.cholesky(alike)

    @property
    def start(self) -> _Floats:
        """The unknowns (4 + 2 n,) at the prior."""
        return np.zeros(len(BELT) + 2 * self.loads)

    def belt(self, unknowns: _Floats) -> _Floats:
        """Return ln T, ln kf, ln mu and ratio bias (4,)."""
        return np.asarray(self.prior.mean + self.prior.stddev * unknowns[: len(BELT)])

    def residuals(self, unknowns: _Floats) -> _Floats:
        """Return residuals (n + 4 + 2 n,): of n pulls, and the unknowns."""
        pulls = _pulls_at_slips(self.constants, self._rows(unknowns))
        return np.concatenate([(pulls - self.curve.pull) / self.curve.pull_stddev, unknowns])

    def jacobian(self, unknowns: _Floats) -> _Floats:
        """Return the derivatives of `residuals` (n + 4 + 2 n, 4 + 2 n)."""
        belts, loads = len(BELT), self.loads
        rows = self._rows(unknowns)
        moved = [rows]
        for at in range(belts):
            stepped = unknowns.copy()
            stepped[at] += _STEP
            moved.append(self._rows(stepped))
        slip_step = 1e-2 * self.curve.slip_stddev
        by_slip, by_error = rows.copy(), rows.copy()
        by_slip[:, 0] += slip_step
        by_error[:, 1] += _STEP
        pulls = _pulls_at_slips(self.constants, np.concatenate([*moved, by_slip, by_error]))
        pulls = pulls.reshape(-1, loads) / self.curve.pull_stddev
        change = pulls[1:] - pulls[0]
        slopes = np.zeros((loads, len(unknowns)))
        slopes[:, :belts] = change[:belts].T / _STEP
        slopes[:, belts : belts + loads] = (change[-1] / _STEP)[:, None] * self._errors
        by_noise = change[-2] / slip_step * self.curve.slip_stddev
        slopes[:, belts + loads :] = np.diag(by_noise)
        return np.concatenate([slopes, np.eye(len(unknowns))])

    def noise_slopes(self, unknowns: _Floats) -> _Floats:
        """Return what a deviation of each slip changes its residual by (n,)."""
        at = len(BELT) + self.loads
        return np.diagonal(self.jacobian(unknowns)[: self.loads, at:]).copy()

    def capacity(self, belt: _Floats) -> float:
        """Pull [N] at gross slip, where the driver drives, at the speed of the greatest load."""
        speed = float(self.curve.speed[np.argmax(np.abs(self.curve.pull))])
        tension, stiffness, friction = np.exp(belt[:3])
        return pull_capacity(self.constants, tension, friction, stiffness, speed, _DRIVING)

    def slip_slopes(self, belt: _Floats, pull: float) -> tuple[float, _Floats]:
        """Return slip at a pull [N] below capacity, and how a deviation of each prior shifts it."""
        here = self._slip(belt, pull)
        moved = belt + _STEP * np.diag(self.prior.stddev)
        return here, np.array([(self._slip(row, pull) - here) / _STEP for row in moved])

    def _slip(self, belt: _Floats, pull: float) -> float:
        tension, stiffness, friction = np.exp(belt[:3])
        speed = float(np.mean(self.curve.speed))
        steady = creep(self.constants, pull, tension, friction, stiffness, speed, _DRIVING).slip
        return float(1.0 - (1.0 - steady) / (1.0 + belt[3]))

    def _rows(self, unknowns: _Floats) -> _Floats:
        belts, loads = len(BELT), self.loads
        belt = self.belt(unknowns)
        errors = self._errors @ unknowns[belts : belts + loads]
        measured = self.curve.slip + self.curve.slip_stddev * unknowns[belts + loads :]
        rows = np.empty((loads, 6))
        rows[:, 0] = 1.0 - (1.0 - measured) * (1.0 + belt[3])
        rows[:, 1] = np.maximum(errors, _LEAST_ERROR)
        rows[:, 2] = self.curve.speed
        rows[:, 3:] = belt[:3]
        return rows


def slip_model(
    curve: Curve, drive: BeltDrive, prior: Prior, drift: Drift, *, wide: bool = False
) -> SlipModel:
    """Return the model of a curve under the priors of a drive."""
    return SlipModel(
        curve,
        drive,
        assumed(prior, drive, wide=wide),
        prior.creep_error_stddev,
        drift.creep_error_load * prior.tension,
    )
