"""Rim travel from angles that do not come at once."""

import math

import pytest

from belt_ros.estimation.travel import Travel
from belt_ros.mechanics import Belt, BeltDrive, Pulley
from belt_ros.mechanics.constants import drive_constants

TURN = 2.0 * math.pi
CONSTANTS = drive_constants(
    BeltDrive(
        Belt(80e3, 0.1), Pulley(0.08, 3.3, 0.8, 1e7, 0.05), Pulley(0.05, 2.9, 0.8, 1e7, 0.05), 0.5
    )
)
SPEEDS = (400.0, 240.0)  # [rad/s]; the driver's rim is 0.8 m/s faster
AHEAD = 0.05 * SPEEDS[0] - 0.08 * SPEEDS[1]
NOTHING = (math.nan, math.nan)


def angles(time: float) -> tuple[float, float]:
    """As encoders report them, within a turn."""
    return (SPEEDS[0] * time) % TURN, (SPEEDS[1] * time + 1.0) % TURN


def told(pattern: list[tuple[bool, bool]], dt: float) -> list[tuple[float, float]]:
    """Times and travel told, where speed and angle of either pulley come as the pattern says."""
    travel, out = Travel(CONSTANTS, (TURN, TURN)), []
    for k, there in enumerate(pattern):
        now = angles(k * dt)
        speeds = tuple(v if here else math.nan for v, here in zip(SPEEDS, there, strict=True))
        positions = tuple(a if here else math.nan for a, here in zip(now, there, strict=True))
        ahead = travel.ahead(speeds, positions, dt)
        if not math.isnan(ahead):
            out.append((k * dt, ahead))
    return out


@pytest.mark.parametrize(
    ("pattern", "dt", "first", "count"),
    [
        ([(True, False), (False, True)] * 100, 0.005, 0.005, 99),
        (([(True, False)] * 9 + [(True, True)]) * 10, 0.001, 0.009, 9),
        (([(True, False)] * 4 + [(False, True)] + [(True, False)] * 5) * 10, 0.001, 0.004, 9),
        ([(True, True), (False, False)] * 30, 0.01, 0.0, 29),
    ],
    ids=["in turns", "one seldom", "one seldom, apart", "both, with nothing between"],
)
def test_travel_is_counted_from_angles_that_come_apart(
    pattern: list[tuple[bool, bool]], dt: float, first: float, count: int
) -> None:
    seen = told(pattern, dt)
    assert len(seen) == count  # each reading of the rarer one counts once, but for the first
    for time, ahead in seen:
        assert ahead == pytest.approx(AHEAD * (time - first), abs=1e-9)


def test_angles_too_far_apart_in_time_tell_nothing() -> None:
    assert told([(True, False), (False, True)] * 20, 0.02) == []


def test_a_silent_encoder_ends_the_count_and_begins_another() -> None:
    travel = Travel(CONSTANTS, (TURN, TURN))
    for k in range(3):
        travel.ahead(SPEEDS, angles(0.01 * k), 0.01)
    assert travel.counts
    for k in range(3, 14):
        assert math.isnan(travel.ahead(SPEEDS, (angles(0.01 * k)[0], math.nan), 0.01))
    assert not travel.counts
    assert math.isnan(travel.ahead(SPEEDS, angles(0.14), 0.01))
    assert travel.ahead(SPEEDS, angles(0.15), 0.01) == pytest.approx(0.01 * AHEAD, abs=1e-9)


def test_without_any_speed_angles_cannot_be_unwrapped() -> None:
    travel = Travel(CONSTANTS, (TURN, TURN))
    for k in range(5):
        assert math.isnan(travel.ahead(NOTHING, angles(0.01 * k), 0.01))
    assert not travel.counts
