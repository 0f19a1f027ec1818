"""What is told of a drive's calibrations."""

from collections.abc import Callable

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from pipeline_harness import STEP_NS, calibrated, sliding

from belt_ros.estimation import Measurement
from belt_ros.node import services
from belt_ros.node.pipeline import Pipeline


def test_a_calibration_is_told_to_be_lost_as_soon_as_estimation_starts_anew() -> None:
    """Also where the drive stands, and nothing more comes; with what comes, once to the log."""
    pipeline = sliding()
    assert services.calibrate(pipeline).success
    running = pipeline.calibration_status()
    assert running is not None
    assert (running.level, running.values[0].value) == (DiagnosticStatus.OK, "1")

    pipeline.reset()
    lost = pipeline.calibration_status()
    assert lost is not None
    assert (lost.level, lost.values[0].value) == (DiagnosticStatus.WARN, "0")
    assert lost.message == "ratio not calibrated: the estimate was started anew"

    told = []
    for step in range(300, 303):
        stamp_ns = step * STEP_NS
        measurement = Measurement(stamp_ns, 120.0, 119.4, 30.0, -30.0)
        told.append(pipeline.take(measurement, stamp_ns, stamp_ns).calibration)
    assert [result.message for result in told if result is not None] == [lost.message]
    assert pipeline.calibration_status() == lost


@pytest.mark.parametrize("start_anew", [Pipeline.reset, Pipeline.give_up])
def test_a_calibration_that_a_start_at_the_priors_has_undone_is_told_to_be_lost(
    start_anew: Callable[[Pipeline], object],
) -> None:
    pipeline = calibrated()
    start_anew(pipeline)
    row = pipeline.calibration_status()
    assert row is not None
    assert row.level == DiagnosticStatus.WARN
    assert row.message == "ratio not calibrated: the estimate was started anew"
    assert "ratio bias [-]" not in {value.key for value in row.values}


def test_a_calibration_outlives_a_clock_that_goes_back() -> None:
    pipeline = calibrated()
    before = pipeline.calibration_status()
    assert pipeline.reset_after_jump(0)
    assert pipeline.calibration_status() == before
