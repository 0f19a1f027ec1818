"""The pull between two states of a belt: as exact as a solution of its own, or not told."""

import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from moving_drive import TENSION, make_drive

from belt_ros.mechanics import Tensioning
from belt_ros.mechanics.between import pull_between
from belt_ros.mechanics.constants import DriveConstants, drive_constants
from belt_ros.mechanics.loaded_belt import UNKNOWN, Loaded, MountedBelt, belt_on_pulleys, loaded

C = drive_constants(make_drive())


def belt_of(
    log_stiffness: float = math.log(8.1e7), tension: float = TENSION, friction: float = 1.2
) -> MountedBelt:
    return belt_on_pulleys(C, tension, friction, math.exp(log_stiffness), 6.0, True)


def pull_where(
    belt: MountedBelt, at: float, apart: float, aside: float, weight: float = 1e-3
) -> tuple[float, Loaded]:
    """Pull at `aside` times the distance of two states, of which one has a part `at` of the limit.

    Also returns the state that is to be found.
    """
    one = loaded(C, belt, at * belt.limit, UNKNOWN)
    other = loaded(C, belt, one.traction + apart, UNKNOWN)
    found = loaded(C, belt, one.traction + aside * apart, UNKNOWN)
    load = weight * found.pull + found.slip
    return pull_between(C, belt, weight, load, one, other), found


@given(
    log_stiffness=st.floats(14.0, 21.0),
    tension=st.floats(50.0, 2000.0),
    friction=st.floats(0.2, 1.5),
    at=st.floats(0.0, 1.0),
    log_apart=st.floats(-7.0, -2.0),
    side=st.sampled_from([-1.0, 1.0]),
    aside=st.floats(-3.5, 3.5),
    log_weight=st.floats(-6.0, 0.0),
)
def test_what_two_states_tell_is_what_the_belt_does(
    log_stiffness: float,
    tension: float,
    friction: float,
    at: float,
    log_apart: float,
    side: float,
    aside: float,
    log_weight: float,
) -> None:
    belt = belt_of(log_stiffness, tension, friction)
    apart = side * 10.0**log_apart * (1.0 - at) * belt.limit
    pull, found = pull_where(belt, at, apart, aside, 10.0**log_weight)
    assert math.isnan(pull) or pull == pytest.approx(found.pull, rel=1e-10)


@pytest.mark.parametrize("at", [0.2, 0.5, 0.9])
@pytest.mark.parametrize("aside", [-2.0, -0.5, 0.3, 2.0])
@pytest.mark.parametrize("apart", [-1e-4, 1e-4])
def test_near_two_states_the_pull_is_told(at: float, aside: float, apart: float) -> None:
    pull, found = pull_where(belt_of(), at, apart, aside)
    assert pull == pytest.approx(found.pull, rel=1e-12)


@pytest.mark.parametrize(
    ("at", "apart", "aside"),
    [(0.5, 0.0, 1.0), (0.5, 1e-4, 10.0), (0.5, 0.1, 0.5), (0.992, 1e-7, 0.5)],
    ids=["one and the same", "far beside", "far apart", "near the limit"],
)
def test_elsewhere_it_is_not_told(at: float, apart: float, aside: float) -> None:
    pull, _ = pull_where(belt_of(), at, apart, aside)
    assert math.isnan(pull)


def test_it_is_not_told_across_the_load_at_which_an_arc_begins_to_slide() -> None:
    belt = belt_of()
    begin = belt.receiving.shape.elastic_limit / belt.limit
    assert begin > belt.giving.shape.elastic_limit / belt.limit
    pull, _ = pull_where(belt, begin, 1e-5, 0.5)
    assert math.isnan(pull)
    pull, found = pull_where(belt, 1.001 * begin, 1e-6, 0.5)
    assert pull == pytest.approx(found.pull, rel=1e-12)


def test_between_fixed_centres_it_is_not_told() -> None:
    c: DriveConstants = drive_constants(
        dataclasses.replace(make_drive(), tensioning=Tensioning.FIXED_CENTRES)
    )
    belt = belt_on_pulleys(c, TENSION, 1.2, 8.1e7, 6.0, True)
    one, other = (loaded(c, belt, at * belt.limit, UNKNOWN) for at in (0.5, 0.50001))
    assert math.isnan(pull_between(c, belt, 1e-3, 1e-3 * one.pull + one.slip, one, other))
