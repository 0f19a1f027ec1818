"""A drive drawn from what the estimator is told: parameters from the prior, wandering as stated."""

import dataclasses
import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation import Measurement
from belt_ros.estimation.process import lognormal
from belt_ros.mechanics import torque_capacity
from belt_ros.rig import Truth
from belt_ros.rig.profile import Profile
from belt_ros.rig.scenario import Scenario, scenario_from_mapping
from belt_ros.settings import DriveSettings
from benchmarks.estimation.cells import BELTS, Cell

DURATION = 8.0  # [s]
RATE = 50.0  # [Hz]
JUDGED_AT = (3.1, 5.4, 7.9)  # [s], each late in one level of the load
_SPEED_UP = 0.8  # [s]
_LEVELS_BEGIN = (1.1, 3.2, 5.5)  # [s]; idle before the first
_QUICK, _SLOW = 0.2, 1.5  # [s] to get to a level; one of them is got to slowly
_WALK_STEP = 0.1  # [s] between the points of a walk

_Floats = NDArray[np.float64]


class Condition(NamedTuple):
    """What the belt is over a run: tension [N], mu and kf [N/m2], each (n,), at `times` (n,)."""

    times: _Floats
    tension: _Floats
    friction: _Floats
    stiffness: _Floats

    def capacity(self, settings: DriveSettings, time: float, speed: float) -> float:
        """Greatest torque [N m] at `time` [s]."""
        friction = float(np.interp(time, self.times, self.friction))
        drive = dataclasses.replace(
            settings.drive,
            driven=dataclasses.replace(settings.drive.driven, friction_coefficient=friction),
            driver=dataclasses.replace(settings.drive.driver, friction_coefficient=friction),
        )
        tension = float(np.interp(time, self.times, self.tension))
        return float(torque_capacity(drive, tension, speed))


def drawn_condition(
    random: np.random.Generator, settings: DriveSettings, duration: float
) -> Condition:
    """Draw a belt from its prior, and let it wander for `duration` [s] as the drift says."""
    prior, drift = settings.prior, settings.drift
    times = np.arange(0.0, duration + _WALK_STEP, _WALK_STEP)
    tension = _walk(random, *lognormal(prior.tension, prior.tension_stddev), drift.tension, times)
    friction = _walk(
        random,
        *lognormal(prior.friction_coefficient, prior.friction_coefficient_stddev),
        drift.friction_coefficient,
        times,
    )
    stiffness = _walk(
        random,
        math.log(prior.friction_stiffness),
        prior.friction_stiffness_decades * math.log(10.0),
        drift.friction_stiffness,
        times,
    )
    return Condition(times, tension, friction, stiffness)


def scenario_of(
    random: np.random.Generator,
    settings: DriveSettings,
    condition: Condition,
    values: dict[str, object],
) -> Scenario:
    """Return a scenario with this belt, its other errors drawn from the prior."""
    prior = settings.prior
    drawn: dict[str, object] = {
        "seed": float(random.integers(2**32)),
        "condition.tension": float(condition.tension[0]),
        "condition.ratio_bias": prior.ratio_bias_stddev * float(random.standard_normal()),
        "condition.creep_error_stddev": prior.creep_error_stddev,
        "condition.creep_error_time": settings.drift.creep_error_time,
        "condition.creep_error_pull": settings.drift.creep_error_load * prior.tension,
    }
    scenario = scenario_from_mapping({**drawn, **values}, settings)
    walks = (Profile(tuple(condition.times), tuple(walk)) for walk in condition[1:])
    return dataclasses.replace(scenario, profiles=(*scenario.profiles[:2], *walks))


def drawn_scenario(
    cell: Cell,
    settings: DriveSettings,
    seed: int,
    *,
    rate: float = RATE,
    of_true_capacity: bool = False,
) -> Scenario:
    """Return a run of a drive that is a draw from its priors, under a load drawn for the cell.

    While creep develops, its slip is beside it as far as the estimator takes it to be.

    The levels of the load are shares of the capacity that the settings tell, the first of them that
    of the cell and the others less; a drive that would slip through before it is first judged is
    drawn again. Nothing is hidden from the estimator by that, since by then it has seen how the
    greatest load was carried. With `of_true_capacity`, levels are shares of the drive's own
    capacity when they begin, in any order, and that is what no estimator can know. `rate` [Hz]
    changes nothing but how often the sensors speak.
    """
    random = np.random.default_rng([cell.seed, seed])
    speed = BELTS[cell.belt].speed
    if of_true_capacity:
        condition = drawn_condition(random, settings, DURATION)
        capacities = [condition.capacity(settings, t, speed) for t in _LEVELS_BEGIN]
        load = _load(random, cell.peak, capacities)
    else:
        told = _told(settings).capacity(settings, 0.0, speed)
        load = _load(random, cell.peak, [told] * len(_LEVELS_BEGIN), greatest=0)
        condition = drawn_condition(random, settings, DURATION)
        while _slips_through(condition, settings, speed, load):
            condition = drawn_condition(random, settings, DURATION)
    values: dict[str, object] = {
        "name": cell.name,
        "condition.undeveloped_creep": 1.0,
        "duration": DURATION,
        "sample_rate": rate,
        "speed": [[0.0, 0.0], [_SPEED_UP, speed]],
        "load": load,
    }
    return scenario_of(random, settings, condition, values)


def speeds_and_torques(
    samples: Iterable[tuple[Measurement, Truth]],
) -> Iterator[tuple[Measurement, Truth]]:
    """Leave out all other sensors, so that every estimator has the same data."""
    for m, truth in samples:
        speeds, torques = (m.driver_speed, m.driven_speed), (m.driver_torque, m.driven_torque)
        yield Measurement(m.stamp_ns, *speeds, *torques), truth


def _walk(
    random: np.random.Generator, mean: float, spread: float, rate: float, times: _Floats
) -> _Floats:
    """Draw exp of an Ornstein-Uhlenbeck walk, stationary at `spread`, of `rate` per root second."""
    memory = math.exp(-0.5 * (rate / spread) ** 2 * (times[1] - times[0]))
    away = np.empty_like(times)
    away[0] = random.standard_normal()
    for i in range(1, times.size):
        away[i] = memory * away[i - 1] + math.sqrt(1.0 - memory**2) * random.standard_normal()
    return np.exp(mean + spread * away)


def _told(settings: DriveSettings) -> Condition:
    """Return the belt as the settings tell it, at all times."""
    prior = settings.prior
    values = (0.0, prior.tension, prior.friction_coefficient, prior.friction_stiffness)
    return Condition(*(np.array([value]) for value in values))


def _slips_through(
    condition: Condition, settings: DriveSettings, speed: float, load: list[list[float]]
) -> bool:
    """Whether the load is more than the belt carries, before anything is judged."""
    times = condition.times[condition.times <= JUDGED_AT[0]]
    loads = np.interp(times, *np.transpose(load))
    capacities = [condition.capacity(settings, float(t), speed) for t in times]
    return bool(np.any(loads >= capacities))


def _load(
    random: np.random.Generator, peak: float, capacities: list[float], greatest: int | None = None
) -> list[list[float]]:
    """Draw one level for each of `capacities`, the `greatest` of them, or any, being the peak."""
    shares = peak * random.uniform(0.1, 1.0, len(capacities))
    shares[random.integers(len(capacities)) if greatest is None else greatest] = peak
    slow = random.integers(len(capacities))
    points = [[0.0, 0.0]]
    for number, (begin, share, capacity) in enumerate(
        zip(_LEVELS_BEGIN, shares, capacities, strict=True)
    ):
        takes = _SLOW if number == slow else _QUICK
        points += [[begin, points[-1][1]], [begin + takes, float(share) * capacity]]
    return points
