import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sums import moments

from belt_ros.estimation.gaussian_sum import Component, normalised, split
from belt_ros.estimation.reduction import AFFORDABLE, reduced

MEAN = np.array([1.0, -2.0, 0.5])
DEVIATION = np.array([0.3, 2.0, 0.1])


def density(components: list[Component], x: np.ndarray) -> np.ndarray:
    """Of a sum over one state."""
    weights = normalised(np.array([c.log_weight for c in components]))
    total = np.zeros_like(x)
    for weight, c in zip(weights, components, strict=True):
        variance = c.covariance[0, 0]
        peak = weight / np.sqrt(2.0 * np.pi * variance)
        total += peak * np.exp(-0.5 * (x - c.mean[0]) ** 2 / variance)
    return total


def drawn(random: np.random.Generator, count: int) -> list[Component]:
    """Members over three states that lie beside and within each other."""
    members = []
    for k in range(count):
        factor = random.standard_normal((3, 3)) * 0.2 + np.diag(np.exp(random.normal(0.0, 0.3, 3)))
        members.append(
            Component(
                float(random.normal(0.0, 2.0)),
                random.normal(0.0, 1.5, 3),
                factor @ factor.T,
                changing=bool(k % 3 == 0),
            )
        )
    return members


def test_merging_keeps_mean_and_covariance() -> None:
    alike = [
        Component(-0.1, MEAN, np.diag(DEVIATION**2)),
        Component(-1.0, MEAN + 0.02 * DEVIATION, np.diag((1.05 * DEVIATION) ** 2)),
    ]
    merged = reduced(alike, (0, 1))
    assert len(merged) == 1
    for before, after in zip(moments(alike), moments(merged), strict=True):
        np.testing.assert_allclose(before, after, rtol=1e-12, atol=1e-15)


def test_members_that_differ_in_place_width_or_mode_stay_apart() -> None:
    one = Component(0.0, MEAN, np.diag(DEVIATION**2))
    elsewhere = Component(0.0, MEAN + DEVIATION, np.diag(DEVIATION**2))
    wider = Component(0.0, MEAN, np.diag((2.0 * DEVIATION) ** 2))
    other_mode = Component(0.0, MEAN, np.diag(DEVIATION**2), changing=True)
    assert len(reduced([one, elsewhere, wider, other_mode], (0, 1))) == 4


def test_what_matters_little_goes_into_what_is_near() -> None:
    heavy = [Component(0.0, np.array([place]), np.eye(1)) for place in (0.0, 6.0)]
    light = Component(-8.0, np.array([7.5]), np.eye(1))
    near, far = sorted(reduced([*heavy, light], (0,)), key=lambda c: -c.mean[0])
    assert near.log_weight == pytest.approx(np.logaddexp(0.0, -8.0))
    assert far.mean[0] == 0.0


def test_a_mode_keeps_its_shape_however_unlikely_it_is() -> None:
    """It may be what comes true; by its share of the whole, all of it would be one member."""
    settled = Component(0.0, np.zeros(1), np.eye(1))
    changing = [
        Component(-12.0, np.array([place]), np.eye(1), changing=True) for place in (-4.0, 4.0)
    ]
    assert len(reduced([settled, *changing], (0,))) == 3


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 24), most=st.integers(2, 24))
def test_no_more_than_asked_for_are_left_and_the_sum_has_its_moments(
    seed: int, count: int, most: int
) -> None:
    members = drawn(np.random.default_rng(seed), count)
    left = reduced(members, (0, 2), most)
    assert 1 <= len(left) <= min(most, count)
    assert {c.changing for c in left} == {c.changing for c in members}
    assert [c.log_weight for c in left] == sorted((c.log_weight for c in left), reverse=True)
    for before, after in zip(moments(members), moments(left), strict=True):
        np.testing.assert_allclose(before, after, rtol=1e-9, atol=1e-11)
    for c in left:
        assert np.array_equal(c.covariance, c.covariance.T)
        assert np.all(np.linalg.eigvalsh(c.covariance) > 0.0)


@pytest.mark.parametrize("cut", [-9.0, 0.0, 1.0])
def test_what_is_lost_is_no_more_than_is_affordable_for_each_merge(cut: float) -> None:
    """A row of members, of which those below `cut` have been ruled out: half-open knowledge."""
    whole = Component(0.0, np.zeros(1), np.eye(1))
    row = split(whole, 0, 0.3)
    for part in row:
        part.log_weight -= 3.0 * max(cut - part.mean[0], 0.0) ** 2
    left = reduced(row, (0,))
    assert len(left) < len(row)
    x = np.linspace(-7.0, 7.0, 20001)
    before, after = density(row, x), density(left, x)
    lost = float(np.trapezoid(before * np.log(before / after), x))
    assert 0.0 < lost < AFFORDABLE * (len(row) - len(left))


def test_negligible_members_are_dropped_and_the_best_is_never() -> None:
    unlikely = Component(-1000.0, MEAN, np.diag(DEVIATION**2))
    far = Component(-2000.0, MEAN + 10.0, np.diag(DEVIATION**2))
    (kept,) = reduced([unlikely, far], (0,))
    assert kept.log_weight == unlikely.log_weight
    np.testing.assert_array_equal(kept.mean, unlikely.mean)
    np.testing.assert_array_equal(kept.covariance, unlikely.covariance)
