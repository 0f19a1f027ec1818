"""Time in which nothing was measured, told by whoever has a clock."""

import dataclasses

import numpy as np
import pytest
from runs import assert_sound

from belt_ros.estimation import BeltMonitor, Maintenance, MaintenanceKind, Measurement, Rejection
from belt_ros.settings import DriveSettings

STEP_NS = 10_000_000
DAY = 86400.0  # [s]
SET = Maintenance(MaintenanceKind.RETENSIONED, 300.0, 5.0)


def run(monitor: BeltMonitor, count: int, start_ns: int = 0) -> None:
    """Turn at no load."""
    random = np.random.default_rng(4)
    for k in range(count):
        a, b, c, d = random.normal(size=4).tolist()
        stamp_ns = start_ns + k * STEP_NS
        monitor.step(
            Measurement(stamp_ns, 120.0 + 0.01 * a, 120.0 + 0.01 * b, 1.0 + 0.3 * c, -1.0 + 0.3 * d)
        )


@pytest.fixture
def taught(settings: DriveSettings) -> BeltMonitor:
    monitor = settings.monitor()
    run(monitor, 300)
    return monitor


def tension_after(monitor: BeltMonitor, stamp_ns: int) -> tuple[float, float]:
    run(monitor, 100, stamp_ns)
    assert monitor.estimate is not None
    assert_sound(monitor.estimate)
    return monitor.estimate.mean_tension


@pytest.mark.parametrize("days", [0.01, 3.0, 300.0])
def test_a_tension_set_after_a_stop_is_not_forgotten_by_the_stop(
    taught: BeltMonitor, days: float
) -> None:
    taught.rest(days * DAY)
    taught.maintain(SET)
    tension = tension_after(taught, round((days * DAY + 3.0) * 1e9))
    assert tension.value == pytest.approx(300.0, abs=10.0)
    assert tension.stddev < 15.0


def test_a_stop_after_a_tension_was_set_ages_it(taught: BeltMonitor) -> None:
    taught.rest(DAY)
    taught.maintain(SET)
    tension = tension_after(taught, round(11.0 * DAY * 1e9))
    assert tension.stddev > 20.0


def test_rest_and_gap_age_no_more_than_they_last_together(settings: DriveSettings) -> None:
    """Stamps that go on after less than the rest, as simulated time does, are believed too."""
    stddevs = []
    for rest in (0.0, 0.5 * DAY, DAY):
        monitor = settings.monitor()
        monitor.maintain(SET)
        run(monitor, 300)
        monitor.rest(rest)
        stddevs.append(tension_after(monitor, round(DAY * 1e9)).stddev)
    assert max(stddevs) < 2.0 * min(stddevs)
    monitor.rest(DAY)
    run(monitor, 1, round((DAY + 1.5) * 1e9))
    assert monitor.health.last_rejection is Rejection.OUT_OF_ORDER
    assert monitor.health.resets == 0


def test_what_was_restored_ages_until_it_is_used(settings: DriveSettings) -> None:
    told = []
    for waited in (0.0, 100.0 * DAY):
        monitor = settings.monitor()
        monitor.maintain(SET)
        monitor.rest(waited)
        told.append(tension_after(monitor, 0))
    assert told[0].stddev < 10.0
    assert told[1].stddev > 20.0


def test_a_rest_counts_for_the_gap_in_which_it_was(settings: DriveSettings) -> None:
    """A later gap ages the belt again."""
    stddevs = []
    for rest in (0.0, 30.0 * DAY):
        monitor = settings.monitor()
        run(monitor, 300)
        monitor.rest(rest)
        run(monitor, 300, round(30.0 * DAY * 1e9))
        monitor.maintain(SET)
        stddevs.append(tension_after(monitor, round(60.0 * DAY * 1e9)).stddev)
    assert stddevs[1] == pytest.approx(stddevs[0], rel=0.2)


def test_a_belt_of_which_nothing_is_known_has_nothing_to_forget(settings: DriveSettings) -> None:
    monitor = settings.monitor()
    monitor.rest(DAY)
    assert monitor.learned(0.0) is None


@pytest.mark.parametrize("timely", [True, False])
def test_after_a_pause_one_odd_stamp_is_not_believed(taught: BeltMonitor, *, timely: bool) -> None:
    taught.pause()
    ahead = Measurement(3 * 10**11, 120.0, 120.0, 1.0, -1.0)
    output = taught.step(ahead, timely=timely)
    assert output.rejection is (Rejection.NONE if timely else Rejection.OUT_OF_ORDER)
    if not timely:
        run(taught, 10, 305 * STEP_NS)
        assert taught.health.resets == 0
        later = dataclasses.replace(ahead, stamp_ns=10**11)
        assert taught.step(later).rejection is Rejection.OUT_OF_ORDER  # the pause is over
