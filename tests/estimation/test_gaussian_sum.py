import numpy as np
import pytest
from sums import moments

from belt_ros.estimation.gaussian_sum import (
    Component,
    normalised,
    split,
)

MEAN = np.array([1.0, -2.0, 0.5])
DEVIATION = np.array([0.3, 2.0, 0.1])


@pytest.mark.parametrize(("ratio", "parts"), [(0.45, 9), (0.6, 5), (0.9, 3)])
@pytest.mark.parametrize("axis", [0, 1])
def test_the_parts_of_a_split_add_up_to_the_whole(ratio: float, parts: int, axis: int) -> None:
    covariance = np.diag(DEVIATION**2)
    covariance[0, 1] = covariance[1, 0] = 0.7 * DEVIATION[0] * DEVIATION[1]
    whole = Component(-3.0, MEAN, covariance, changing=True)
    row = split(whole, axis, ratio)
    assert len(row) == parts
    assert all(part.changing for part in row)
    for before, after in zip(moments([whole]), moments(row), strict=True):
        np.testing.assert_allclose(after, before, rtol=1e-12, atol=1e-15)
    assert np.logaddexp.reduce([part.log_weight for part in row]) == pytest.approx(-3.0)
    for part in row:
        assert np.sqrt(part.covariance[axis, axis]) == pytest.approx(
            ratio * DEVIATION[axis], rel=0.08
        )
        assert np.all(np.linalg.eigvalsh(part.covariance) > 0.0)


def test_the_parts_of_a_split_look_like_the_whole() -> None:
    whole = Component(0.0, np.zeros(1), np.eye(1))
    x = np.linspace(-2.0, 2.0, 81)
    density = sum(
        np.exp(part.log_weight - 0.5 * (x - part.mean[0]) ** 2 / part.covariance[0, 0])
        / np.sqrt(2.0 * np.pi * part.covariance[0, 0])
        for part in split(whole, 0, 0.45)
    )
    normal = np.exp(-0.5 * x**2) / np.sqrt(2.0 * np.pi)
    np.testing.assert_allclose(density, normal, rtol=0.03)


def test_weights_from_any_logarithms_sum_to_one() -> None:
    weights = normalised(np.array([-1e6, -1e6 - 1.0, -np.inf]))
    assert weights.sum() == pytest.approx(1.0)
    assert weights[2] == 0.0
