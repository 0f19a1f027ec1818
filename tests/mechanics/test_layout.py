"""Where the belt runs, against formulas, the convex hull and a curve traced point by point."""

import math
from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from layouts import ring_discs, serpentines
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from belt_ros.mechanics import Belt, DriveError, Kinematics, Tensioning
from belt_ros.mechanics.layout import Disc, Layout, Side, crossed_drive, open_drive, trace

REPEATABLE = settings(derandomize=True, deadline=None, max_examples=200)
BELT = Belt(80068.0, 0.1)
CW = Side.CLOCKWISE


def curve(layout: Layout, points: int = 2000) -> NDArray[np.float64]:
    """Points along the belt: round each disc by its wrap, then straight to the next."""
    pieces = []
    for i, disc in enumerate(layout.discs):
        x, y = layout.end[i - 1] - (disc.x, disc.y)
        turn = disc.side * np.linspace(0.0, layout.wrap_angle[i], points)
        pieces.append(
            np.stack(
                [
                    disc.x + x * np.cos(turn) - y * np.sin(turn),
                    disc.y + x * np.sin(turn) + y * np.cos(turn),
                ],
                axis=-1,
            )
        )
    return np.concatenate(pieces)


def perimeter(points: NDArray[np.float64]) -> float:
    return float(np.sum(np.hypot(*(np.roll(points, -1, axis=0) - points).T)))


def turning(points: NDArray[np.float64]) -> float:
    step = np.roll(points, -1, axis=0) - points
    step = step[np.hypot(*step.T) > 1e-12]
    angle = np.arctan2(step[:, 1], step[:, 0])
    change = np.roll(angle, -1) - angle
    return float(np.sum((change + math.pi) % (2.0 * math.pi) - math.pi))


def overlapping(discs: list[Disc]) -> bool:
    return any(
        math.hypot(a.x - b.x, a.y - b.y) <= a.radius + b.radius for a, b in combinations(discs, 2)
    )


# --- Two pulleys ------------------------------------------------------------------------------

sizes = st.tuples(st.floats(0.02, 0.5), st.floats(0.02, 0.5), st.floats(1.01, 20.0))


@given(sizes)
@REPEATABLE
def test_open_belt_has_the_length_of_the_formula(size: tuple[float, float, float]) -> None:
    r1, r2, apart = size
    distance = apart * (r1 + r2)
    lean = math.asin((r1 - r2) / distance)
    layout = trace([Disc(0.0, 0.0, r1), Disc(distance, 0.0, r2)])
    np.testing.assert_allclose(
        layout.wrap_angle, [math.pi + 2 * lean, math.pi - 2 * lean], rtol=1e-13
    )
    length = (
        2.0 * math.sqrt(distance**2 - (r1 - r2) ** 2) + math.pi * (r1 + r2) + 2.0 * lean * (r1 - r2)
    )
    assert layout.path_length == pytest.approx(length, rel=1e-14)


@given(sizes)
@REPEATABLE
def test_crossed_belt_has_the_length_of_the_formula(size: tuple[float, float, float]) -> None:
    r1, r2, apart = size
    distance = apart * (r1 + r2)
    wrap = math.pi + 2.0 * math.asin((r1 + r2) / distance)
    layout = trace([Disc(0.0, 0.0, r1), Disc(distance, 0.0, r2, CW)], crossed=True)
    np.testing.assert_allclose(layout.wrap_angle, [wrap, wrap], rtol=1e-13)
    length = 2.0 * math.sqrt(distance**2 - (r1 + r2) ** 2) + wrap * (r1 + r2)
    assert layout.path_length == pytest.approx(length, rel=1e-14)
    assert layout.turning == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize("build", [open_drive, crossed_drive])
def test_a_drive_takes_wraps_and_span_from_its_layout(build: type) -> None:
    r1, r2, distance = 0.15, 0.05, 0.4
    drive = build(
        BELT, r1, r2, distance, 0.6, 1e8,
        kinematics=Kinematics.LINEAR, tensioning=Tensioning.CONSTANT_SLACK,
    )  # fmt: skip
    reach = r1 - r2 if build is open_drive else r1 + r2
    turn = 2.0 * math.asin(reach / distance)
    assert drive.belt == BELT
    assert drive.driven.wrap_angle == pytest.approx(math.pi + turn, rel=1e-14)
    other = -turn if build is open_drive else turn
    assert drive.driver.wrap_angle == pytest.approx(math.pi + other, rel=1e-14)
    assert drive.span_length == pytest.approx(math.sqrt(distance**2 - reach**2), rel=1e-14)
    assert (drive.driven.radius, drive.driver.radius) == (r1, r2)
    for pulley in (drive.driven, drive.driver):
        assert (pulley.friction_coefficient, pulley.friction_stiffness) == (0.6, 1e8)
    assert drive.kinematics is Kinematics.LINEAR
    assert drive.tensioning is Tensioning.CONSTANT_SLACK


@pytest.mark.parametrize("build", [open_drive, crossed_drive])
def test_a_drive_whose_pulleys_overlap_is_refused(build: type) -> None:
    message = r"^pulleys 0 and 1 overlap: .* 0\.19 m apart, not more than .* together, 0\.2 m$"
    with pytest.raises(DriveError, match=message):
        build(BELT, 0.15, 0.05, 0.19, 0.6, 1e8)


# --- Any number -------------------------------------------------------------------------------


@given(ring_discs())
@REPEATABLE
def test_pulleys_inside_the_loop_are_wrapped_by_their_convex_hull(discs: list[Disc]) -> None:
    turn = np.linspace(0.0, 2.0 * math.pi, 4000, endpoint=False)
    circles = np.concatenate(
        [
            np.stack([d.x + d.radius * np.cos(turn), d.y + d.radius * np.sin(turn)], -1)
            for d in discs
        ]
    )
    hull = ConvexHull(circles)
    touched = np.bincount(hull.vertices // turn.size, minlength=len(discs))
    if np.any(touched == 0):
        with pytest.raises(
            DriveError, match=r"would not touch pulley|overlap|crosses pulley|cross:"
        ):
            trace(discs)
        return
    assume(not overlapping(discs))
    layout = trace(discs)
    assert layout.path_length == pytest.approx(hull.area, rel=1e-5)
    # Each disc's wrap holds that share of its circle's points, but for its ends.
    np.testing.assert_allclose(layout.wrap_angle, touched * turn[1], atol=3.0 * turn[1])


@given(serpentines())
@REPEATABLE
def test_the_belt_is_a_smooth_closed_curve_that_turns_once(layout: Layout) -> None:
    count = len(layout.discs)
    for i, disc in enumerate(layout.discs):
        following = layout.discs[(i + 1) % count]
        leaves = layout.begin[i] - (disc.x, disc.y)
        meets = layout.end[i] - (following.x, following.y)
        assert np.hypot(*leaves) == pytest.approx(disc.radius, rel=1e-12)
        assert np.hypot(*meets) == pytest.approx(following.radius, rel=1e-12)
        x, y = layout.direction[i]
        # The rim moves along the span at either end.
        np.testing.assert_allclose(
            disc.side * np.array([-leaves[1], leaves[0]]) / disc.radius, [x, y], atol=1e-12
        )
        np.testing.assert_allclose(
            following.side * np.array([-meets[1], meets[0]]) / following.radius, [x, y], atol=1e-12
        )
        np.testing.assert_allclose(
            layout.end[i] - layout.begin[i], layout.span_length[i] * layout.direction[i], atol=1e-12
        )
    assert layout.turning == pytest.approx(2.0 * math.pi, rel=1e-13)
    points = curve(layout)
    assert turning(points) == pytest.approx(2.0 * math.pi, rel=1e-9)
    assert perimeter(points) == pytest.approx(layout.path_length, rel=1e-6)


def test_the_random_layouts_are_serpentine() -> None:
    seen = set()

    @given(serpentines())
    @REPEATABLE
    def collect(layout: Layout) -> None:
        seen.add((len(layout.discs), any(disc.side is CW for disc in layout.discs)))

    collect()
    assert {(n, True) for n in (3, 4, 5, 6)} <= seen


def test_a_crossed_belt_may_run_round_more_than_two_pulleys() -> None:
    discs = [Disc(0.0, 0.0, 0.2), Disc(2.0, 0.3, 0.1, CW), Disc(2.0, -0.3, 0.1, CW)]
    layout = trace(discs, crossed=True)
    assert layout.turning == pytest.approx(0.0, abs=1e-13)
    assert turning(curve(layout)) == pytest.approx(0.0, abs=1e-9)
    assert perimeter(curve(layout)) == pytest.approx(layout.path_length, rel=1e-6)


@given(serpentines(), st.integers(1, 5))
@REPEATABLE
def test_the_starting_pulley_does_not_matter(layout: Layout, shift: int) -> None:
    shift %= len(layout.discs)
    again = trace(layout.discs[shift:] + layout.discs[:shift])
    np.testing.assert_array_equal(again.wrap_angle, np.roll(layout.wrap_angle, -shift))
    np.testing.assert_array_equal(again.span_length, np.roll(layout.span_length, -shift))


@given(serpentines())
@REPEATABLE
def test_mirrored_and_reversed_layouts_have_the_same_wraps_and_spans(layout: Layout) -> None:
    mirrored = trace([replace(d, y=-d.y, side=Side(-d.side)) for d in layout.discs])
    np.testing.assert_allclose(mirrored.wrap_angle, layout.wrap_angle, rtol=1e-12)
    np.testing.assert_allclose(mirrored.span_length, layout.span_length, rtol=1e-13)
    assert mirrored.turning == pytest.approx(-2.0 * math.pi, rel=1e-13)
    back = trace([replace(d, side=Side(-d.side)) for d in reversed(layout.discs)])
    np.testing.assert_allclose(back.wrap_angle, layout.wrap_angle[::-1], rtol=1e-12)
    np.testing.assert_allclose(back.span_length, np.roll(layout.span_length[::-1], -1), rtol=1e-13)


@given(serpentines(), st.floats(-3.0, 3.0), st.floats(0.1, 10.0))
@REPEATABLE
def test_turned_and_scaled_layouts_have_the_same_wraps(
    layout: Layout, turn: float, scale: float
) -> None:
    cos, sin = scale * math.cos(turn), scale * math.sin(turn)
    moved = trace(
        [
            Disc(0.3 + cos * d.x - sin * d.y, sin * d.x + cos * d.y, scale * d.radius, d.side)
            for d in layout.discs
        ]
    )
    np.testing.assert_allclose(moved.wrap_angle, layout.wrap_angle, atol=1e-11)
    assert moved.path_length == pytest.approx(scale * layout.path_length, rel=1e-12)


@given(serpentines(), st.floats(0.0, 10.0), st.floats(0.0, 10.0), st.floats(-3.0, 3.0))
@REPEATABLE
def test_hub_angle_gives_the_force_along_a_direction(
    layout: Layout, arriving: float, leaving: float, direction: float
) -> None:
    along = np.array([math.cos(direction), math.sin(direction)])
    for i, wrap in enumerate(layout.wrap_angle):
        force = leaving * layout.direction[i] - arriving * layout.direction[i - 1]
        angle = layout.hub_angle(i, direction)
        expected = arriving * math.sin(0.5 * wrap - angle) + leaving * math.sin(0.5 * wrap + angle)
        assert force @ along == pytest.approx(expected, abs=1e-12)


# --- Refusals ---------------------------------------------------------------------------------

TRIANGLE = [Disc(0.0, 0.0, 0.1), Disc(1.0, 0.0, 0.1), Disc(0.5, 1.0, 0.1)]


@pytest.mark.parametrize("count", [0, 1])
def test_fewer_than_two_pulleys_are_refused(count: int) -> None:
    with pytest.raises(DriveError, match=rf"^the belt runs on {count} pulleys; it needs at least"):
        trace(TRIANGLE[:count])


def test_overlapping_pulleys_are_refused_even_if_the_belt_does_not_pass_between_them() -> None:
    discs = [*TRIANGLE[:2], Disc(1.0, 1.0, 0.1), Disc(0.15, 0.1, 0.1), Disc(0.0, 1.0, 0.1)]
    with pytest.raises(DriveError, match=r"^pulleys 0 and 3 overlap: .* 0\.180278 m .* 0\.2 m$"):
        trace(discs)


def test_touching_pulleys_are_refused() -> None:
    with pytest.raises(DriveError, match="overlap"):
        trace([Disc(0.0, 0.0, 0.25), Disc(0.5, 0.0, 0.25)])


@pytest.mark.parametrize("height", [0.21, 0.26, 0.5])
def test_a_pulley_that_the_belt_would_not_touch_is_refused(height: float) -> None:
    idler = Disc(0.5, -height, 0.1, CW)
    wrap = 2.0 * (math.asin(0.2 / math.hypot(0.5, height)) - math.atan(height / 0.5))
    message = rf"^the belt would not touch pulley 1: its wrap would be {wrap:g} rad and must be > 0"
    with pytest.raises(DriveError, match=message):
        trace([TRIANGLE[0], idler, *TRIANGLE[1:]])


def test_a_pulley_inside_that_the_belt_passes_by_is_refused() -> None:
    with pytest.raises(DriveError, match="would not touch pulley 1: its wrap would be -0"):
        trace([TRIANGLE[0], Disc(0.5, 0.2, 0.1), *TRIANGLE[1:]])


def test_a_pulley_that_the_belt_only_grazes_is_refused() -> None:
    with pytest.raises(DriveError, match="would not touch pulley 1: its wrap would be"):
        trace([TRIANGLE[0], Disc(0.5, 0.0, 0.1), *TRIANGLE[1:]])


def test_a_span_through_a_pulley_it_does_not_run_on_is_refused() -> None:
    message = (
        r"^the span from pulley 0 to 1 crosses pulley 3: it passes its centre at 0\.05 m, less "
        r"than its radius of 0\.1 m; change the order or a side$"
    )
    with pytest.raises(DriveError, match=message):
        trace([*TRIANGLE, Disc(0.5, -0.05, 0.1)])


def test_a_span_may_pass_a_pulley_as_closely_as_it_likes() -> None:
    def idler(clearance: float) -> Disc:
        """Pressed in from the left, down to the lower span."""
        return Disc(0.3, clearance, 0.1, CW)

    assert trace([*TRIANGLE, idler(1e-9)]).turning == pytest.approx(2.0 * math.pi)
    with pytest.raises(DriveError, match="the span from pulley 0 to 1 crosses pulley 3"):
        trace([*TRIANGLE, idler(-1e-9)])


def test_a_crossing_that_was_not_meant_is_refused() -> None:
    with pytest.raises(DriveError, match=r"^the spans that leave pulleys 0 and 1 cross: check"):
        trace([Disc(0.0, 0.0, 0.1), Disc(1.0, 0.0, 0.1, CW)])
    square = [Disc(x, y, 0.1) for x, y in ((0, 0), (1, 1), (1, 0), (0, 1))]
    bow = [square[0], replace(square[1], side=CW), replace(square[2], side=CW), square[3]]
    with pytest.raises(DriveError, match=r"^the spans that leave pulleys 0 and 2 cross: check"):
        trace(bow)
    assert trace(bow, crossed=True).turning == pytest.approx(0.0, abs=1e-13)


def test_a_belt_said_to_be_crossed_must_cross_itself_once() -> None:
    message = r"^the belt crosses itself 0 times and turns by 6\.28319 rad; a crossed belt does"
    with pytest.raises(DriveError, match=message):
        trace(TRIANGLE, crossed=True)
    with pytest.raises(DriveError, match=r"^the belt crosses itself 1 times and turns by 12"):
        trace([TRIANGLE[0], Disc(0.5, 0.2, 0.1), *TRIANGLE[1:]], crossed=True)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_disc_that_is_not_finite_is_refused(bad: float) -> None:
    with pytest.raises(DriveError, match=r"^pulley centre is \(.*\) m; it must be finite$"):
        Disc(bad, 0.0, 0.1)
    with pytest.raises(DriveError, match=r"^pulley centre is \(.*\) m; it must be finite$"):
        Disc(0.0, bad, 0.1)
    with pytest.raises(DriveError, match=r"^pulley radius is"):
        Disc(0.0, 0.0, bad)


@pytest.mark.parametrize("bad", [0.0, -0.1])
def test_a_disc_without_radius_is_refused(bad: float) -> None:
    with pytest.raises(DriveError, match=r"^pulley radius is"):
        Disc(0.0, 0.0, bad)


def test_wraps_change_continuously_as_a_pulley_moves() -> None:
    wraps = [
        trace([TRIANGLE[0], Disc(0.5, y, 0.1, CW), *TRIANGLE[1:]]).wrap_angle
        for y in np.linspace(-0.19, 0.3, 200)
    ]
    assert max(np.max(np.abs(b - a)) for a, b in pairwise(wraps)) < 0.02
