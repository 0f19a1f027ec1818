"""Loss of traction: how probable, and what is to blame."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from belt_ros.estimation.estimate import LostTraction
from belt_ros.estimation.state import STATES, Index
from belt_ros.estimation.traction import (
    Loss,
    Reference,
    lost_traction,
    named_loss,
    traction_reference,
)
from belt_ros.mechanics import Belt, BeltDrive, Pulley, Tensioning, torque_capacity
from belt_ros.mechanics.constants import drive_constants
from belt_ros.message_types import belt_typestore

PLACES = [Index.LOG_TENSION, Index.LOG_FRICTION]
TENSION, SOUND = 400.0, 0.05
START = np.array([math.log(TENSION), 0.0])


def drive(friction: float, tensioning: Tensioning = Tensioning.CONSTANT_MEAN) -> BeltDrive:
    driven = Pulley(0.08, math.pi, friction, 1e8, 0.05)
    driver = Pulley(0.05, 2.8, 1.1 * friction, 1e8, 0.05)
    return BeltDrive(Belt(80e3, 0.1), driven, driver, 0.5, tensioning=tensioning)


def reference(
    friction: float, tensioning: Tensioning = Tensioning.CONSTANT_MEAN, share: float = 0.8
) -> Reference:
    constants = drive_constants(drive(friction, tensioning))
    return traction_reference(constants, math.log(TENSION), math.log(friction), SOUND, share)


def belief(weights, means, covariances) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Members over (ln T, ln mu) as members over the state, its other entries arbitrary."""
    count = len(weights)
    full, spread = np.full((count, STATES), 7.0), np.tile(np.eye(STATES), (count, 1, 1))
    full[:, PLACES] = means
    spread[:, np.array(PLACES)[:, None], PLACES] = covariances
    return np.array(weights), full, spread


def at(friction: float, tension_to: float = 1.0, friction_to: float = 1.0, spread: float = 1e-4):
    mean = [math.log(TENSION * tension_to), math.log(friction * friction_to)]
    return belief([1.0], [mean], [np.diag([spread**2, spread**2])])


def observed(friction: float, share: float, tension: float | None = None):
    """Belief of a filter that sees traction fall to `share`, and a tension sensor if there is one.

    Its tension may have changed, its prior of mu is that of a sound surface.
    """
    mean, covariance = np.array([math.log(TENSION), math.log(friction)]), np.diag([0.16, SOUND**2])
    at_reference = reference(friction, share=0.999999)
    limit = friction * at_reference.grip
    readings = [(np.array([1.0, limit / math.sinh(limit)]), math.log(share), 0.03)]
    if tension is not None:
        readings.append((np.array([1.0, 0.0]), math.log(tension), 0.03))
    prior = mean.copy()
    for row, change, noise in readings:
        innovation = row @ prior + change - row @ mean
        gain = covariance @ row / (row @ covariance @ row + noise**2)
        mean = mean + gain * innovation
        covariance = covariance - np.outer(gain, row @ covariance)
    return belief([1.0], [mean], [covariance])


@pytest.mark.parametrize("tensioning", [Tensioning.CONSTANT_MEAN, Tensioning.CONSTANT_SLACK])
@pytest.mark.parametrize("friction", [0.3, 1.2])
@pytest.mark.parametrize(
    ("tension_to", "friction_to"), [(0.7, 1.0), (0.9, 1.0), (1.0, 0.4), (0.88, 0.85), (0.7, 1.6)]
)
def test_lost_is_what_the_capacity_at_rest_has_lost(
    tensioning: Tensioning, friction: float, tension_to: float, friction_to: float
) -> None:
    now = drive(friction * friction_to, tensioning)
    before = torque_capacity(drive(friction, tensioning), TENSION)
    share = float(torque_capacity(now, TENSION * tension_to) / before)
    for threshold, expected in ((share * 1.01, 1.0), (share * 0.99, 0.0)):
        if threshold < 1.0:
            compared = reference(friction, tensioning, threshold)
            lost = lost_traction(*at(friction, tension_to, friction_to), compared)
            assert lost.traction == pytest.approx(expected, abs=1e-3)


def test_a_healthy_drive_has_lost_nothing() -> None:
    lost = lost_traction(*at(1.2, spread=0.05), reference(1.2))
    assert lost == pytest.approx(LostTraction(0.0, 0.0, 0.0), abs=1e-4)
    assert named_loss(lost) is Loss.NONE


def sampled(members, compared: Reference, slack_held: bool) -> tuple[float, float, float]:
    weights, means, covariances = members
    random = np.random.default_rng(0)
    parts = random.multinomial(100_000, weights)
    x, y = np.concatenate(
        [
            random.multivariate_normal(m[PLACES], c[np.ix_(PLACES, PLACES)], n)
            for m, c, n in zip(means, covariances, parts, strict=True)
        ]
    ).T
    limit = compared.grip * np.exp(y)
    gain = np.log(np.expm1(limit)) if slack_held else np.log(np.tanh(0.5 * limit))
    lost = x + gain < compared.lost_log_traction
    by_tension = lost & (x < compared.lost_log_tension)
    return np.mean(lost), np.mean(by_tension), np.mean(lost & (y < compared.lost_log_friction))


@pytest.mark.parametrize("slack_held", [False, True])
@pytest.mark.parametrize("friction", [0.3, 0.5, 1.2])
@pytest.mark.parametrize(
    "spread", [(0.2, 0.05, 0.0), (0.05, 0.5, 0.0), (0.2, 0.5, 0.8), (0.1, 0.3, 0.95)]
)
def test_probabilities_are_those_of_samples(slack_held: bool, friction: float, spread) -> None:
    tensioning = Tensioning.CONSTANT_SLACK if slack_held else Tensioning.CONSTANT_MEAN
    # A prior of mu that says nothing, and is to be made no wider, leaves the members as they are.
    compared = reference(friction, tensioning)._replace(log_friction_stddev=1e3, tension_measured=1)
    x, y, rho = spread
    covariance = np.array([[x * x, rho * x * y], [rho * x * y, y * y]])
    mean = np.array([math.log(TENSION), math.log(friction)])
    shifts = np.array([[0.0, 0.0], [-0.4, 0.0], [-0.1, -0.4]])
    members = belief([0.5, 0.3, 0.2], mean + shifts, [covariance] * 3)
    lost = lost_traction(*members, compared, spoilt=1e3)
    expected = sampled(members, compared, slack_held)
    np.testing.assert_allclose(lost.traction, expected[0], atol=0.03)
    np.testing.assert_allclose(lost[1:], expected[1:], atol=0.07)


@pytest.mark.parametrize(
    ("friction", "share", "tension", "name"),
    [
        (0.5, 0.95, None, Loss.NONE),
        (0.5, 0.6, None, Loss.TRACTION),  # either would do
        (0.3, 0.6, None, Loss.TRACTION),
        (1.2, 0.6, None, Loss.TRACTION),
        (1.2, 0.25, None, Loss.TENSION),  # friction would have to be next to none
        (0.5, 0.6, 0.6, Loss.TENSION),
        (0.5, 0.6, 1.0, Loss.FRICTION),
        (1.2, 0.6, 1.0, Loss.FRICTION),
        (0.5, 0.5, 0.7, Loss.TRACTION),  # both
    ],
)
def test_blame_is_given_where_it_can_be_told(
    friction: float, share: float, tension: float | None, name: Loss
) -> None:
    compared = reference(friction)._replace(tension_measured=int(tension is not None))
    lost = lost_traction(*observed(friction, share, tension), compared)
    assert named_loss(lost) is name, lost


def test_a_tight_prior_of_mu_does_not_blame_the_tension() -> None:
    """The filter's own belief does, almost surely."""
    members = observed(0.5, 0.6)
    compared = reference(0.5)
    assert named_loss(lost_traction(*members, compared, spoilt=SOUND)) is Loss.TENSION
    assert named_loss(lost_traction(*members, compared)) is Loss.TRACTION


@pytest.mark.parametrize(
    ("lost", "name"),
    [
        (LostTraction(), Loss.NONE),
        (LostTraction(0.79, 0.79, 0.0), Loss.NONE),
        (LostTraction(0.9, 0.8, 0.1), Loss.TENSION),
        (LostTraction(0.9, 0.1, 0.8), Loss.FRICTION),
        (LostTraction(0.9, 0.5, 0.4), Loss.TRACTION),
        (LostTraction(0.9, 0.9, 0.9), Loss.TRACTION),
        (LostTraction(0.9, 0.85, 0.5), Loss.TRACTION),
    ],
)
def test_names_follow_from_probabilities(lost: LostTraction, name: Loss) -> None:
    assert named_loss(lost) is name


def test_numbers_are_those_of_the_message() -> None:
    message = belt_typestore().types["belt_msgs/msg/SlipAlarm"]
    assert {loss.name: loss.value for loss in Loss} == {
        "NONE": message.CONDITION_NONE,
        "TRACTION": message.CONDITION_TRACTION_LOST,
        "TENSION": message.CONDITION_TENSION_LOST,
        "FRICTION": message.CONDITION_FRICTION_LOST,
    }


@hypothesis_settings(derandomize=True, deadline=None, max_examples=200)
@given(
    x=st.floats(-30.0, 30.0),
    y=st.floats(-60.0, 60.0),
    spread=st.tuples(st.floats(0.0, 10.0), st.floats(0.0, 10.0), st.floats(-1.0, 1.0)),
    slack_held=st.booleans(),
    weight=st.sampled_from([0.0, 1e-9, 1.0]),
)
def test_whatever_is_believed_probabilities_are_some(x, y, spread, slack_held, weight) -> None:
    a, b, rho = spread
    covariance = np.array([[a * a, rho * a * b], [rho * a * b, b * b]])
    tensioning = Tensioning.CONSTANT_SLACK if slack_held else Tensioning.CONSTANT_MEAN
    members = belief([weight], [[x, y]], [covariance])
    lost = lost_traction(*members, reference(0.5, tensioning))
    assert 0.0 <= lost.traction <= 1.0
    assert 0.0 <= lost.tension <= lost.traction + 1e-12
    assert 0.0 <= lost.friction <= lost.traction + 1e-12
