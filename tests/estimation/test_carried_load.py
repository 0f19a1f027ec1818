"""What a load that has been carried says of the tension, where slip says nothing of it."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.stats import norm

from belt_ros.estimation.process import lognormal
from belt_ros.mechanics import torque_capacity
from belt_ros.rig import measured
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.settings import DriveSettings, settings_from_parameters

TENSION, SPREAD, SPEED = 800.0, 240.0, 30.0
SHARE = 0.85  # of the capacity that the estimator is told
UNTIL = 1.7  # [s]
DRAWS = 20_000


def conveyor() -> DriveSettings:
    """An elastic belt on a stiff contact: creep is the belt's own, until it slips."""
    parameters: dict[str, object] = {
        "name": "conveyor",
        "belt.axial_stiffness": 20000.0,
        "belt.mass_per_length": 0.3,
        "span_length": 0.628,
        "prior.tension": TENSION,
        "prior.tension_stddev": SPREAD,
        "prior.friction_stiffness": 8.1e7,
        "prior.friction_stiffness_decades": 0.3,
        "prior.friction_coefficient": 0.6,
        "prior.friction_coefficient_stddev": 0.03,
        "noise.speed_relative": 1e-4,
        "noise.torque_relative": 0.005,
    }
    for pulley in ("driver", "driven"):
        parameters[f"{pulley}.radius"] = 0.1
        parameters[f"{pulley}.wrap_angle"] = math.pi
        parameters[f"{pulley}.inertia"] = 0.05
    return settings_from_parameters(parameters)


def capacity(settings: DriveSettings, friction: float) -> float:
    """Of the drive with the tension that is told [N m]."""
    pulleys = {
        name: dataclasses.replace(getattr(settings.drive, name), friction_coefficient=friction)
        for name in ("driver", "driven")
    }
    drive = dataclasses.replace(settings.drive, **pulleys)
    return float(torque_capacity(drive, TENSION, SPEED))


def carried(settings: DriveSettings, seed: int) -> tuple[float, object]:
    """Let a load come within 0.2 s; return the most that was carried [N m], and what is known."""
    script = {
        "duration": UNTIL,
        "sample_rate": 50.0,
        "seed": seed,
        "speed": [[0.0, 0.0], [0.8, SPEED]],
        "load": [[1.1, 0.0], [1.3, SHARE * capacity(settings, 0.6)]],
        "condition.tension": 820.0,
    }
    monitor = settings.monitor()
    most = 0.0
    for measurement, truth in measured(settings, scenario_from_mapping(script, settings)):
        monitor.step(measurement)
        most = max(most, truth.transmitted_torque)
    return most, monitor.learned(0.0)


@pytest.mark.parametrize("quantile", [0.2, 0.3, 0.4])
def test_it_rules_out_what_could_not_have_carried_it_and_little_more(quantile: float) -> None:
    settings = conveyor()
    random = np.random.default_rng(1)
    log_mean, log_stddev = lognormal(TENSION, SPREAD)
    log_tension = log_mean + log_stddev * random.standard_normal(DRAWS)
    friction = 0.6 * np.exp(0.05 * random.standard_normal(DRAWS))
    of_friction = np.linspace(friction.min(), friction.max(), 9)
    most_of = np.interp(friction, of_friction, [capacity(settings, mu) for mu in of_friction])
    believed = []
    for seed in range(4):
        most, known = carried(settings, seed)
        left = log_tension[np.exp(log_tension) / TENSION * most_of > most]
        at = np.quantile(left, quantile)
        deviation = np.sqrt(known.covariances[:, 0, 0])
        believed.append(float(known.weights @ norm.cdf((at - known.means[:, 0]) / deviation)))
    assert np.mean(believed) == pytest.approx(quantile, abs=0.06)
