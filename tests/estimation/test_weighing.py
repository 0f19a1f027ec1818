"""Members are compared by what each has foretold, a change of the torques told."""

import numpy as np
import pytest

from belt_ros.estimation.state import STATES, Index
from belt_ros.estimation.weighing import innovations_squared

SPEEDS = [Index.DRIVER_SPEED, Index.DRIVEN_SPEED]
TORQUES = [Index.DRIVER_TORQUE, Index.DRIVEN_TORQUE]
NOISE = {**dict.fromkeys(SPEEDS, 0.02), **dict.fromkeys(TORQUES, 0.2)}
WANDER = 3.0  # of the torques in a step [N m]
SLIPS = 0.5  # how much faster the driver of a belt that slips becomes [rad/s] by 1 N m
HOLDS = 0.001


def members(*slopes: float) -> tuple[np.ndarray, np.ndarray]:
    """Members in which driver torque speeds up the driver by these slopes."""
    covariance = np.empty((len(slopes), STATES, STATES))
    for each, slope in zip(covariance, slopes, strict=True):
        each[:] = 1e-4 * np.eye(STATES)
        each[TORQUES, TORQUES] = WANDER**2
        each[Index.DRIVER_SPEED, Index.DRIVER_SPEED] += (slope * WANDER) ** 2
        crossed = slope * WANDER**2
        each[Index.DRIVER_SPEED, Index.DRIVER_TORQUE] = crossed
        each[Index.DRIVER_TORQUE, Index.DRIVER_SPEED] = crossed
    return np.zeros((len(slopes), STATES)), covariance


def squared(
    weights: list[float], slopes: list[float], seen: dict[Index, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Innovations of members, and what they are by the covariance of the sum alone."""
    x, covariance = members(*slopes)
    places = np.array(sorted(seen), dtype=np.int64)
    z = np.array([seen[Index(place)] for place in places])
    variance = np.array([NOISE[Index(place)] ** 2 for place in places])
    found, _ = innovations_squared(x, covariance, np.array(weights), z, variance, places)
    pooled = np.tensordot(weights, covariance, 1)[np.ix_(places, places)] + np.diag(variance)
    return found, np.full(len(slopes), z @ np.linalg.solve(pooled, z))


def test_a_belt_that_rightly_holds_is_not_ruled_out_by_those_that_slip() -> None:
    """However heavy these are: by the covariance of the sum both would have been as wrong."""
    read = {Index.DRIVER_SPEED: 0.0, Index.DRIVER_TORQUE: 6.0, Index.DRIVEN_TORQUE: -6.0}
    (holds, slips), (pooled, _) = squared([1e-3, 1.0 - 1e-3], [HOLDS, SLIPS], read)
    assert pooled > 100.0
    assert slips == pytest.approx(pooled, rel=0.01)
    assert holds < 0.1 * slips


def test_a_belt_that_slips_as_it_should_is_not_ruled_out_by_those_that_hold() -> None:
    read = {Index.DRIVER_SPEED: 3.0, Index.DRIVER_TORQUE: 6.0}
    (holds, slips), _ = squared([1.0 - 1e-3, 1e-3], [HOLDS, SLIPS], read)
    assert slips < 0.1 * holds


@pytest.mark.parametrize("torque", [-0.6, 0.3, 0.6])
def test_what_noise_may_explain_of_a_torque_does_not_tell_belts_apart(torque: float) -> None:
    read = {Index.DRIVER_SPEED: 0.1, Index.DRIVEN_SPEED: 0.05, Index.DRIVER_TORQUE: torque}
    found, pooled = squared([0.5, 0.5], [HOLDS, SLIPS], read)
    np.testing.assert_allclose(found, pooled, rtol=1e-9)


@pytest.mark.parametrize("torques", [(5.0, -4.0), (5.0, None), (None, 5.0), (None, None)])
def test_a_single_member_is_judged_by_its_own_covariance(
    torques: tuple[float | None, float | None],
) -> None:
    told = dict(zip(TORQUES, torques, strict=True))
    read = {Index.DRIVER_SPEED: 1.0, Index.DRIVEN_SPEED: 0.1}
    read |= {place: torque for place, torque in told.items() if torque is not None}
    found, pooled = squared([1.0], [0.2], read)
    np.testing.assert_allclose(found, pooled, rtol=1e-9)


def test_nothing_read_tells_nothing() -> None:
    x, covariance = members(HOLDS, SLIPS)
    nothing, nowhere = np.zeros(0), np.zeros(0, dtype=np.int64)
    found, surprises = innovations_squared(
        x, covariance, np.array([0.5, 0.5]), nothing, nothing, nowhere
    )
    assert found.tolist() == [0.0, 0.0]
    assert surprises.size == 0
