import numpy as np
import pytest

from belt_ros.estimation.gaussian_sum import Component, grid, mixture_moments, normalised, reduced

MEAN = np.array([1.0, -2.0, 0.5])
DEVIATION = np.array([0.3, 2.0, 0.1])


def moments(components: list[Component]) -> tuple[np.ndarray, np.ndarray]:
    return mixture_moments(
        normalised(np.array([c.log_weight for c in components])),
        np.stack([c.mean for c in components]),
        np.stack([c.covariance for c in components]),
    )


def test_a_grid_has_the_mean_and_nearly_the_spread_of_what_it_covers() -> None:
    mean, covariance = moments(grid(MEAN, DEVIATION, (0, 1), (7, 5), (0.6, 0.6)))
    np.testing.assert_allclose(mean, MEAN, atol=1e-12)
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), DEVIATION, rtol=0.04)


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


def test_negligible_members_are_dropped_and_the_best_is_never() -> None:
    unlikely = Component(-1000.0, MEAN, np.diag(DEVIATION**2))
    far = Component(-2000.0, MEAN + 10.0, np.diag(DEVIATION**2))
    kept = reduced([unlikely, far], (0,))
    assert kept == [unlikely]


def test_weights_from_any_logarithms_sum_to_one() -> None:
    weights = normalised(np.array([-1e6, -1e6 - 1.0, -np.inf]))
    assert weights.sum() == pytest.approx(1.0)
    assert weights[2] == 0.0
