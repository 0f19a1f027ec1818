"""What was learned outlives the run, and what was done to the belt is taken in."""

import copy
import dataclasses
import math

import pytest
from runs import Run, Runner, within

from belt_ros.estimation import BeltMonitor
from belt_ros.estimation.maintenance import Maintenance, MaintenanceKind
from belt_ros.estimation.memory import Learned, MemoryRefusedError
from belt_ros.settings import DriveSettings

DATE = 1.7e9
DAY = 86400.0
DRIVE = {"condition__tension": 440.0, "condition__friction_stiffness": 6e6, "sample_rate": 100.0}
SHORT = {"duration": 0.5, "speed": 100.0, "load": 10.0, "seed": 9, **DRIVE}


@pytest.fixture(scope="module")
def taught(run: Runner, settings: DriveSettings) -> tuple[BeltMonitor, Run]:
    monitor = settings.monitor()
    played = run(
        monitor=monitor,
        duration=6.0,
        seed=4,
        speed=[[0.0, 0.0], [1.0, 120.0]],
        load=[[1.5, 0.0], [1.7, 30.0], [3.5, 30.0], [3.7, 58.0]],
        **DRIVE,
    )
    return monitor, played


@pytest.fixture(scope="module")
def learned(taught: tuple[BeltMonitor, Run]) -> Learned:
    known = taught[0].learned(DATE)
    assert known is not None
    return known


def test_there_is_nothing_learned_before_the_first_measurement(settings: DriveSettings) -> None:
    assert settings.monitor().learned(DATE) is None


def test_a_run_begins_with_what_the_last_one_learned(
    run: Runner, settings: DriveSettings, taught: tuple[BeltMonitor, Run], learned: Learned
) -> None:
    monitor = settings.monitor()
    assert monitor.restore(learned, DAY) == ""
    estimate, truth = run(monitor=monitor, **SHORT).at(0.4)
    before = taught[1].outputs[-1].estimate
    assert before is not None
    ignorant, _ = run(**SHORT).at(0.4)
    assert estimate.friction_stiffness_log_stddev < 0.3 * ignorant.friction_stiffness_log_stddev
    assert estimate.mean_tension.stddev < 0.8 * ignorant.mean_tension.stddev
    assert estimate.mean_tension.value == pytest.approx(before.mean_tension.value, rel=0.1)
    assert within(estimate.mean_tension, truth.mean_tension, 3.0)


def test_a_reset_goes_back_to_the_priors_and_not_to_the_memory(
    run: Runner, settings: DriveSettings, learned: Learned
) -> None:
    monitor = settings.monitor()
    monitor.restore(learned, 0.0)
    monitor.reset()
    estimate, _ = run(monitor=monitor, **SHORT).at(0.4)
    ignorant, _ = run(**SHORT).at(0.4)
    assert estimate.friction_stiffness == ignorant.friction_stiffness


def test_the_memory_of_another_drive_is_refused_and_nothing_changes(
    run: Runner, settings: DriveSettings, learned: Learned
) -> None:
    wider = dataclasses.replace(settings.drive.driven, radius=0.09)
    drive = dataclasses.replace(settings.drive, driven=wider)
    other = dataclasses.replace(settings, drive=drive)
    monitor = other.monitor()
    with pytest.raises(MemoryRefusedError, match="another drive"):
        monitor.restore(learned, 0.0)
    estimate, _ = run(drive=other, monitor=monitor, **SHORT).at(0.4)
    assert estimate == run(drive=other, **SHORT).at(0.4)[0]


def test_a_clock_set_back_is_said(settings: DriveSettings, learned: Learned) -> None:
    assert "clock was set back" in settings.monitor().restore(learned, -DAY)


@pytest.mark.parametrize("running", [False, True])
def test_a_new_tension_is_known_at_once_and_kf_is_kept(
    run: Runner, settings: DriveSettings, learned: Learned, *, running: bool
) -> None:
    monitor = settings.monitor()
    monitor.restore(learned, 0.0)
    if running:
        run(monitor=monitor, **SHORT)
    message = monitor.maintain(Maintenance(MaintenanceKind.RETENSIONED, 520.0, 10.0))
    assert "520" in message
    known = monitor.learned(DATE)
    if running:
        assert known is not None
        mean = float(known.weights @ known.means[:, 0])
        assert math.exp(mean) == pytest.approx(520.0, rel=0.01)
    after = {**SHORT, "condition__tension": 520.0}
    moved = settings.monitor() if running else monitor
    if running:
        assert known is not None
        moved.restore(known, 0.0)
    estimate, truth = run(monitor=moved, **after).at(0.4)
    assert within(estimate.mean_tension, truth.mean_tension, 3.0)
    assert estimate.mean_tension.stddev < 15.0
    assert estimate.friction_stiffness_log_stddev < 0.2


def test_a_measured_tension_settles_what_the_data_leave_open(
    run: Runner, settings: DriveSettings
) -> None:
    monitor = settings.monitor()
    monitor.maintain(Maintenance(MaintenanceKind.TENSION_MEASURED, 445.0, 9.0))
    estimate, truth = run(monitor=monitor, **SHORT).at(0.4)
    ignorant, _ = run(**SHORT).at(0.4)
    assert estimate.mean_tension.stddev < 0.2 * ignorant.mean_tension.stddev
    assert within(estimate.mean_tension, truth.mean_tension, 3.0)


def test_a_new_belt_makes_kf_unknown_again(
    run: Runner, settings: DriveSettings, learned: Learned
) -> None:
    monitor = settings.monitor()
    monitor.restore(learned, 0.0)
    monitor.maintain(Maintenance(MaintenanceKind.BELT_REPLACED))
    ignorant = settings.monitor()
    # At once: the ratio bias is known as before, with which kf is soon learned.
    ours, theirs = (run(monitor=one, **SHORT).at(0.0)[0] for one in (monitor, ignorant))
    assert ours.friction_stiffness_log_stddev == pytest.approx(
        theirs.friction_stiffness_log_stddev, rel=0.1
    )
    assert ours.mean_tension.stddev == pytest.approx(theirs.mean_tension.stddev, rel=0.1)


def test_what_was_set_before_the_first_measurement_is_learned(settings: DriveSettings) -> None:
    monitor = settings.monitor()
    monitor.maintain(Maintenance(MaintenanceKind.RETENSIONED, 520.0, 10.0))
    known = monitor.learned(DATE)
    assert known is not None
    assert math.exp(float(known.weights @ known.means[:, 0])) == pytest.approx(520.0, rel=0.01)


def test_a_bag_that_loops_begins_each_time_with_what_was_restored(
    run: Runner, settings: DriveSettings, learned: Learned
) -> None:
    monitor = settings.monitor()
    monitor.restore(learned, 0.0)
    measurements = run(**SHORT).measurements
    # The first two after the jump are not believed yet.
    later = [dataclasses.replace(m, stamp_ns=m.stamp_ns + 10**12) for m in measurements[2:]]
    first = [monitor.step(measurement).estimate for measurement in later][-1]
    second = [monitor.step(measurement).estimate for measurement in measurements][-1]
    assert first is not None
    assert second is not None
    assert second.health.resets == 1
    for name in ("mean_tension", "friction_stiffness", "ratio_bias"):
        assert getattr(second, name) == getattr(first, name)


def test_after_maintenance_under_load_a_backward_jump_begins_with_no_load(
    run: Runner, settings: DriveSettings
) -> None:
    monitor = settings.monitor()
    loaded = run(monitor=monitor, **{**SHORT, "load": 30.0}).measurements
    monitor.maintain(Maintenance(MaintenanceKind.RETENSIONED, 445.0, 9.0))
    idle = run(**{**SHORT, "load": 0.0}).measurements
    earlier = [dataclasses.replace(m, stamp_ns=m.stamp_ns - 10**12) for m in idle]
    for measurement in earlier[:10]:
        estimate = monitor.step(measurement).estimate
    assert len(loaded) > 0
    assert estimate is not None
    assert estimate.health.resets == 1
    assert within(estimate.transmitted_torque, 0.0, 4.0)
    assert estimate.mean_tension.stddev < 15.0


def test_what_is_restored_while_running_leaves_the_motion_as_it_is(
    run: Runner, settings: DriveSettings, learned: Learned
) -> None:
    monitor = settings.monitor()
    played = run(monitor=monitor, **SHORT)
    before, last = played.outputs[-1].estimate, played.measurements[-1]
    monitor.restore(learned, 0.0)
    after = monitor.step(dataclasses.replace(last, stamp_ns=last.stamp_ns + 10**7)).estimate
    assert before is not None
    assert after is not None
    assert after.transmitted_torque.stddev < 1.5 * before.transmitted_torque.stddev
    assert within(after.transmitted_torque, before.transmitted_torque.value, 3.0)


@pytest.mark.parametrize(("pause", "most"), [(60.0, 1.4), (3600.0, 1.4), (DAY, 2.0)])
def test_a_pause_costs_little_more_than_a_restart(
    settings: DriveSettings,
    taught: tuple[BeltMonitor, Run],
    learned: Learned,
    pause: float,
    most: float,
) -> None:
    last = taught[1].measurements[-1]
    paused, restarted = copy.deepcopy(taught[0]), settings.monitor()
    restarted.restore(learned, pause)
    for k in range(30):
        stamp_ns = last.stamp_ns + round(pause * 1e9) + k * 10**7
        later = dataclasses.replace(last, stamp_ns=stamp_ns)
        ours, theirs = paused.step(later).estimate, restarted.step(later).estimate
    assert ours is not None
    assert theirs is not None
    assert ours.stamp_ns == theirs.stamp_ns
    assert ours.friction_stiffness_log_stddev < 1.2 * theirs.friction_stiffness_log_stddev
    assert ours.mean_tension.stddev < most * theirs.mean_tension.stddev


LOSS = {
    "duration": 6.0,
    "seed": 4,
    "speed": [[0.0, 0.0], [1.0, 120.0]],
    "load": [[1.5, 0.0], [1.7, 38.0]],
    "events": [{"at": 3.0, "tension": 264.0, "over": 0.3}],
    **DRIVE,
}


@pytest.fixture(scope="module")
def loosened(run: Runner, settings: DriveSettings) -> BeltMonitor:
    """40 % of the tension has been lost, and told."""
    monitor = settings.monitor()
    estimate = run(monitor=monitor, **LOSS).outputs[-1].estimate
    assert estimate is not None
    assert estimate.lost_traction.traction > 0.95
    return monitor


def lost(run: Runner, monitor: BeltMonitor) -> float:
    estimate, _ = run(monitor=monitor, **{**SHORT, "condition__tension": 264.0}).at(0.4)
    return estimate.lost_traction.traction


def test_a_loss_does_not_vanish_with_the_end_of_a_run(
    run: Runner, settings: DriveSettings, loosened: BeltMonitor
) -> None:
    learned = loosened.learned(DATE)
    assert learned is not None
    monitor = settings.monitor()
    monitor.restore(learned, 60.0)
    assert lost(run, monitor) > 0.9


def test_a_belt_that_was_only_told_is_as_it_is_told_in_the_next_run(
    settings: DriveSettings, loosened: BeltMonitor
) -> None:
    learned = loosened.learned(DATE)
    assert learned is not None
    told = dataclasses.replace(settings, prior=dataclasses.replace(settings.prior, tension=300.0))
    monitor = told.monitor()
    monitor.restore(learned, 60.0)
    assert monitor.alarm.installed == 300.0


@pytest.mark.parametrize(
    ("kind", "tension", "told", "installed"),
    [
        (MaintenanceKind.TENSION_MEASURED, 264.0, True, "420 N"),
        (MaintenanceKind.RETENSIONED, 264.0, False, "264 N"),
        (MaintenanceKind.BELT_REPLACED, 264.0, False, "264 N"),
        (MaintenanceKind.BELT_REPLACED, math.nan, False, "420 N"),
    ],
)
def test_a_loss_is_over_once_the_belt_is_installed_anew_and_not_by_measuring(
    run: Runner,
    loosened: BeltMonitor,
    kind: MaintenanceKind,
    tension: float,
    told: bool,
    installed: str,
) -> None:
    monitor = copy.deepcopy(loosened)
    monitor.maintain(Maintenance(kind, tension, 0.02 * tension))
    assert (lost(run, monitor) > 0.95) is told
    status = monitor.acknowledge()
    assert status is not None
    assert f"installed {installed}" in status.message


def test_what_the_belt_was_re_tensioned_to_outlives_the_run_and_not_a_reset(
    run: Runner, settings: DriveSettings, loosened: BeltMonitor
) -> None:
    before, after = copy.deepcopy(loosened), settings.monitor()
    before.maintain(Maintenance(MaintenanceKind.RETENSIONED, 300.0, 6.0))
    learned = before.learned(DATE)
    assert learned is not None
    after.restore(learned, 60.0)
    assert after.alarm.installed == 300.0
    assert lost(run, after) < 0.5
    after.reset()
    assert after.alarm.installed == settings.prior.tension


def test_a_calibration_does_not_outlive_a_reset(run: Runner, settings: DriveSettings) -> None:
    monitor = settings.monitor()
    run(monitor=monitor, **SHORT)
    assert monitor.calibrate()
    monitor.reset()
    played = run(monitor=monitor, **{**SHORT, "duration": 8.0, "load": 0.0})
    assert all(output.calibration is None for output in played.outputs)
