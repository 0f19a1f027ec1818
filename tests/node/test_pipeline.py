"""One drive behind the node, without a graph."""

import math

from node_harness import PAPER_DRIVE

from belt_ros.estimation import AlarmStatus, Condition, Measurement, Severity
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


def test_after_a_reset_no_alarm_stands_that_no_measurement_has_raised_since() -> None:
    """Also where the drive stands, and nothing more comes."""
    pipeline = sliding()
    published: list[AlarmStatus] = []
    answer = services.reset(pipeline, None, published.append)
    assert answer.success
    (status,) = published
    assert pipeline.alarm is status
    assert (status.condition, status.severity) == (Condition.NONE, Severity.NORMAL)
    assert (status.latched_severity, status.acknowledged) == (Severity.NORMAL, True)
    assert status.conditions == ()
    assert status.count == 0
    assert all(map(math.isfinite, status.margin))
    assert "no alarm condition" in status.message


def test_a_reset_before_anything_came_has_no_alarm_to_take_back() -> None:
    published: list[AlarmStatus] = []
    pipeline = Pipeline("node", ("/joint_states",), load_settings(PAPER_DRIVE))
    assert services.reset(pipeline, None, published.append).success
    assert published == []
