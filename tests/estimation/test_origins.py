import numpy as np
import pytest

from belt_ros.estimation.gaussian_sum import Component, mixture_moments, normalised
from belt_ros.estimation.origins import Origins, origins_of, traced

AXIS = 1
COVARIANCE = np.array([[4.0, 0.6], [0.6, 0.25]])


def member(weight: float, place: float, deviation: float, changing: bool) -> Component:
    covariance = COVARIANCE * (deviation / 0.5) ** 2
    return Component(np.log(weight), np.array([7.0, place]), covariance, changing)


def test_origins_are_the_moments_of_the_members_that_came_the_same_way() -> None:
    members = [
        member(0.5, 1.0, 0.1, changing=False),
        member(0.2, 3.0, 0.2, changing=False),
        member(0.3, 5.0, 0.3, changing=True),
    ]
    origins = origins_of(members, [False, False, False], AXIS)
    np.testing.assert_allclose(origins.share, [[0.7, 0.3], [0.0, 0.0]], rtol=1e-12)
    mean = (0.5 * 1.0 + 0.2 * 3.0) / 0.7
    variance = (0.5 * (0.01 + 1.0) + 0.2 * (0.04 + 9.0)) / 0.7 - mean**2
    np.testing.assert_allclose(origins.mean[0], [mean, 5.0], rtol=1e-12)
    np.testing.assert_allclose(origins.variance[0], [variance, 0.09], rtol=1e-12)


def test_a_member_with_one_possible_origin_only_changes_its_mode() -> None:
    origins = origins_of([member(1.0, 0.0, 1.0, changing=True)], [False], AXIS)
    (part,) = traced([member(0.4, 0.3, 0.5, changing=True)], origins, AXIS)
    assert not part.changing
    assert part.log_weight == pytest.approx(np.log(0.4), abs=1e-12)
    np.testing.assert_allclose(part.mean, [7.0, 0.3], atol=1e-12)
    np.testing.assert_allclose(part.covariance, COVARIANCE, rtol=1e-12)


def test_a_member_nobody_is_known_to_come_from_stays() -> None:
    whole = member(1.0, 0.0, 0.5, changing=True)
    origins = origins_of([member(1.0, 0.0, 1.0, changing=False)], [False], AXIS)
    assert traced([whole], origins, AXIS) == [whole]


def test_where_nothing_is_learned_later_the_parts_are_the_origins() -> None:
    """The belief of both together, traced back, is what came from either."""
    members = [
        member(0.2, 0.0, 0.05, changing=True),
        member(0.3, 0.4, 0.5, changing=True),
    ]
    origins = origins_of(members, [False, True], AXIS)
    share = np.array([0.4, 0.6])
    mean, covariance = mixture_moments(
        share, np.stack([m.mean for m in members]), np.stack([m.covariance for m in members])
    )
    whole = Component(0.0, mean, covariance, changing=True)
    parts = traced([whole], origins, AXIS)
    assert [part.changing for part in parts] == [False, True]
    weights = normalised(np.array([part.log_weight for part in parts]))
    np.testing.assert_allclose(weights, share, atol=1e-3)
    for part, expected in zip(parts, members, strict=True):
        assert part.mean[AXIS] == pytest.approx(expected.mean[AXIS], abs=1e-3)
        assert part.covariance[AXIS, AXIS] == pytest.approx(
            expected.covariance[AXIS, AXIS], rel=0.01
        )
        assert np.all(np.linalg.eigvalsh(part.covariance) > 0.0)


@pytest.mark.parametrize("place", [0.3, 3.0, 300.0])
def test_a_tension_that_the_settled_part_rules_out_was_changing(place: float) -> None:
    origins = Origins(
        np.array([[0.0, 0.9], [0.0, 0.1]]),
        np.zeros((2, 2)),
        np.array([[1.0, 0.01**2], [1.0, 0.5**2]]),
    )
    parts = traced([member(1.0, place, 0.02, changing=True)], origins, AXIS)
    weights = normalised(np.array([part.log_weight for part in parts]))
    assert sum(w for w, part in zip(weights, parts, strict=True) if part.changing) > 0.999
    assert np.logaddexp.reduce([p.log_weight for p in parts]) == pytest.approx(0.0, abs=1e-9)
