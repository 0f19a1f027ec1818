"""A bag that no one here wrote: a flat belt drive simulated in Exudyn, with its true tensions.

The plant is not the model. At its true tensions the model's slip is off by half a percent, which,
taken as exact, would pull the tension by about 45 N; hence the interval must leave room for it.
"""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from belt_ros.estimation import BeltEstimate, Measurement, Quantity
from belt_ros.replay.drive_bag import DriveBag
from belt_ros.settings import load_settings

ROOT = Path(__file__).resolve().parents[2]
BAG = ROOT.parent / "shared" / "data" / "exudyn_belt_drive"
CONFIG = ROOT / "config" / "exudyn_flat_belt.yaml"
TIGHT, SLACK = 665.2, 186.6  # [N], recorded belt force at the end
pytestmark = pytest.mark.skipif(not BAG.is_dir(), reason="../shared/data is not there")


@dataclasses.dataclass
class Played:
    recorded: list[Measurement]
    estimates: list[BeltEstimate]

    @property
    def settled(self) -> list[tuple[Measurement, BeltEstimate]]:
        begin = self.recorded[0].stamp_ns
        return [
            (recorded, estimate)
            for recorded, estimate in zip(self.recorded, self.estimates, strict=True)
            if recorded.stamp_ns - begin >= 2_000_000_000
        ]


def noisy(measurement: Measurement, rng: np.random.Generator) -> Measurement:
    """0.01 % of speed and 1 % of torque."""
    w2, w1, t2, t1 = rng.standard_normal(4)
    return dataclasses.replace(
        measurement,
        driver_speed=measurement.driver_speed * (1.0 + 1e-4 * w2),
        driven_speed=measurement.driven_speed * (1.0 + 1e-4 * w1),
        driver_torque=measurement.driver_torque * (1.0 + 0.01 * t2),
        driven_torque=measurement.driven_torque * (1.0 + 0.01 * t1),
    )


@pytest.fixture(scope="module", params=[0, 1])
def played(request) -> Played:
    settings = load_settings(CONFIG)
    prior = settings.prior
    assert (prior.tension, prior.tension_stddev) == (300.0, 100.0)
    assert (prior.friction_stiffness, prior.friction_stiffness_decades) == (1e8, 1.0)
    assert (prior.friction_coefficient, prior.friction_coefficient_stddev) == (0.5, 0.025)
    monitor = settings.monitor()
    rng = np.random.default_rng(request.param)
    recorded, estimates = [], []
    with DriveBag(BAG, settings) as bag:
        for sample in bag.samples():
            assert isinstance(sample.content, Measurement)
            output = monitor.step(noisy(sample.content, rng))
            assert output.estimate is not None
            recorded.append(sample.content)
            estimates.append(output.estimate)
    return Played(recorded, estimates)


def test_every_message_gives_an_estimate_without_nan(played) -> None:
    assert len(played.estimates) == 2451
    for estimate in played.estimates:
        for field in dataclasses.fields(estimate):
            value = getattr(estimate, field.name)
            numbers = value if isinstance(value, Quantity) else (value,)
            assert all(math.isfinite(n) for n in numbers if isinstance(n, float)), field.name


def test_slip_is_within_two_percent_of_the_recorded_one(played) -> None:
    for recorded, estimate in played.settled:
        slip = 1.0 - recorded.driven_speed / recorded.driver_speed
        assert estimate.slip.value == pytest.approx(slip, rel=0.02)


def test_effective_pull_is_within_one_and_a_half_percent(played) -> None:
    for _, estimate in played.settled[-100:]:
        pull = estimate.tight_tension.value - estimate.slack_tension.value
        assert pull == pytest.approx(TIGHT - SLACK, rel=0.015)


def test_both_tensions_lie_in_their_own_interval(played) -> None:
    for _, estimate in played.settled:
        low, high = estimate.tight_tension.interval()
        assert low < TIGHT < high
        low, high = estimate.slack_tension.interval()
        assert low < SLACK < high


def test_the_tension_is_not_claimed_better_than_the_data_allow(played) -> None:
    last = played.estimates[-1]
    assert 10.0 < last.mean_tension.stddev < 120.0
