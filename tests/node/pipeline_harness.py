"""Drives behind the node, without a graph, that have run for a while."""

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from node_harness import PAPER_DRIVE

from belt_ros.estimation import AlarmStatus, Measurement, Rejection, Severity
from belt_ros.node import services
from belt_ros.node.pipeline import Pipeline
from belt_ros.settings import load_settings

STEP_NS = 10_000_000


def sliding() -> Pipeline:
    """A drive whose belt has let go, which is told."""
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    for step in range(1, 200):
        driven = 119.4 if step < 100 else 60.0
        stamp_ns = step * STEP_NS
        pipeline.take(Measurement(stamp_ns, 120.0, driven, 30.0, -30.0), stamp_ns, stamp_ns)
    assert pipeline.alarm is not None
    assert pipeline.alarm.severity >= Severity.ALARM
    return pipeline


def calibrated() -> Pipeline:
    """A drive whose ratio has been calibrated, at no load."""
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    rng = np.random.default_rng(8)
    for step in range(1, 901):
        if step == 101:
            assert services.calibrate(pipeline).success
        noise = rng.normal(size=4) * (0.013, 0.013, 0.3, 0.3)
        stamp_ns = step * STEP_NS
        measurement = Measurement(stamp_ns, *(np.array([120.036, 120.0, 0.0, 0.0]) + noise))
        pipeline.take(measurement, stamp_ns, stamp_ns)
    row = pipeline.calibration_status()
    assert row is not None
    assert (row.level, row.values[0].value) == (DiagnosticStatus.OK, "0")
    return pipeline


class Waiting:
    """A drive whose sensors have never said anything."""

    def __init__(self) -> None:
        self.steady = 100.0
        self.pipeline = Pipeline(
            "node", ("/joint_states",), load_settings(PAPER_DRIVE), steady=lambda: self.steady
        )

    def wait(self, seconds: float, now: float, *, stands: bool = False) -> AlarmStatus | None:
        """Watch every tenth of a second, from a ROS time on; return what was told last."""
        told = None
        for tick in range(round(10 * seconds)):
            self.steady += 0.1
            outcome = self.pipeline.watch(round((now if stands else now + 0.1 * tick) * 1e9))
            told = outcome.alarm or told
        return told


def states_of(pipeline: Pipeline, samples: range) -> int:
    """Take in measurements of 100 Hz; return how many estimates came of them."""
    stamps = [sample * STEP_NS for sample in samples]
    outcomes = [
        pipeline.take(Measurement(each, 120.0, 119.4, 30.0, -30.0), each, each) for each in stamps
    ]
    assert all(outcome.reason is Rejection.NONE for outcome in outcomes)
    return sum(outcome.estimate is not None for outcome in outcomes)


def take_one(pipeline: Pipeline, seconds: float, driven: float = 119.4) -> AlarmStatus | None:
    """Take in a measurement at a time [s]; return the alarms' status if that is to be told."""
    stamp_ns = round(seconds * 1e9)
    row = Measurement(stamp_ns, 120.0, driven, 30.0, -30.0)
    return pipeline.take(row, stamp_ns, stamp_ns).alarm
