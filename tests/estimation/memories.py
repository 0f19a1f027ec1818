"""Beliefs to be remembered and what was learned from them, shared by the tests of memory."""

import math

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

from belt_ros.estimation import Drift, Prior
from belt_ros.estimation.gaussian_sum import Component, mixture_moments, normalised
from belt_ros.estimation.installed import Installed
from belt_ros.estimation.memory import REMEMBERED, Learned, learned_from
from belt_ros.estimation.process import prior_state
from belt_ros.estimation.state import STATES, Index
from belt_ros.mechanics import Belt, BeltDrive, Pulley

DRIVE = BeltDrive(
    Belt(80068.0, 0.1036), Pulley(0.08, 3.0, 0.5, 1e8), Pulley(0.06, 2.9, 0.6, 2e8), 0.5
)
PRIOR, DRIFT = Prior(), Drift()
MEAN, STDDEV = prior_state(PRIOR, DRIVE)
INSTALLED = Installed(400.0, math.log(400.0), math.log(0.5))
PLACES = list(REMEMBERED)
DATE = 1.75e9
exactly = settings(derandomize=True, deadline=None, max_examples=60)


class Members(list[Component]):
    def __repr__(self) -> str:
        return f"{len(self)} members"


@st.composite
def members(draw: st.DrawFn, most: int = 5) -> "Members":
    """Members of a filter in the middle of its work, all states going with all others."""
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    out = Members()
    for _ in range(draw(st.integers(1, most))):
        factor = rng.standard_normal((STATES, STATES)) * rng.uniform(0.02, 0.4)
        out.append(
            Component(
                rng.uniform(-5.0, 0.0),
                MEAN + STDDEV * rng.standard_normal(STATES),
                np.outer(STDDEV, STDDEV) * (factor @ factor.T),
                bool(rng.random() < 0.2),
            )
        )
    return out


def moments(components: list[Component]) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance, in units of the prior's deviations."""
    mean, covariance = mixture_moments(
        normalised(np.array([c.log_weight for c in components])),
        np.stack([c.mean for c in components]),
        np.stack([c.covariance for c in components]),
    )
    remembered = len(mean) == len(PLACES)
    centre, unit = (MEAN[PLACES], STDDEV[PLACES]) if remembered else (MEAN, STDDEV)
    return (mean - centre) / unit, covariance / np.outer(unit, unit)


def learn(components: list[Component]) -> Learned:
    return learned_from(components, "conveyor", DRIVE, DATE, INSTALLED)


def one(tension: float = 500.0, spread: float = 0.05) -> list[Component]:
    mean, covariance = MEAN.copy(), np.diag((0.1 * STDDEV) ** 2)
    mean[Index.LOG_TENSION] = math.log(tension)
    covariance[Index.LOG_TENSION, Index.LOG_TENSION] = spread**2
    return [Component(0.0, mean, covariance)]
