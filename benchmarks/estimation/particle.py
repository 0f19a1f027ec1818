"""A particle filter on the estimator's model: how accurate an estimate can be, at any cost.

Particles carry (ln T, ln kf, ln mu), in which the model bends; given these, the other eight states
are nearly linear, and each particle carries a Gaussian of them (Rao-Blackwell). When weights have
become uneven, particles are drawn anew and moved a little (Liu and West), their Gaussians with them
by regression, so that mean and covariance of the whole stay. A sharp reading is taken in by parts.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.process import Process
from belt_ros.estimation.state import STATES, Index, propagate_each
from belt_ros.estimation.unscented import sigma_points
from belt_ros.estimation.weighing import innovations_squared
from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants
from belt_ros.settings import DriveSettings
from benchmarks.estimation.judged import Quantities
from benchmarks.estimation.model import CARRIED, SENSED, ModelFilter, by_name

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]
_BENT = np.array([Index.LOG_TENSION, Index.LOG_STIFFNESS, Index.LOG_FRICTION], dtype=np.int64)
_STRAIGHT = np.array([i for i in range(CARRIED) if i not in _BENT], dtype=np.int64)
_SENSED = np.searchsorted(_STRAIGHT, SENSED)  # equal to SENSED: none before them is bent
_FEWEST = 0.5  # effective share of particles below which they are drawn anew
_BEARABLE = 0.3  # effective share below which a reading is taken in little by little ...
_LEAST_SHARE = 1e-4  # ... and no less than which
_KERNEL = 0.25  # standard deviation of what moves them then, relative to their own


class Cloud(NamedTuple):
    """Particles: ln weights (n,), states (n, CARRIED), covariances (n, 8, 8) of straight states."""

    log_weights: _Floats
    states: _Floats
    covariances: _Floats


@compiled
def _propagate_groups(c: DriveConstants, groups: _Floats, dt: float) -> None:
    """Advance groups (n, k, 12) of states by `dt` [s], each solved from its first."""
    for k in range(groups.shape[0]):
        propagate_each(c, groups[k], dt)


def motion_jacobians(
    c: DriveConstants, states: _Floats, pull_steps: _Floats, error_steps: _Floats, dt: float
) -> tuple[_Floats, _Floats]:
    """Advance states (n, CARRIED); return them, and Jacobians (n, 3, 8) of what moves.

    Jacobians are by the states `_STRAIGHT`.

    The new pull depends on speeds, torques, bias and undeveloped creep as on the wind-up that they
    amount to (`step_motion`), but for the belt's inertia and the speed of creep, to which speeds
    that are measured add nothing. So two differences, by the old pull and by the creep error, give
    the whole.
    """
    groups = np.zeros((len(states), 3, STATES))
    groups[:, :, :CARRIED] = states[:, None]
    groups[:, 1, 2] += pull_steps
    groups[:, 2, 9] += error_steps
    _propagate_groups(c, groups, dt)
    moved = groups[:, 0, :CARRIED]
    by_pull, by_error = (groups[:, 1:, 2] - moved[:, None, 2]).T / (pull_steps, error_steps)
    by_winding = by_pull * dt / c.span_compliance
    driver_radius, driven_radius = c.driver_radius, c.driven_radius * (1.0 + states[:, 8])
    fastest = np.maximum(np.abs(driver_radius * states[:, 0]), np.abs(driven_radius * states[:, 1]))
    driver_gain, driven_gain = dt / c.driver_inertia, dt / c.driven_inertia
    jacobians = np.zeros((len(states), 3, 8))
    pull = jacobians[:, 2]
    pull[:, 0] = by_winding * driver_radius
    pull[:, 1] = -by_winding * driven_radius
    pull[:, 2] = by_pull
    pull[:, 3] = by_winding * dt * driver_radius / c.driver_inertia
    pull[:, 4] = -by_winding * dt * c.driven_radius / c.driven_inertia
    pull[:, 5] = -by_winding * c.driven_radius * states[:, 1]
    pull[:, 6] = by_error
    pull[:, 7] = -by_winding * fastest
    jacobians[:, 0] = -driver_gain * driver_radius * pull
    jacobians[:, 1] = driven_gain * c.driven_radius * pull
    jacobians[:, 0, 0] += 1.0
    jacobians[:, 1, 1] += 1.0
    jacobians[:, 0, 3] += driver_gain
    jacobians[:, 1, 4] += driven_gain
    return moved, jacobians


def _moved(
    c: DriveConstants, states: _Floats, covariances: _Floats, added: _Floats, dt: float
) -> tuple[_Floats, _Floats]:
    """Advance each particle's Gaussian by the law of motion, linearised at its mean."""
    pull_steps, error_steps = 0.1 * np.sqrt(covariances[:, (2, 6), (2, 6)]).T + 1e-9
    moved, jacobians = motion_jacobians(c, states, pull_steps, error_steps, dt)
    crossed = jacobians @ covariances  # with what stays as it is
    out = covariances.copy()
    out[:, :3] = crossed
    out[:, 3:, :3] = crossed[:, :, 3:].transpose(0, 2, 1)
    out[:, :3, :3] = crossed @ jacobians.transpose(0, 2, 1)
    return moved, out + added


@compiled
def _taken_in(
    states: _Floats,
    covariances: _Floats,
    straight: _Places,
    z: _Floats,
    variance: _Floats,
    sensed: _Places,
) -> tuple[_Floats, _Floats]:
    """Take readings of the straight states `sensed` into each particle's Gaussian."""
    count, n = covariances.shape[:2]
    states, covariances = states.copy(), covariances.copy()
    for k in range(count):
        p = covariances[k]
        for reading in range(z.shape[0]):
            at = sensed[reading]
            column = p[at].copy()
            total = column[at] + variance[reading]
            innovation = z[reading] - states[k, straight[at]]
            for i in range(n):
                gain = column[i] / total
                states[k, straight[i]] += gain * innovation
                for j in range(n):
                    p[i, j] -= gain * column[j]
    return states, covariances


@compiled
def _drawn(states: _Floats, covariances: _Floats, straight: _Places, normal: _Floats) -> _Floats:
    """Draw one state (CARRIED,) of each particle."""
    count, n = normal.shape
    out = states.copy()
    order, unit, zero = np.arange(n), np.ones(n), np.zeros(n)
    for k in range(count):
        points = sigma_points(zero, covariances[k], order, unit)
        for i in range(n):
            for j in range(n):
                out[k, straight[j]] += normal[k, i] * points[1 + i, j]
    return out


def _effective(log_weights: _Floats) -> float:
    """Effective number of particles over their number."""
    weights = np.exp(log_weights - np.max(log_weights))
    return float(np.sum(weights) ** 2 / np.sum(weights**2) / len(weights))


class Particles(ModelFilter[Cloud]):
    """Rao-Blackwellised particle filter.

    Parameters
    ----------
    settings : DriveSettings
    count : int
        Number of particles.
    seed : int
    """

    def __init__(self, settings: DriveSettings, count: int, seed: int) -> None:
        super().__init__(settings)
        self._count = count
        self._random = np.random.default_rng([seed, count])
        self._cloud = Cloud(np.zeros(0), np.zeros((0, CARRIED)), np.zeros((0, 8, 8)))

    def quantities(self) -> Quantities:
        """Return what is known now."""
        cloud = self._cloud
        normal = self._random.standard_normal((self._count, len(_STRAIGHT)))
        rows = self.model.judged(_drawn(cloud.states, cloud.covariances, _STRAIGHT, normal))
        weights = self._weights()
        mean = weights @ rows
        return by_name(mean, np.sqrt(weights @ (rows - mean) ** 2))

    def _weights(self) -> _Floats:
        weights = np.exp(self._cloud.log_weights - np.max(self._cloud.log_weights))
        return np.asarray(weights / np.sum(weights))

    def _begin(self, mean: _Floats, covariance: _Floats) -> None:
        spread = np.sqrt(np.diag(covariance))
        states = np.tile(mean, (self._count, 1))
        normal = self._random.standard_normal((self._count, len(_BENT)))
        states[:, _BENT] += spread[_BENT] * normal
        straight = covariance[np.ix_(_STRAIGHT, _STRAIGHT)]
        self._cloud = Cloud(np.zeros(self._count), states, np.tile(straight, (self._count, 1, 1)))

    def _mean(self) -> _Floats:
        return self._weights() @ self._cloud.states

    def _state(self) -> Cloud:
        return self._cloud

    def _restore(self, state: Cloud) -> None:
        self._cloud = state

    def _predict(self, process: Process, dt: float) -> None:
        log_weights, states, covariances = self._cloud
        memory, gained = process.memory, process.covariance_before
        states = self.model.mean + memory * (states - self.model.mean)
        normal = self._random.standard_normal((self._count, len(_BENT)))
        states[:, _BENT] += np.sqrt(np.diag(gained)[_BENT]) * normal
        straight = memory[_STRAIGHT]
        covariances = covariances * np.outer(straight, straight)
        covariances += gained[np.ix_(_STRAIGHT, _STRAIGHT)]
        self._cloud = Cloud(
            log_weights,
            *_moved(
                self.model.constants,
                states,
                covariances,
                np.diag(process.variance_after[_STRAIGHT]),
                dt,
            ),
        )

    def _foretold(self, z: _Floats, variance: _Floats) -> tuple[_Floats, _Floats]:
        weights = self._weights()
        spread = self._cloud.covariances[:, _SENSED[:, None], _SENSED]
        about = self._cloud.states[:, SENSED] - weights @ self._cloud.states[:, SENSED]
        covariance = np.tensordot(weights, spread, 1) + (about.T * weights) @ about
        return z - weights @ self._cloud.states[:, SENSED], covariance + np.diag(variance)

    def _update(self, z: _Floats, variance: _Floats) -> None:
        left = 1.0
        while left > 0.0:
            left -= self._weigh(z, variance, left)
        log_weights, states, covariances = self._cloud
        self._cloud = Cloud(
            log_weights, *_taken_in(states, covariances, _STRAIGHT, z, variance, _SENSED)
        )

    def _weigh(self, z: _Floats, variance: _Floats, left: float) -> float:
        """Weigh particles by as much of a likelihood as they bear, `left` at most; return it.

        A reading that few particles explain is taken in little by little, with new ones drawn in
        between; all at once would leave copies of those few.
        """
        log_weights, states, covariances = self._cloud
        # As the estimator's members: the load's noise is a guess, by which none must be favoured.
        squared, _ = innovations_squared(
            states[:, _STRAIGHT], covariances, self._weights(), z, variance, _SENSED
        )
        share = left
        while share > _LEAST_SHARE and _effective(log_weights - 0.5 * share * squared) < _BEARABLE:
            share *= 0.5
        log_weights = log_weights - 0.5 * share * squared
        self._cloud = Cloud(log_weights - np.max(log_weights), states, covariances)
        if _effective(log_weights) < _FEWEST:
            self._draw_anew(self._weights())
        return share

    def _draw_anew(self, weights: _Floats) -> None:
        """Resample systematically, and move what is then alike apart."""
        count = self._count
        edges = (np.arange(count) + self._random.random()) / count
        chosen = np.minimum(np.searchsorted(np.cumsum(weights), edges), count - 1)
        states = self._cloud.states[chosen]
        bent = states[:, _BENT]
        covariance = np.cov(states.T)
        within = covariance[np.ix_(_BENT, _BENT)] + 1e-14 * np.eye(len(_BENT))
        kernel = self._random.multivariate_normal(np.zeros(len(_BENT)), within, count)
        shrunk = np.sqrt(1.0 - _KERNEL**2)
        shift = (shrunk - 1.0) * (bent - np.mean(bent, axis=0)) + _KERNEL * kernel
        slope = np.linalg.solve(within, covariance[np.ix_(_BENT, _STRAIGHT)])
        states[:, _BENT] += shift
        states[:, _STRAIGHT] += shift @ slope
        self._cloud = Cloud(np.zeros(count), states, self._cloud.covariances[chosen])
