"""What the monitor's smoother knows of rig runs, against the filter's estimates and the truth."""

import dataclasses
import math
from collections.abc import Iterable

import numpy as np
import pytest
from runs import assert_sound, scripted, within

from belt_ros.estimation import BeltEstimate, Measurement, Quantity, Rejection
from belt_ros.estimation.hindsight import HindsightEstimate, HindsightReader
from belt_ros.estimation.recent import RecentSteps
from belt_ros.settings import DriveSettings

DAY_NS = 86_400_000_000_000
QUANTITIES = [f.name for f in dataclasses.fields(HindsightEstimate) if f.type is Quantity]
SHORT = {"seed": 5, "sample_rate": 50.0, "duration": 3.0, "speed": [[0.0, 60.0], [0.5, 120.0]]}
LOADED = {
    **SHORT,
    "load": [[0.8, 0.0], [1.0, 45.0]],
    "condition__tension": 440.0,
    "condition__friction_stiffness": 6e6,
}


def hindsight(
    settings: DriveSettings, measurements: Iterable[Measurement]
) -> tuple[list[HindsightEstimate], list[BeltEstimate]]:
    """Smoothed estimates, oldest first, and the filtered ones of accepted measurements."""
    monitor = settings.monitor()
    reader = HindsightReader(settings.drive, settings.limits.standstill_speed)
    with monitor.smoother() as smoother:
        outputs = [monitor.step(measurement) for measurement in measurements]
        monitor.finish()
        found = [reader.read(smoothed) for smoothed in smoother.smoothed()]
        assert len(found) == smoother.beliefs
    filtered = [o.estimate for o in outputs if o.rejection is Rejection.NONE and o.estimate]
    return found[::-1], filtered


def later(measurements: list[Measurement], shift_ns: int) -> list[Measurement]:
    return [dataclasses.replace(m, stamp_ns=m.stamp_ns + shift_ns) for m in measurements]


@pytest.fixture(scope="module")
def loaded(settings: DriveSettings):
    """Measurements and truths of a run-up and 45 N m, three quarters of what the belt carries."""
    return list(scripted(settings, **LOADED))


@pytest.fixture(scope="module")
def seen(settings: DriveSettings, loaded):
    return hindsight(settings, [m for m, _ in loaded])


def test_every_number_is_sound(seen) -> None:
    for estimate in seen[0]:
        for name in QUANTITIES:
            value, stddev = getattr(estimate, name)
            assert math.isfinite(value)
            assert stddev >= 0.0
        assert 0.0 <= estimate.gross_slip_probability <= 1.0
        assert 0.0 <= estimate.changing_probability <= 1.0


def test_the_filter_is_the_same_to_the_last_bit_with_a_smoother_behind_it(
    settings: DriveSettings, loaded, seen
) -> None:
    monitor = settings.monitor()
    alone = [monitor.step(m).estimate for m, _ in loaded]
    assert alone == seen[1]
    for estimate in alone:
        assert estimate is not None
        assert_sound(estimate)


def test_at_the_end_hindsight_is_the_filters_own_belief(
    settings: DriveSettings, loaded, seen
) -> None:
    monitor = settings.monitor()
    for measurement, _ in loaded:
        monitor.step(measurement)
    monitor.finish()  # takes in what waits
    last, filtered = seen[0][-1], monitor.estimate
    assert filtered is not None
    assert last.stamp_ns == filtered.stamp_ns
    for name in QUANTITIES:
        value, stddev = getattr(filtered, name)
        within_rounding = 0.02 * stddev + 1e-9 * abs(value)
        assert getattr(last, name).value == pytest.approx(value, abs=within_rounding), name
        assert getattr(last, name).stddev == pytest.approx(stddev, rel=0.02, abs=1e-9), name
    assert last.gross_slip_probability == pytest.approx(filtered.gross_slip_probability, abs=1e-3)


def test_the_beginning_is_known_better_with_hindsight(seen, loaded) -> None:
    first, filtered, truth = seen[0][0], seen[1][0], loaded[0][1]
    assert first.stamp_ns == filtered.stamp_ns
    assert first.friction_stiffness_log_stddev < 0.7 * filtered.friction_stiffness_log_stddev
    assert first.margin.stddev < 0.7 * filtered.margin.stddev
    for name in ("mean_tension", "slip", "driver_speed", "ratio_bias"):
        assert within(getattr(first, name), getattr(truth, name), 3.0), name


def test_there_is_a_moment_in_each_half_second_and_each_is_a_measurements(seen, loaded) -> None:
    stamps = np.array([estimate.stamp_ns for estimate in seen[0]])
    assert np.max(np.diff(stamps // 500_000_000)) <= 1
    measured = np.array([m.stamp_ns for m, _ in loaded])
    apart = np.min(np.abs(np.subtract.outer(stamps, measured)), axis=1)
    assert np.max(apart) <= (measured[1] - measured[0]) // 2  # or between two, in a lull


def test_time_that_jumps_back_begins_a_life_of_its_own(
    settings: DriveSettings, loaded, seen
) -> None:
    """Two measurements are needed to believe the jump; what follows is as if they were the first.

    Not to the last bit: the filter's count of updates goes on over the jump.
    """
    once = [m for m, _ in loaded]
    both, filtered = hindsight(settings, [*once, *later(once, -DAY_NS)])
    assert filtered[-1].health.resets == 1
    before, after = both[: len(seen[0])], both[len(seen[0]) :]
    assert before == seen[0]
    alone, _ = hindsight(settings, later(once, -DAY_NS)[2:])
    assert [e.stamp_ns for e in after] == [e.stamp_ns for e in alone]
    for mine, theirs in zip(after, alone, strict=True):
        for name in ("mean_tension", "margin", "slip", "friction_stiffness"):
            value, stddev = getattr(theirs, name)
            assert getattr(mine, name).value == pytest.approx(value, abs=1e-3 * stddev)
            assert getattr(mine, name).stddev == pytest.approx(stddev, rel=1e-3)


def test_what_is_learned_after_a_gap_is_known_before_it(settings: DriveSettings, loaded) -> None:
    """The belt is the same after a minute without data; how it moved then says nothing of before.

    The first part is unloaded and teaches nothing.
    """
    idle = [m for m, _ in loaded if m.stamp_ns - loaded[0][0].stamp_ns < 700_000_000]
    rest = later([m for m, _ in loaded[len(idle) :]], 60_000_000_000)
    both, filtered = hindsight(settings, [*idle, *rest])
    blind = filtered[0].friction_stiffness_log_stddev
    assert both[0].friction_stiffness_log_stddev < 0.7 * blind
    stamps = [estimate.stamp_ns for estimate in both]
    assert stamps == sorted(stamps)
    for estimate in both[:2]:
        truth = next(t for m, t in loaded if m.stamp_ns == estimate.stamp_ns)
        for name in ("driver_speed", "slip", "transmitted_torque"):
            assert within(getattr(estimate, name), getattr(truth, name), 4.0), name


def test_monitor_that_heard_nothing_has_nothing_to_say(settings: DriveSettings) -> None:
    assert hindsight(settings, []) == ([], [])


def test_positions_that_come_back_do_not_bend_what_was_before(
    settings: DriveSettings, loaded
) -> None:
    def without(m: Measurement) -> Measurement:
        return dataclasses.replace(m, driver_position=math.nan, driven_position=math.nan)

    lost = [without(m) if 75 <= at < 80 else m for at, (m, _) in enumerate(loaded)]
    truths = {m.stamp_ns: truth for m, truth in loaded}
    for estimate in hindsight(settings, lost)[0]:
        truth = truths[estimate.stamp_ns]
        for name in ("driver_speed", "driven_speed", "slip"):
            assert within(getattr(estimate, name), getattr(truth, name), 4.0), name


class Heard:
    """A recorder that notes what it is told of changes of modes."""

    def __init__(self) -> None:
        self.switches: list[object] = []

    def switch(self, members: list[object], came_from: list[bool]) -> None:
        self.switches.append((members, came_from))


def test_a_change_of_modes_is_told_after_all_steps_have_become_final() -> None:
    recent = RecentSteps()
    recent.recorder = heard = Heard()
    recent.settle()
    recent.switch([], [])
    assert heard.switches == [([], [])]
