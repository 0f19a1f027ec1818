"""How members change between their modes, and how few stand for an unlikely one."""

import numpy as np
import pytest

from belt_ros.estimation.gaussian_sum import Component, mixture_moments
from belt_ros.estimation.modes import due, few, parted

STATES, AXES = 4, (1, 2)


def members(count: int, share: float, *, changing: bool) -> list[Component]:
    """Members spread along the axes, whose weights come to `share`."""
    rng = np.random.default_rng(count)
    weights = rng.uniform(0.5, 1.5, count)
    weights *= share / np.sum(weights)
    return [
        Component(
            float(np.log(weight)),
            rng.standard_normal(STATES),
            np.diag(rng.uniform(0.01, 0.1, STATES)),
            changing,
        )
        for weight in weights
    ]


def summed_up(components: list[Component]) -> tuple[float, np.ndarray, np.ndarray]:
    weights = np.exp([component.log_weight for component in components])
    means = np.stack([component.mean for component in components])
    covariances = np.stack([component.covariance for component in components])
    return float(np.sum(weights)), *mixture_moments(weights / np.sum(weights), means, covariances)


@pytest.mark.parametrize("changing", [False, True])
def test_few_members_stand_for_many_with_the_same_weight_mean_and_covariance(
    changing: bool,
) -> None:
    many = members(30, 0.01, changing=changing)
    left = few(many, AXES)
    assert len(left) <= 6
    assert all(component.changing is changing for component in left)
    for before, after in zip(summed_up(many), summed_up(left), strict=True):
        np.testing.assert_allclose(after, before, rtol=1e-12, atol=1e-15)


def test_members_that_are_few_stay_as_they_are() -> None:
    three = members(3, 0.01, changing=True)
    assert few(three, AXES) is three
    assert few([], AXES) == []


@pytest.mark.parametrize("changing", [False, True])
def test_only_a_mode_that_is_unlikely_is_told_apart(changing: bool) -> None:
    rest = members(12, 0.99, changing=not changing)
    small, large = members(9, 0.01, changing=changing), members(9, 0.3, changing=changing)
    assert parted(rest + small) == (rest, small)
    assert parted(rest + large) == (rest + large, [])
    assert parted(rest) == (rest, [])


@pytest.mark.parametrize(("share", "every"), [(0.001, 1.0), (0.05, 0.1), (0.999, 0.1)])
def test_members_change_modes_more_often_while_traction_may_be_changing(
    share: float, every: float
) -> None:
    both = members(9, share, changing=True) + members(9, 1.0 - share, changing=False)
    assert due(both, every)
    assert not due(both, 0.9 * every)


def test_a_mode_without_members_gets_some_at_once() -> None:
    assert due(members(3, 1.0, changing=False), 0.0)
    assert due(members(3, 1.0, changing=True), 0.0)
